//! Figure of friction at rest and at the crest, and of its fall, for each participant.

use plotting::{Axis, Figure, Ink, Key, Marker, Panel, Series, Width};

use crate::description::Description;
use crate::groups::{Group, Level};
use crate::quantity::Quantity;

/// Distance between two series at the same participant.
const APART: f64 = 0.16;

/// Draws the participants, or the trials if no participant is known; `None` without an instance.
#[must_use]
pub fn figure(description: &Description) -> Option<Figure> {
    let people: Vec<&Group> = described(description, Level::Participant);
    let (groups, name) = match people.is_empty() {
        true => (described(description, Level::Trial), "Recording"),
        false => (people, "Participant"),
    };
    if groups.is_empty() {
        return None;
    }
    let bars = |quantity: Quantity, shift: f64| -> Vec<(f64, f64, f64)> {
        let places = groups.iter().zip(1..);
        let bars = places.filter_map(|(group, place)| {
            let ends = group.mean(quantity).interval95?;
            let [low, high] = ends.map(|end| end * quantity.factor());
            Some((f64::from(place) + shift, low, high))
        });
        bars.collect()
    };
    let means = |quantity: Quantity, shift: f64| -> Vec<(f64, f64)> {
        let places = groups.iter().zip(1..);
        places
            .map(|(group, place)| {
                let value = group.mean(quantity).value * quantity.factor();
                (f64::from(place) + shift, value)
            })
            .collect()
    };
    // Trials of the participants, beside their means.
    let trials = |quantity: Quantity, shift: f64| -> Vec<(f64, f64)> {
        let members = description.level(Level::Trial).filter_map(|trial| {
            let is_theirs = |group: &&Group| {
                group.level == Level::Participant && group.participant == trial.participant
            };
            let place = groups.iter().position(is_theirs)?;
            let value = trial.mean(quantity).value * quantity.factor();
            Some((place as f64 + 1.0 + shift, value))
        });
        members.collect()
    };
    let names: Vec<String> = groups.iter().map(|group| place_name(group)).collect();
    let axis = |label: &str| Axis::linear(label).from_zero();
    let panel = |y: Axis, series: Vec<Series>, note: String| Panel {
        series,
        notes: vec![note],
        ..Panel::new(Axis::named(name, names.clone()), y)
    };
    let mut mu = Vec::new();
    for (quantity, ink, marker, shift, name) in [
        (
            Quantity::MuAtRest,
            Ink::Vermillion,
            Marker::Disc,
            -APART,
            "at rest",
        ),
        (
            Quantity::MuAtCrest,
            Ink::Blue,
            Marker::Square,
            APART,
            "at the crest",
        ),
    ] {
        mu.push(Series::bars(ink, bars(quantity, shift)));
        mu.push(Series::points(ink, marker, means(quantity, shift)).with_name(name));
    }
    let mut fall = vec![
        Series::points(Ink::Grey, Marker::Circle, trials(Quantity::Fall, APART)),
        Series::bars(Ink::Black, bars(Quantity::Fall, -APART)),
        Series::points(Ink::Black, Marker::Disc, means(Quantity::Fall, -APART)).with_name("mean"),
    ];
    if let Some(first) = fall
        .first_mut()
        .filter(|series| !series.extent().is_empty())
    {
        first.name = Some("trial".to_owned());
    }
    let n_instances: usize = groups.iter().map(|group| group.n_instances).sum();
    let n = format!("n = {}", groups.len());
    let keys = groups
        .iter()
        .map(|group| format!("{} ({})", place_name(group), group.over_text()));
    Some(Figure {
        name: "friction_fall".to_owned(),
        title: "Friction at rest and at the crest, and its fall".to_owned(),
        caption: format!(
            "Measured friction of {}: (a) in the first 5 ms of an instance, where the amplitude is least (at rest), and in its last 5 ms, \
             where it is greatest (at the crest); (b) the fall from rest to crest, relative to rest. Means of the trials, bars: 95 % \
             intervals by Student's t over the number in brackets, none for one alone; {n_instances} instances. {name}s: {}.",
            match name {
                "Participant" => format!("{} participants", groups.len()),
                _ => format!("{} recordings", groups.len()),
            },
            keys.collect::<Vec<_>>().join(", "),
        ),
        width: Width::Page,
        columns: 2,
        panel_height_mm: 55.0,
        footnote: None,
        key: Key::InPanels,
        panels: vec![
            panel(axis("Friction coefficient μ"), mu, n.clone()),
            panel(axis("Fall of μ (%)"), fall, n),
        ],
    })
}

fn place_name(group: &Group) -> String {
    group.label().trim_start_matches('\u{a0}').to_owned()
}

fn described(description: &Description, level: Level) -> Vec<&Group> {
    let groups = description.level(level);
    groups.filter(|group| group.n_instances > 0).collect()
}
