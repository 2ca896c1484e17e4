//! Skin of a study as lines for a terminal.

use statistics::error_decimals;

use crate::skin::parameters::{PersonSkin, Ranged, Skin, StudyParameter};

/// Symbol, factor from the SI unit, decimals and unit of each parameter, in order.
const FORMATS: [(&str, f64, usize, &str); 4] = [
    ("S", 1e6, 0, " mm²"),
    ("q0", 1e-4, 2, " × 10⁴ rad/m"),
    ("η", 1.0, 3, ""),
    ("τ", 1e3, 2, " ms"),
];

impl Skin {
    /// Returns the lines of each participant with the 95 % intervals of the means, and those of the study: each mean has a line
    /// with the laws in doubt included, and one within the published laws. No lines if there are no participants.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.participants.iter().flat_map(person_lines).collect();
        let parameters = self.study.as_array();
        let people = parameters
            .map(|parameter| parameter.n_participants)
            .into_iter()
            .max();
        let people = people.filter(|_| parameters.iter().any(|parameter| parameter.mean.is_some()));
        if let Some(people) = people {
            let means = parameters.map(|parameter| parameter.mean);
            lines.push(format!(
                "mean of {people} participants{}",
                words(means, total)
            ));
            lines.extend(line_within_laws(means));
            let spread =
                |(parameter, (symbol, ..)): (&StudyParameter, (&str, f64, usize, &str))| {
                    let std = parameter.between_participants_ln_std?;
                    let decimals = error_decimals(100.0 * std, 0);
                    Some(format!("{symbol} ± {:.decimals$} %", 100.0 * std))
                };
            let spread: Vec<String> = parameters
                .into_iter()
                .zip(FORMATS)
                .filter_map(spread)
                .collect();
            lines.push(format!("between participants: {}", spread.join(", ")));
        }
        lines
    }
}

fn person_lines(person: &PersonSkin) -> Vec<String> {
    let means = person
        .parameters
        .as_array()
        .map(|parameter| parameter.map(|parameter| parameter.mean));
    let trials = match person.trials.len() {
        1 => "1 trial".to_owned(),
        n => format!("{n} trials"),
    };
    let left_out = match person.n_left_out {
        0 => String::new(),
        n => format!(", {n} left out"),
    };
    let name = &person.participant;
    let words = words(means, total);
    let mut lines = vec![format!("skin of {name}, {trials}{left_out}{words}")];
    lines.extend(line_within_laws(means));
    lines
}

/// An interval of a range.
type IntervalOf = fn(&Ranged) -> Option<[f64; 2]>;

fn total(range: &Ranged) -> Option<[f64; 2]> {
    Some(range.interval95)
}

fn line_within_laws(means: [Option<Ranged>; 4]) -> Option<String> {
    let words = words(means, |range| range.interval95_within_laws);
    (!words.is_empty()).then(|| format!("  within the published laws{words}"))
}

fn words(means: [Option<Ranged>; 4], interval: IntervalOf) -> String {
    let texts = means.into_iter().zip(FORMATS);
    let texts = texts.filter_map(|(mean, (symbol, factor, decimals, unit))| {
        let [low, high] = interval(&mean?)?.map(|end| end * factor);
        Some(format!(
            "{symbol} {low:.decimals$} to {high:.decimals$}{unit}"
        ))
    });
    let texts: Vec<String> = texts.collect();
    match texts.is_empty() {
        true => String::new(),
        false => format!(": {}", texts.join(", ")),
    }
}
