//! Description of the study: a paragraph with the counts, the bench and the protocol, and the participants.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use maud::{Markup, html};
use published_statistics::{MethodStatistic, Statistic};
use study::provenance::Concern;

use crate::content::{RecordingEntry, ReportContent};
use crate::number::{MICRO, count_text, date, finite};

pub(crate) fn summary(content: &ReportContent<'_>, recordings: &[RecordingEntry<'_>]) -> Markup {
    let results = content.results;
    let instances: usize = recordings
        .iter()
        .map(|recording| recording.result.instances.len())
        .sum();
    let n_rejected: usize = recordings
        .iter()
        .map(|recording| recording.result.rejected.len())
        .sum();
    let n_excluded: usize = results
        .excluded
        .iter()
        .map(|exclusion| exclusion.recordings.len())
        .sum();
    let exclusions = results.exclusions_overridden.iter();
    let n_overridden: usize = exclusions.map(|exclusion| exclusion.recordings.len()).sum();
    let n_missed = results.attempts.missed().count();
    let warnings: usize = recordings
        .iter()
        .map(|recording| recording.result.warnings.len())
        .sum();
    let people: BTreeSet<&str> = recordings
        .iter()
        .filter_map(RecordingEntry::participant)
        .collect();
    let trials: Vec<_> = recordings
        .iter()
        .filter_map(|recording| recording.result.trial.as_ref())
        .collect();
    let misfits = trials.iter().filter(|trial| trial.model_misfit).count();
    let n_unreadable = recordings
        .iter()
        .filter(|recording| recording.manifest.is_none())
        .count();
    let sessions = content.sessions.list.len();
    let mut rows = results.statistics.rows.iter();
    let sigma_t = rows.find(|row| row.name == "sigma_t_m");
    let spread = |statistic: &Statistic| {
        format!(
            "{} µm ({})",
            MICRO.with_std(statistic.value, statistic.std),
            count_text(statistic.n, "instance", "instances")
        )
    };
    let sigma_t_by = |MethodStatistic { main, .. }: &MethodStatistic, name: &str| {
        finite(main.value).map(|_| format!("{} by {name}", spread(main)))
    };
    let phrases = sigma_t.map(|row| {
        [
            sigma_t_by(&row.trial, "trial"),
            sigma_t_by(&row.dynamic, "dynamic"),
            sigma_t_by(&row.paper, "paper"),
        ]
    });
    let phrases: Vec<String> = phrases.into_iter().flatten().flatten().collect();
    html! {
        p.lead {
            "Analysed: " (count_text(recordings.len() - n_unreadable, "recording", "recordings"))
            @if !people.is_empty() { " of " (count_text(people.len(), "participant", "participants")) }
            @if sessions > 0 { " in " (count_text(sessions, "session", "sessions")) }
            ", with "
            (count_text(instances, "estimated instance", "estimated instances")) "; "
            (count_text(n_rejected, "stretch was", "stretches were")) " rejected. "
            @if n_unreadable > 0 {
                (count_text(n_unreadable, "more", "more")) " could not be read. "
            }
            @if n_excluded > 0 {
                (count_text(n_excluded, "more recording is", "more recordings are")) " excluded by decision. "
            } @else if n_overridden > 0 {
                b {
                    (count_text(n_overridden, "of the recordings is", "of the recordings are"))
                    " excluded by decision, but analysed"
                }
                " (" a href="#left-out" { "decisions overridden" } "). "
            } @else { "No recording is excluded by decision. " }
            "According to the logs, " (count_text(results.attempts.accepted, "trial was", "trials were")) " accepted"
            @if n_missed > 0 { ", " b { (n_missed) " of which could not be analysed" } }
            " (" a href="#left-out" { "omitted data" } "). "
            @if warnings > 0 {
                "The analysis gave " a href="#flags" { (count_text(warnings, "warning", "warnings")) } ". "
            } @else { "The analysis gave no warning. " }
            @if !trials.is_empty() {
                "The model does not fit " (misfits) " of the "
                (count_text(trials.len(), "recording", "recordings"))
                " in which the fit was tested"
                @if misfits > 0 { "; all statistics here include their values by trial" }
                ". "
            }
            @if !phrases.is_empty() {
                "Over all instances σ" sub { "t" } " is " (phrases.join(", "))
                ", mean ± standard deviation (published: 1.7 ± 0.4 µm)."
            }
        }
        @for count in &results.provenance.counts {
            p.alert {
                b { (sentence_case(count.concern.name())) } ", " (count.phrase()) ": " (count.concern.consequence()) ". "
                @if count.concern == Concern::Uncalibrated { a href="#calibration" { "Calibration" } }
            }
        }
    }
}

