//! Description of the study: a paragraph with the counts, the bench and the protocol, and the participants.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use maud::{Markup, html};

use crate::content::{Content, Of};
use crate::number::{MICRO, counted, date};
use crate::results::{Results, Statistic};

pub(crate) fn summary(content: &Content<'_>, results: &Results, recordings: &[Of<'_>]) -> Markup {
    let instances: usize = recordings.iter().map(|of| of.result.instances.len()).sum();
    let rejected: usize = recordings.iter().map(|of| of.result.rejected.len()).sum();
    let excluded: usize = results.excluded.iter().map(|of| of.recordings.len()).sum();
    let overridden = results.exclusions_overridden.iter();
    let overridden: usize = overridden.map(|of| of.recordings.len()).sum();
    let missed = results.attempts.iter().flat_map(|of| &of.left_out);
    let missed = missed.filter(|of| of.is_missed()).count();
    let warnings: usize = recordings.iter().map(|of| of.result.warnings.len()).sum();
    let people: BTreeSet<&str> = recordings.iter().filter_map(Of::participant).collect();
    let trials: Vec<_> = recordings
        .iter()
        .filter_map(|of| of.result.trial.as_ref())
        .collect();
    let judged: Vec<bool> = trials.iter().filter_map(|trial| trial.misfit()).collect();
    let misfits = judged.iter().filter(|misfit| **misfit).count();
    let unreadable = recordings.iter().filter(|of| of.manifest.is_none()).count();
    let sessions = content.sessions.list.len();
    let name = |(name, _): &&(String, _)| name == "sigma_t_m";
    let sigma_t = results.statistics.iter().find(name).map(|(_, row)| row);
    let spread = |of: &Statistic| {
        format!(
            "{} µm ({})",
            MICRO.with_std(of.value, of.std),
            counted(of.n as usize, "instance", "instances")
        )
    };
    let by = |found: Option<&crate::results::Found>, name: &str| {
        let main = found
            .map(|found| &found.main)
            .filter(|of| of.value.is_some())?;
        Some(format!("{} by {name}", spread(main)))
    };
    let by = sigma_t.map(|row| {
        [
            by(row.trial.as_ref(), "trial"),
            by(row.dynamic.as_ref(), "dynamic"),
            by(row.paper.as_ref(), "paper"),
        ]
    });
    let by: Vec<String> = by.into_iter().flatten().flatten().collect();
    html! {
        p.lead {
            (counted(recordings.len() - unreadable, "recording", "recordings"))
            @if !people.is_empty() { " of " (counted(people.len(), "participant", "participants")) }
            @if sessions > 0 { " in " (counted(sessions, "session", "sessions")) }
            " were analysed and gave "
            (counted(instances, "estimated instance", "estimated instances")) "; "
            (counted(rejected, "stretch was", "stretches were")) " rejected. "
            @if unreadable > 0 {
                (counted(unreadable, "more", "more")) " could not be read. "
            }
            @if excluded > 0 {
                (counted(excluded, "more recording is", "more recordings are")) " excluded by decision. "
            } @else if overridden > 0 {
                b { (counted(overridden, "of the recordings is", "of the recordings are")) " excluded by decision, and analysed all the same" }
                " (" a href="#left-out" { "decisions overridden" } "). "
            } @else { "No recording is excluded by decision. " }
            @if let Some(attempts) = &results.attempts {
                "By the logs " (counted(attempts.accepted, "trial was", "trials were")) " accepted"
                @if missed > 0 { ", " b { (missed) " of which could not be analysed" } }
                " (" a href="#left-out" { "what is left out" } "). "
            }
            @if warnings > 0 {
                "The analysis gave " a href="#flags" { (counted(warnings, "warning", "warnings")) } ". "
            } @else { "The analysis gave no warning. " }
            @if !judged.is_empty() {
                "The model was held not to fit in " (misfits) " of the " (counted(judged.len(), "recording", "recordings"))
                " where that was judged"
                @if misfits > 0 { ", whose values by trial are in all statistics here" }
                ". "
            }
            @if !by.is_empty() {
                "Over all instances σ" sub { "t" } " is " (by.join(", "))
                ", mean ± standard deviation (published: 1.7 ± 0.4 µm)."
            }
        }
        @if recordings.iter().any(|of| is_rehearsed(of)) {
            p.alert { "Faults were injected on purpose into some of these recordings: they are a rehearsal, not data." }
        }
        @if let Some(words) = on_a_simulated_bench(simulated(content), sessions) {
            p.alert { (words) }
        }
        @if recordings.iter().any(Of::is_uncalibrated) {
            p.alert {
                "Some of these recordings were made without a calibration: their constants are those of the configuration, and \
                 were not measured. " a href="#calibration" { "Calibration" }
            }
        }
    }
}

fn is_rehearsed(of: &Of<'_>) -> bool {
    let hardware = of.manifest.and_then(|manifest| manifest.hardware.as_ref());
    hardware.is_some_and(|hardware| !hardware.rehearsed.is_empty())
}

/// Returns the number of sessions recorded on a simulated bench.
fn simulated(content: &Content<'_>) -> usize {
    let starts = content.sessions.list.iter();
    let starts = starts.filter_map(|(_, session)| session.as_ref().ok()?.start.as_ref());
    let is_simulated = |is: &String| is == "true";
    starts
        .filter(|start| start.devices.get("simulated").is_some_and(is_simulated))
        .count()
}

/// Returns a sentence on the number of simulated sessions; `None` if all were recorded on a real bench.
fn on_a_simulated_bench(simulated: usize, sessions: usize) -> Option<String> {
    match simulated {
        0 => None,
        all if all == sessions => {
            Some("Recorded on a simulated bench: nobody took part.".to_owned())
        }
        some => Some(format!(
            "{some} of {sessions} sessions were recorded on a simulated bench: nobody took part in {}.",
            if some == 1 { "it" } else { "them" }
        )),
    }
}

