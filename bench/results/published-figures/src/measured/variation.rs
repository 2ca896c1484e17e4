//! Fig. 14: changes of impedance, gap and estimated friction against the change of friction.

use std::collections::BTreeSet;

use crate::measured::elements::{MICRO, assumption_note, ink, overlap_note, points};
use crate::measured::figure_selection::FigureSelection;
use analysis::findings::{Analysis, RecordingFindings};
use analysis::method::Method;
use analysis::sampled_quantity::SampledQuantity;
use correlations::Coefficient;
use plotting::number_text;
use plotting::{Axis, Dash, Figure, Ink, Key, Marker, Panel, Series, Width};
use published_statistics::{changes, changes_of};

/// Share of the range that a line of text takes.
const LINE_SHARE: f64 = 0.13;
/// Changes of more than this many times the median one lie beyond the frame, so that they do not flatten the others.
const WIDE: f64 = 20.0;
/// Markers of participants.
const MARKERS: [Marker; 4] = [
    Marker::Disc,
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
];

pub(super) fn figure(analysed: &Analysis, selection: &FigureSelection) -> Figure {
    let people = told_apart(analysed);
    let (mut n, mut n_trial, mut n_outside) = (0, 0, 0);
    let headroom = LINE_SHARE * selection.methods.len() as f64;
    let mut panel =
        |label: &str, change: SampledQuantity, coefficient: Coefficient, factor: f64| {
            let mut panel = Panel::new(
                Axis::linear("Δμ, measured"),
                Axis::linear(label).with_headroom(headroom),
            );
            for &method in &selection.methods {
                let pairs = changes(analysed, method, change);
                let (mu, delta): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
                if let Some(correlation) = coefficient.correlate(&delta, &mu) {
                    let symbol = match coefficient {
                        Coefficient::Spearman => "ρ",
                        Coefficient::Pearson => "r",
                    };
                    panel.notes.push(format!(
                        "{symbol} = {} ({})",
                        number_text(correlation.rho, 2),
                        method.name()
                    ));
                }
                n = pairs.len().max(n);
                if method == Method::Trial {
                    n_trial = pairs.len();
                }
                let scaled = |pairs: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
                    let pairs = pairs.into_iter();
                    pairs.map(|(mu, delta)| (mu, delta * factor)).collect()
                };
                if people.is_empty() {
                    panel.series.push(points(method, scaled(pairs)));
                }
                for (person, marker) in people.iter().zip(MARKERS) {
                    let pairs = scaled(changes_of(analysed, person, method, change));
                    let series = Series::points(ink(method), marker, pairs);
                    panel.series.push(series.with_name(method.name()));
                }
            }
            n_outside += frame(&mut panel, label, headroom);
            panel
        };
    let mut panels = vec![
        panel(
            "Δ|Zₘ| (N·s/m)",
            SampledQuantity::AbsZM,
            Coefficient::Spearman,
            1.0,
        ),
        panel(
            "Δ gap (µm)",
            SampledQuantity::Gap,
            Coefficient::Spearman,
            MICRO,
        ),
        panel(
            "Δμ, estimated",
            SampledQuantity::MuEstimated,
            Coefficient::Pearson,
            1.0,
        ),
    ];
    if let Some(first_panel) = panels.first_mut() {
        first_panel.notes.push(format!("n = {n} instances"));
        let names = people.iter().zip(MARKERS).map(|(person, marker)| {
            Series::points(Ink::Black, marker, Vec::new()).with_name(*person)
        });
        first_panel.series.extend(names);
    }
    if let Some(mu_panel) = panels.last_mut() {
        let values = mu_panel.series.iter().flat_map(Series::extent);
        let mus = values.map(|(mu, _)| mu).filter(|mu| mu.is_finite());
        let (least, greatest) = mus.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), mu| {
            (mu.min(a), mu.max(b))
        });
        let diagonal = vec![(least, least), (greatest, greatest)];
        let line = Series::line(Ink::Black, Dash::Dashed, diagonal).with_name("slope 1");
        mu_panel.series.push(line);
    }
    let note = if selection.methods.contains(&Method::Trial) && n_trial < n {
        format!(" ({n_trial} by trial)")
    } else {
        String::new()
    };
    Figure {
        name: "fig14_variation".to_owned(),
        title: "Variation of impedance, gap and estimated friction against that of friction"
            .to_owned(),
        caption: format!(
            "Maximum less minimum in an instance, over {n} instances{note}: (a) the modulus of the observed impedance, (b) the \
             levitation gap, (c) the estimated friction, against measured friction, with Spearman's ρ and Pearson's r (Huloux \
             2021, Fig. 14, who give ρ = 0.28 and 0.43 and r = 0.76 over 140 instances).{}{}{} {}",
            match n_outside {
                0 => String::new(),
                1 => " One point is outside a frame.".to_owned(),
                n => format!(" {n} points are outside the frames."),
            },
            if people.is_empty() {
                ""
            } else {
                " Ink: method; marker: participant."
            },
            overlap_note(selection),
            assumption_note(analysed, selection),
        ),
        width: Width::Page,
        columns: 3,
        panel_height_mm: 45.0,
        footnote: None,
        key: Key::Above,
        panels,
    }
}

/// Returns the participants, if there are several and each can have a marker.
fn told_apart(analysed: &Analysis) -> Vec<&str> {
    let people: Option<BTreeSet<&str>> = analysed
        .findings()
        .filter(|findings| !findings.instances.is_empty())
        .map(RecordingFindings::participant)
        .collect();
    let people = people.unwrap_or_default();
    match people.len() {
        2..=4 => people.into_iter().collect(),
        _ => Vec::new(),
    }
}

/// Fits the frame to all points but far outliers, with room for text above; returns the number of points outside.
fn frame(panel: &mut Panel, label: &str, headroom: f64) -> usize {
    let values = panel.series.iter().flat_map(Series::extent);
    let mut values: Vec<f64> = values.map(|(_, value)| value).collect();
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let (Some(least), Some(median)) = (values.first(), values.get(values.len() / 2)) else {
        return 0;
    };
    let is_inside = |value: &&f64| **value <= WIDE * median;
    let n_outside = values.len() - values.iter().filter(is_inside).count();
    if let (1.., Some(greatest)) = (n_outside, values.iter().rfind(is_inside)) {
        let margin = 0.05 * (greatest - least);
        let text_room = headroom * (greatest - least);
        panel.y = Axis::linear(label).with_range(least - margin, greatest + margin + text_room);
    }
    n_outside
}