/// Returns the text with a capital letter at its start.
fn sentence_case(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// Returns the distinct values in words, with their counts if there are several.
fn distinct_values<'a>(
    recordings: &[RecordingEntry<'a>],
    value: impl Fn(&RecordingEntry<'a>) -> Option<String>,
) -> Vec<(String, usize)> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for recording in recordings {
        if let Some(value) = value(recording) {
            *counts.entry(value).or_default() += 1;
        }
    }
    counts.into_iter().collect()
}

pub(crate) fn study(content: &ReportContent<'_>, recordings: &[RecordingEntry<'_>]) -> Markup {
    let hardware = |recording: &RecordingEntry<'_>| recording.manifest?.hardware.clone();
    let trial = |recording: &RecordingEntry<'_>| recording.manifest?.trial.clone();
    let rows: Vec<(&str, Vec<(String, usize)>)> = vec![
        (
            "Protocol",
            distinct_values(recordings, |recording| Some(trial(recording)?.protocol)),
        ),
        (
            "Condition",
            distinct_values(recordings, |recording| Some(trial(recording)?.condition)),
        ),
        (
            "Carrier",
            distinct_values(recordings, |recording| {
                Some(match recording.manifest?.carrier_hz() {
                    Some(carrier_hz) => format!("{} Hz", statistics::significant(carrier_hz)),
                    None if recording.manifest?.signals().is_some() => "moves".to_owned(),
                    None => "none: forces alone".to_owned(),
                })
            }),
        ),
        (
            "Modulation",
            distinct_values(recordings, |recording| {
                let modulation = recording.manifest?.modulation()?;
                Some(format!(
                    "{} Hz, index {}",
                    modulation.frequency_hz, modulation.index
                ))
            }),
        ),
        (
            "Audio input",
            distinct_values(recordings, |recording| {
                Some(hardware(recording)?.input_device)
            }),
        ),
        (
            "Audio output",
            distinct_values(recordings, |recording| {
                Some(hardware(recording)?.output_device)
            }),
        ),
        (
            "Samples",
            distinct_values(recordings, |recording| {
                let hardware = hardware(recording)?;
                Some(format!(
                    "{} Hz, {}",
                    hardware.sample_rate_hz, hardware.sample_format
                ))
            }),
        ),
        (
            "Force sensor",
            distinct_values(recordings, |recording| hardware(recording)?.force_sensor),
        ),
        (
            "Position sensor",
            distinct_values(recordings, |recording| hardware(recording)?.position_sensor),
        ),
        (
            "Safety stops waived",
            distinct_values(recordings, |recording| {
                let stops = hardware(recording)?.waived;
                (!stops.is_empty()).then(|| stops.join(", "))
            }),
        ),
        (
            "Recorded by",
            distinct_values(recordings, |recording| {
                let software = recording.manifest?.software.as_ref()?;
                Some(format!("{} {}", software.name, software.version))
            }),
        ),
        ("Recorded", session_dates(content)),
    ];
    html! {
        div.wide { table { tbody {
            @for (label, values) in rows.iter().filter(|(_, values)| !values.is_empty()) {
                tr {
                    th scope="row" { (label) }
                    td {
                        @for (index, (value, n)) in values.iter().enumerate() {
                            @if index > 0 { br; }
                            (value)
                            @if values.len() > 1 && *n > 0 {
                                " (" (count_text(*n, "recording", "recordings")) ")"
                            }
                        }
                    }
                }
            }
        } } }
    }
}

/// Returns the dates of the first and last session.
fn session_dates(content: &ReportContent<'_>) -> Vec<(String, usize)> {
    let sessions = content.sessions.list.iter();
    let starts = sessions.filter_map(|(_, session)| session.as_ref().ok()?.start.as_ref());
    let mut dates: Vec<Timestamp> = starts.filter_map(|start| start.time.parse().ok()).collect();
    dates.sort();
    match dates.as_slice() {
        [] => Vec::new(),
        [time] => vec![(date(*time), 0)],
        [first, .., last] if date(*first) == date(*last) => vec![(date(*first), 0)],
        [first, .., last] => vec![(format!("{} to {}", date(*first), date(*last)), 0)],
    }
}

pub(crate) fn participants(recordings: &[RecordingEntry<'_>]) -> Markup {
    let mut people: BTreeMap<Option<&str>, Vec<&RecordingEntry<'_>>> = BTreeMap::new();
    for recording in recordings {
        people
            .entry(recording.participant())
            .or_default()
            .push(recording);
    }
    let sessions = |recordings: &[&RecordingEntry<'_>]| {
        let numbers = recordings
            .iter()
            .filter_map(|recording| Some(recording.manifest?.participant.as_ref()?.session));
        numbers.collect::<BTreeSet<u32>>().len()
    };
    let instances = |recordings: &[&RecordingEntry<'_>]| -> usize {
        recordings
            .iter()
            .map(|recording| recording.result.instances.len())
            .sum()
    };
    let trial_instances = |recordings: &[&RecordingEntry<'_>]| -> usize {
        let person_instances = recordings
            .iter()
            .flat_map(|recording| &recording.result.instances);
        person_instances
            .filter(|instance| instance.trial.is_some())
            .count()
    };
    html! {
        p { "Participants are identified only by pseudonym; the personal details that they stated are not in this report." }
        div.wide { table {
            thead { tr {
                th { "Participant" } th.n { "Sessions" } th.n { "Recordings" } th.n { "Instances" }
                th.n { "By trial" }
            } }
            tbody { @for (person, recordings) in &people { tr {
                th scope="row" { (person.unwrap_or("not stated")) }
                td.n { (sessions(recordings)) }
                td.n { (recordings.len()) }
                td.n { (instances(recordings)) }
                td.n { (trial_instances(recordings)) }
            } } }
        } }
    }
}