/// Returns the distinct values in words, with their counts if there are several.
fn distinct<'a>(
    recordings: &[Of<'a>],
    value: impl Fn(&Of<'a>) -> Option<String>,
) -> Vec<(String, usize)> {
    let mut found: BTreeMap<String, usize> = BTreeMap::new();
    for of in recordings {
        if let Some(value) = value(of) {
            *found.entry(value).or_default() += 1;
        }
    }
    found.into_iter().collect()
}

pub(crate) fn study(content: &Content<'_>, recordings: &[Of<'_>]) -> Markup {
    let hardware = |of: &Of<'_>| of.manifest?.hardware.clone();
    let trial = |of: &Of<'_>| of.manifest?.trial.clone();
    let rows: Vec<(&str, Vec<(String, usize)>)> = vec![
        (
            "Protocol",
            distinct(recordings, |of| Some(trial(of)?.protocol)),
        ),
        (
            "Condition",
            distinct(recordings, |of| Some(trial(of)?.condition)),
        ),
        (
            "Carrier",
            distinct(recordings, |of| {
                Some(format!("{} Hz", of.manifest?.carrier_hz))
            }),
        ),
        (
            "Modulation",
            distinct(recordings, |of| {
                let manifest = of.manifest?;
                Some(format!(
                    "{} Hz, index {}",
                    manifest.modulation_hz, manifest.modulation_index
                ))
            }),
        ),
        (
            "Audio input",
            distinct(recordings, |of| Some(hardware(of)?.input_device)),
        ),
        (
            "Audio output",
            distinct(recordings, |of| Some(hardware(of)?.output_device)),
        ),
        (
            "Samples",
            distinct(recordings, |of| {
                let hardware = hardware(of)?;
                Some(format!(
                    "{} Hz, {}",
                    hardware.sample_rate_hz, hardware.sample_format
                ))
            }),
        ),
        (
            "Force sensor",
            distinct(recordings, |of| hardware(of)?.force_sensor),
        ),
        (
            "Position sensor",
            distinct(recordings, |of| hardware(of)?.position_sensor),
        ),
        (
            "Safety stops waived",
            distinct(recordings, |of| {
                let waived = hardware(of)?.waived;
                (!waived.is_empty()).then(|| waived.join(", "))
            }),
        ),
        (
            "Recorded by",
            distinct(recordings, |of| {
                let software = of.manifest?.software.as_ref()?;
                Some(format!("{} {}", software.name, software.version))
            }),
        ),
        ("Recorded", recorded(content)),
    ];
    html! {
        div.wide { table { tbody {
            @for (label, values) in rows.iter().filter(|(_, values)| !values.is_empty()) {
                tr {
                    th scope="row" { (label) }
                    td {
                        @for (at, (value, n)) in values.iter().enumerate() {
                            @if at > 0 { br; }
                            (value)
                            @if values.len() > 1 && *n > 0 {
                                " (" (counted(*n, "recording", "recordings")) ")"
                            }
                        }
                    }
                }
            }
        } } }
    }
}

/// Returns the dates of the first and last session.
fn recorded(content: &Content<'_>) -> Vec<(String, usize)> {
    let sessions = content.sessions.list.iter();
    let starts = sessions.filter_map(|(_, session)| session.as_ref().ok()?.start.as_ref());
    let mut dates: Vec<Timestamp> = starts.filter_map(|of| of.time.parse().ok()).collect();
    dates.sort();
    match dates.as_slice() {
        [] => Vec::new(),
        [one] => vec![(date(*one), 0)],
        [first, .., last] if date(*first) == date(*last) => vec![(date(*first), 0)],
        [first, .., last] => vec![(format!("{} to {}", date(*first), date(*last)), 0)],
    }
}

pub(crate) fn participants(recordings: &[Of<'_>]) -> Markup {
    let mut people: BTreeMap<Option<&str>, Vec<&Of<'_>>> = BTreeMap::new();
    for of in recordings {
        people.entry(of.participant()).or_default().push(of);
    }
    let sessions = |of: &[&Of<'_>]| {
        let numbers = of
            .iter()
            .filter_map(|of| Some(of.manifest?.participant.as_ref()?.session));
        numbers.collect::<BTreeSet<u32>>().len()
    };
    let instances =
        |of: &[&Of<'_>]| -> usize { of.iter().map(|of| of.result.instances.len()).sum() };
    let by_trial = |of: &[&Of<'_>]| -> usize {
        let all = of.iter().flat_map(|of| &of.result.instances);
        all.filter(|instance| instance.trial.is_some()).count()
    };
    html! {
        p { "Known by pseudonym alone. What participants stated of themselves is not in this report." }
        div.wide { table {
            thead { tr {
                th { "Participant" } th.n { "Sessions" } th.n { "Recordings" } th.n { "Instances" }
                th.n { "of them by trial" }
            } }
            tbody { @for (person, of) in &people { tr {
                th scope="row" { (person.unwrap_or("not stated")) }
                td.n { (sessions(of)) }
                td.n { (of.len()) }
                td.n { (instances(of)) }
                td.n { (by_trial(of)) }
            } } }
        } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_took_part_in_the_simulated_sessions_and_in_no_others() {
        assert_eq!(on_a_simulated_bench(0, 3), None);
        let words = |simulated| on_a_simulated_bench(simulated, 3).unwrap();
        assert!(words(3).starts_with("Recorded on a simulated bench: nobody"));
        assert!(words(1).starts_with("1 of 3 sessions "));
        assert!(words(2).ends_with("nobody took part in them."));
    }
}
