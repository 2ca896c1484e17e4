//! Mistakes planted in recordings of simulated people and of an independent simulation: each is corrected or named. Recordings
//! without a mistake raise no such alarm.
//!
//! `./dev campaign import` takes ten people with all mistakes, and 200 people of all populations without one.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

mod columns;
mod forces_alone;
mod mistakes;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use analysis::estimate::InstanceEstimate;
use analysis::findings::RecordingFindings;
use analysis::flaw::Flaw;
use analysis::method::Method;
use rayon::prelude::*;
use reference_worlds::campaign::{repeats, report, results_path};

use columns::Columns;
use mistakes::Mistake;

/// Number of people with mistakes in every test run; `FRICTION_BENCH_PLANTED` asks for more.
const PEOPLE: usize = 1;
/// One mistake of so many is planted in every test run, in a campaign all.
const EVERY: usize = 9;
/// Number of people without a mistake in every test run; `FRICTION_BENCH_UNTOUCHED` asks for more.
const UNTOUCHED: usize = 2;
/// Scenarios of which the people without a mistake are drawn.
const POPULATIONS: [&str; 4] = [
    "population",
    "population-unkind",
    "finger-wide",
    "participant-late",
];
/// Strokes of a person with and without mistakes.
const STROKES: u32 = 1;
const UNTOUCHED_STROKES: u32 = 2;
/// Recordings of an independent simulation, in a campaign.
const REFERENCES: [&str; 3] = ["recording-a", "recording-c", "recording-d"];
/// Greatest share of recordings without a mistake that raise an alarm.
const GREATEST_ALARMS: f64 = 0.02;
/// Half width of a 95 % interval in standard errors.
const NORMAL_95: f64 = 1.96;

/// Outcome of a mistake in a recording.
#[derive(Debug)]
enum Outcome {
    /// A flaw or a refusal names it by the expected words.
    Named,
    /// Another flaw or refusal, which these words state.
    NamedOtherwise(String),
    /// The numbers are those without it, within their intervals.
    Harmless,
    /// No number is estimated, and no flaw says why.
    Unnamed,
    /// Numbers are wrong beyond their intervals.
    Silent(String),
}

/// Returns the words of a flaw without its numbers.
fn kind(flaw: &Flaw) -> String {
    let words = flaw.to_string();
    words
        .chars()
        .filter(|letter| letter.is_alphabetic())
        .collect()
}

/// Returns the medians of friction at rest and asperity scale with their standard errors, and the contact area.
fn numbers(findings: &RecordingFindings) -> BTreeMap<&'static str, (f64, f64)> {
    let instances = findings.instances.iter();
    let estimates: Vec<&InstanceEstimate> = instances
        .filter_map(|instance| instance.estimate(Method::Trial))
        .collect();
    let median = |value: fn(&InstanceEstimate) -> f64| {
        statistics::median(estimates.iter().map(|estimate| value(estimate)))
    };
    let pair = |value, std| median(value).zip(median(std));
    let area = findings.trial.as_ref().map(|fit| fit.contact_area_m2);
    let numbers = [
        (
            "mu0",
            pair(|estimate| estimate.mu0, |estimate| estimate.mu0_std),
        ),
        (
            "sigma_t",
            pair(
                |estimate| estimate.sigma_t_m(),
                |estimate| estimate.sigma_t_std_m(),
            ),
        ),
        ("S", area.map(|area| (area.value, area.value * area.ln_std))),
    ];
    let known = numbers
        .into_iter()
        .filter_map(|(name, pair)| Some((name, pair?)));
    known.collect()
}

/// Returns the outcome of a mistake that these words name, or another one.
fn named(mistake: &Mistake, words: String) -> Outcome {
    let mut expected = mistake.words.iter();
    if expected.any(|expected| words.contains(expected)) {
        Outcome::Named
    } else {
        Outcome::NamedOtherwise(words)
    }
}

/// Returns the outcome of a mistake in a recording with the `untouched` findings.
fn outcome(mistake: &Mistake, recording: &Columns, untouched: &RecordingFindings) -> Outcome {
    let mut planted = recording.clone();
    (mistake.plant)(&mut planted);
    let findings = match planted.analyse().map(|analysis| analysis.findings) {
        Err(refusal) => return named(mistake, refusal),
        Ok(Err(refusal)) => return named(mistake, refusal.to_string()),
        Ok(Ok(findings)) => findings,
    };
    let known: Vec<String> = untouched.flaws.iter().map(kind).collect();
    let new = findings
        .flaws
        .iter()
        .filter(|flaw| !known.contains(&kind(flaw)));
    let words: Vec<String> = new.map(ToString::to_string).collect();
    if !words.is_empty() {
        return named(mistake, words.join("\n"));
    }
    if findings.instances.is_empty() {
        return Outcome::Unnamed;
    }
    let (found, truth) = (numbers(&findings), numbers(untouched));
    let wrong = truth.iter().filter_map(|(name, (value, std))| {
        let Some((found, _)) = found.get(name) else {
            return Some(format!("no {name}"));
        };
        let is_wrong = (found - value).abs() > NORMAL_95 * std;
        is_wrong.then(|| format!("{name} {:+.0} %", 100.0 * (found / value - 1.0)))
    });
    let wrong: Vec<String> = wrong.collect();
    if wrong.is_empty() {
        Outcome::Harmless
    } else {
        Outcome::Silent(wrong.join(", "))
    }
}

