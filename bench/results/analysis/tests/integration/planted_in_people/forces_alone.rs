//! Mistakes in recordings of forces and positions alone: a friction that is wrong has a name.

use std::fmt::Write;

use analysis::findings::RecordingFindings;
use rayon::prelude::*;
use reference_worlds::campaign::{repeats, report, results_path};

use super::columns::Columns;
use super::mistakes::{self, Mistake};
use super::{Counts, EVERY, Outcome, PEOPLE, POPULATIONS, UNTOUCHED, is_alarm, kind, named};

/// Strokes of a person, there and back.
const STROKES: u32 = 2;
/// Greatest change of a stroke's mean friction, and of its contrast, that counts as none.
const EQUAL: f64 = 0.03;

/// Words of mistakes in the clock of the forces.
const CLOCK_WORDS: [&str; 2] = ["the forces come", "its times are on a clock"];
/// Words of forces that do not last as long as the recording.
const SHORT: &str = "but the recording ends at";

/// Returns the mean friction of each stroke, and the contrast of the stimulus in it.
fn frictions(findings: &RecordingFindings) -> Vec<[f64; 2]> {
    let strokes = findings
        .explorations
        .iter()
        .map(|exploration| &exploration.stroke);
    strokes
        .map(|stroke| {
            [
                stroke.mu,
                stroke.effect.map_or(f64::NAN, |effect| effect.contrast),
            ]
        })
        .collect()
}

/// Returns the outcome of a mistake in a recording with the `untouched` findings.
fn outcome(mistake: &Mistake, recording: &Columns, untouched: &RecordingFindings) -> Outcome {
    let mut planted = recording.clone();
    (mistake.plant)(&mut planted);
    let findings = match planted.analyse_forces_alone().findings {
        Err(refusal) => return named(mistake, refusal.to_string()),
        Ok(findings) => findings,
    };
    let known: Vec<String> = untouched.flaws.iter().map(kind).collect();
    let flaws = findings.flaws.iter();
    let new = flaws.filter(|flaw| !known.contains(&kind(flaw)));
    let words: Vec<String> = new.map(ToString::to_string).collect();
    if !words.is_empty() {
        let is_short = words.iter().any(|word| word.contains(SHORT));
        return match named(mistake, words.join("\n")) {
            Outcome::NamedOtherwise(_) if is_short => Outcome::Named,
            outcome => outcome,
        };
    }
    let (found, truth) = (frictions(&findings), frictions(untouched));
    if found.is_empty() || found.iter().all(|[mu, _]| mu.is_nan()) {
        return Outcome::Unnamed;
    }
    if found.len() != truth.len() {
        return Outcome::Silent(format!("{} of {} strokes", found.len(), truth.len()));
    }
    let pairs = found.iter().flatten().zip(truth.iter().flatten());
    let wrong = pairs.filter(|(value, truth)| {
        let change = (*value / *truth - 1.0).abs();
        change > EQUAL || value.is_nan() != truth.is_nan()
    });
    let wrong: Vec<String> = wrong
        .map(|(value, truth)| format!("{value:.3} for {truth:.3}"))
        .collect();
    if wrong.is_empty() {
        Outcome::Harmless
    } else {
        Outcome::Silent(wrong.join(", "))
    }
}

#[test]
fn mistakes_in_forces_alone_are_named() {
    let people = repeats("FRICTION_BENCH_PLANTED", PEOPLE);
    let seeds: Vec<u64> = (1..=people as u64).collect();
    let simulated = seeds
        .into_par_iter()
        .map(|seed| Columns::simulated("population-unkind", seed, STROKES));
    let recordings: Vec<Columns> = simulated.collect();
    // Without the film nothing shows the clock of the forces.
    let mut all = mistakes::of_sensors();
    all.retain(|mistake| !mistake.words.iter().any(|word| CLOCK_WORDS.contains(word)));
    let step = if results_path().is_some() { 1 } else { EVERY };
    let chosen: Vec<&Mistake> = all.iter().step_by(step).collect();
    let mut counts = Counts::default();
    for recording in &recordings {
        let untouched = recording.analyse_forces_alone().findings.unwrap();
        assert!(
            frictions(&untouched)
                .iter()
                .flatten()
                .all(|value| value.is_finite())
        );
        let outcomes = chosen
            .par_iter()
            .map(|mistake| (mistake, outcome(mistake, recording, &untouched)));
        for (mistake, outcome) in outcomes.collect::<Vec<_>>() {
            let name = &mistake.name;
            counts.add(match outcome {
                Outcome::NamedOtherwise(words) => {
                    Outcome::NamedOtherwise(format!("{name}: {words}"))
                }
                Outcome::Silent(words) => Outcome::Silent(format!("{name}: {words}")),
                Outcome::Unnamed => Outcome::Silent(format!("{name}: no friction, and no flaw")),
                other => other,
            });
        }
    }
    let text = format!(
        "{} mistakes each: {} named, {} by another name, {} without an effect on friction, {} silent",
        chosen.len(),
        counts.named,
        counts.otherwise,
        counts.harmless,
        counts.silent(),
    );
    report("mistakes planted in forces alone", recordings.len(), &text);
    let mut notes = String::new();
    for note in &counts.notes {
        writeln!(notes, "{note}").unwrap();
    }
    assert_eq!(counts.silent(), 0, "{text}\n{notes}");
    assert!(
        20 * counts.otherwise <= recordings.len() * chosen.len(),
        "{text}\n{notes}"
    );
}

#[test]
fn forces_alone_without_a_mistake_raise_no_alarm() {
    let people = repeats("FRICTION_BENCH_UNTOUCHED", UNTOUCHED);
    let numbers: Vec<usize> = (0..people).collect();
    let alarms = numbers.into_par_iter().filter_map(|number| {
        let scenario = POPULATIONS[number % POPULATIONS.len()];
        let seed = 2000 + number as u64;
        let recording = Columns::simulated(scenario, seed, STROKES);
        let findings = recording.analyse_forces_alone().findings.unwrap();
        let alarms = findings.flaws.iter().filter(|flaw| is_alarm(flaw));
        let words: Vec<String> = alarms.map(ToString::to_string).collect();
        (!words.is_empty()).then(|| format!("{scenario}, seed {seed}: {}", words.join("; ")))
    });
    let alarms: Vec<String> = alarms.collect();
    let text = format!("{} with an alarm: {}", alarms.len(), alarms.join(" | "));
    report("forces alone without a mistake", people, &text);
    assert!(50 * alarms.len() <= people, "{text}");
}
