//! Skin of a study as lines for a terminal.

use crate::skin::{OfStudy, Person, Ranged, Skin};

/// Symbol, factor from the SI unit, decimals and unit of each parameter, in order.
const SHOWN: [(&str, f64, usize, &str); 4] = [
    ("S", 1e6, 0, " mm²"),
    ("q0", 1e-4, 2, " × 10⁴ rad/m"),
    ("η", 1.0, 3, ""),
    ("τ", 1e3, 2, " ms"),
];

impl Skin {
    /// Returns a line for each participant with the 95 % intervals of the means, and two for the study; no lines if there
    /// are no participants.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.participants.iter().map(of_person).collect();
        let of_study = self.study.in_order();
        let people = of_study.map(|of| of.n_participants).into_iter().max();
        let people = people.filter(|_| of_study.iter().any(|of| of.mean.is_some()));
        if let Some(people) = people {
            let means = of_study.map(|of| of.mean);
            lines.push(format!("mean of {people} participants{}", words(means)));
            let spread = |(of, (symbol, ..)): (&OfStudy, (&str, f64, usize, &str))| {
                let of = of.between_participants_ln_std?;
                Some(format!("{symbol} ± {:.0} %", 100.0 * of))
            };
            let spread: Vec<String> = of_study.into_iter().zip(SHOWN).filter_map(spread).collect();
            lines.push(format!("between participants: {}", spread.join(", ")));
        }
        lines
    }
}

fn of_person(person: &Person) -> String {
    let means = person.parameters.in_order().map(|of| of.map(|of| of.mean));
    let trials = match person.trials.len() {
        1 => "1 trial".to_owned(),
        n => format!("{n} trials"),
    };
    let left_out = match person.n_left_out {
        0 => String::new(),
        n => format!(", {n} left out"),
    };
    let name = &person.participant;
    format!("skin of {name}, {trials}{left_out}{}", words(means))
}

fn words(means: [Option<Ranged>; 4]) -> String {
    let each = means.into_iter().zip(SHOWN);
    let each = each.filter_map(|(mean, (symbol, factor, decimals, unit))| {
        let [from, to] = mean?.interval95.map(|end| end * factor);
        Some(format!(
            "{symbol} {from:.decimals$} to {to:.decimals$}{unit}"
        ))
    });
    let each: Vec<String> = each.collect();
    match each.is_empty() {
        true => String::new(),
        false => format!(": {}", each.join(", ")),
    }
}