/// Counts of the outcomes of a mistake.
#[derive(Debug, Default)]
struct Counts {
    named: usize,
    otherwise: usize,
    harmless: usize,
    notes: Vec<String>,
}

impl Counts {
    fn add(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Named => self.named += 1,
            Outcome::NamedOtherwise(words) => {
                self.otherwise += 1;
                self.notes.push(words);
            }
            Outcome::Harmless => self.harmless += 1,
            Outcome::Unnamed => self.notes.push("no estimate, and no flaw".to_owned()),
            Outcome::Silent(wrong) => self.notes.push(format!("silent: {wrong}")),
        }
    }

    fn silent(&self) -> usize {
        self.notes.len() - self.otherwise
    }
}

#[test]
fn mistakes_planted_in_simulated_people_are_corrected_or_named() {
    let people = repeats("FRICTION_BENCH_PLANTED", PEOPLE);
    let is_campaign = results_path().is_some();
    let seeds: Vec<u64> = (1..=people as u64).collect();
    let simulated = seeds
        .into_par_iter()
        .map(|seed| Columns::simulated("population-unkind", seed, STROKES));
    let mut recordings: Vec<Columns> = simulated.collect();
    if is_campaign {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference");
        recordings.extend(REFERENCES.map(|name| Columns::read(&folder.join(name))));
    }
    let all = mistakes::all();
    let step = if is_campaign { 1 } else { EVERY };
    let chosen: Vec<&Mistake> = all.iter().step_by(step).collect();
    let mut counts: BTreeMap<&str, Counts> = BTreeMap::new();
    for recording in &recordings {
        let untouched = recording.analyse().unwrap().findings.unwrap();
        assert!(!untouched.instances.is_empty(), "{:?}", untouched.rejected);
        let outcomes = chosen.par_iter().map(|mistake| {
            (
                mistake.name.as_str(),
                outcome(mistake, recording, &untouched),
            )
        });
        let outcomes: Vec<(&str, Outcome)> = outcomes.collect();
        for (name, outcome) in outcomes {
            counts.entry(name).or_default().add(outcome);
        }
    }
    let sum = |count: fn(&Counts) -> usize| counts.values().map(count).sum::<usize>();
    let mut text = format!(
        "{} mistakes each: {} named, {} by another name, {} without an effect, {} silent",
        chosen.len(),
        sum(|counts| counts.named),
        sum(|counts| counts.otherwise),
        sum(|counts| counts.harmless),
        sum(Counts::silent),
    );
    let noted = counts.iter().filter(|(_, counts)| !counts.notes.is_empty());
    let mut notes = String::new();
    for (name, counts) in noted.clone() {
        writeln!(notes, "{name}: {:?}", counts.notes).unwrap();
    }
    for (name, counts) in noted.filter(|(_, counts)| counts.silent() > 0) {
        write!(text, "; {name}: {} silent", counts.silent()).unwrap();
    }
    report("mistakes planted in recordings", recordings.len(), &text);
    assert_eq!(sum(Counts::silent), 0, "{notes}");
    assert!(
        50 * sum(|counts| counts.otherwise) <= recordings.len() * chosen.len(),
        "{notes}"
    );
}

/// Returns whether a flaw names a mistake of those that are planted.
fn is_alarm(flaw: &Flaw) -> bool {
    matches!(
        flaw,
        Flaw::Implausible(_)
            | Flaw::File(_)
            | Flaw::ElsewhereInTime { .. }
            | Flaw::Sparse { .. }
            | Flaw::ZeroTail { .. }
            | Flaw::CarrierMissing { .. }
            | Flaw::CarrierElsewhere { .. }
            | Flaw::Clipped { .. }
            | Flaw::PlateMass { .. }
            | Flaw::PlateReactance { .. }
            | Flaw::PickupLate { .. }
            | Flaw::Touched { .. }
            | Flaw::SteadyElsewhere { .. }
            | Flaw::EnvelopesFiltered { .. }
    )
}

#[test]
fn people_without_a_mistake_raise_no_alarm() {
    let people = repeats("FRICTION_BENCH_UNTOUCHED", UNTOUCHED);
    let numbers: Vec<usize> = (0..people).collect();
    let alarms = numbers.into_par_iter().filter_map(|number| {
        let scenario = POPULATIONS[number % POPULATIONS.len()];
        let seed = 1000 + number as u64;
        let recording = Columns::simulated(scenario, seed, UNTOUCHED_STROKES);
        let findings = recording.analyse().unwrap().findings.unwrap();
        let alarms = findings.flaws.iter().filter(|flaw| is_alarm(flaw));
        let words: Vec<String> = alarms.map(ToString::to_string).collect();
        (!words.is_empty()).then(|| format!("{scenario}, seed {seed}: {}", words.join("; ")))
    });
    let alarms: Vec<String> = alarms.collect();
    let text = format!("{} with an alarm: {}", alarms.len(), alarms.join(" | "));
    report("recordings without a mistake", people, &text);
    assert!(
        alarms.len() as f64 <= GREATEST_ALARMS * people as f64,
        "{text}"
    );
}
