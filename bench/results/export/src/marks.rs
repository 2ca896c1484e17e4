//! Intervals and events of a recording.

use protocols::Direction;
use recording::Manifest;
use recording::manifest::{EventKind, RecordedIntervalKind};

use crate::column::{ExportedColumn, ExportedTable};

/// Returns the name of a direction in files; empty without one.
pub(crate) fn direction_name(direction: Option<Direction>) -> &'static str {
    match direction {
        Some(Direction::LeftToRight) => "left_to_right",
        Some(Direction::RightToLeft) => "right_to_left",
        None => "",
    }
}

/// Returns the name of a kind of interval in files, and the direction of an exploration.
pub(crate) fn interval_name(kind: RecordedIntervalKind) -> (&'static str, Option<Direction>) {
    match kind {
        RecordedIntervalKind::Unloaded => ("unloaded", None),
        RecordedIntervalKind::Exploration(direction) => ("exploration", Some(direction)),
    }
}

/// Returns the name of a kind of event, as in `recording.toml`, and its meaning.
pub(crate) fn event_words(kind: EventKind) -> (&'static str, &'static str) {
    match kind {
        EventKind::Gap => ("gap", "samples were lost"),
        EventKind::InputXrun => ("input_xrun", "the input stream reported an overrun"),
        EventKind::OutputXrun => (
            "output_xrun",
            "the output stream ran dry and the drive paused",
        ),
        EventKind::Clipping => (
            "clipping",
            "samples of drive or pickup reached the limits of the converter",
        ),
        EventKind::NonFinite => ("non_finite", "the converter gave NaN or infinity"),
        EventKind::ReadbackMismatch => (
            "readback_mismatch",
            "the drive was stopped because its read-back differed from the command",
        ),
        EventKind::ForceLost => ("force_lost", "readings of the force sensor were lost"),
        EventKind::SensorClock => (
            "sensor_clock",
            "a sensor restarted, or its readings disagree with its clock",
        ),
        EventKind::ForceOverRange => (
            "force_over_range",
            "an axis of the force sensor was at the end of its range",
        ),
        EventKind::PositionJump => (
            "position_jump",
            "positions further apart than a finger can move",
        ),
        EventKind::TimeDisorder => ("time_disorder", "times of a table do not increase"),
        EventKind::RecorderOverflow => (
            "recorder_overflow",
            "the disk was too slow; the recording ends there",
        ),
        EventKind::EmergencyStop => ("emergency_stop", "the emergency stop stopped the drive"),
        EventKind::Safe => ("safe", "another fault stopped the drive"),
        EventKind::Interference => (
            "interference",
            "a constant offset, mains hum or a foreign tone on drive or pickup",
        ),
        EventKind::Abort => ("abort", "the trial was aborted"),
        EventKind::Pause => ("pause", "a pause interrupted the trial"),
        EventKind::Resume => ("resume", "the session resumed with this trial"),
        EventKind::Redo => (
            "redo",
            "the trial is to be repeated, or is a further attempt",
        ),
        EventKind::Note => ("note", "a remark"),
    }
}

/// All kinds of events.
pub(crate) const EVENT_KINDS: [EventKind; 20] = [
    EventKind::Gap,
    EventKind::InputXrun,
    EventKind::OutputXrun,
    EventKind::Clipping,
    EventKind::NonFinite,
    EventKind::ReadbackMismatch,
    EventKind::ForceLost,
    EventKind::SensorClock,
    EventKind::ForceOverRange,
    EventKind::PositionJump,
    EventKind::TimeDisorder,
    EventKind::RecorderOverflow,
    EventKind::EmergencyStop,
    EventKind::Safe,
    EventKind::Interference,
    EventKind::Abort,
    EventKind::Pause,
    EventKind::Resume,
    EventKind::Redo,
    EventKind::Note,
];

/// Returns the table of intervals.
pub(crate) fn intervals(manifest: &Manifest) -> ExportedTable {
    let list = &manifest.intervals;
    let names = list.iter().map(|interval| interval_name(interval.kind));
    let (kinds, directions): (Vec<_>, Vec<_>) = names
        .map(|(kind, direction)| (kind.to_owned(), direction_name(direction).to_owned()))
        .unzip();
    ExportedTable {
        name: "intervals",
        rate_hz: None,
        rows: list.len() as u64,
        columns: vec![
            ExportedColumn::text(
                "kind",
                "unloaded: no finger on the plate; exploration: the finger slides",
                kinds,
            ),
            ExportedColumn::text(
                "direction",
                "direction of an exploration: left_to_right (growing position) or right_to_left; empty otherwise",
                directions,
            ),
            ExportedColumn::real(
                "start_s",
                "s",
                "start",
                list.iter().map(|interval| interval.start_s).collect(),
            ),
            ExportedColumn::real(
                "end_s",
                "s",
                "end",
                list.iter().map(|interval| interval.end_s).collect(),
            ),
        ],
    }
}

/// Returns the time of a sample, s, at a rate; NaN without one.
pub(crate) fn sample_time_s(sample: u64, rate_hz: Option<f64>) -> f64 {
    rate_hz.map_or(f64::NAN, |rate_hz| sample as f64 / rate_hz)
}

/// Returns the table of events, counted in samples at this rate.
pub(crate) fn events(manifest: &Manifest, rate_hz: Option<f64>) -> ExportedTable {
    let list = &manifest.events;
    let lengths_s = list.iter().map(|event| {
        event
            .frames
            .map_or(f64::NAN, |frames| sample_time_s(frames, rate_hz))
    });
    ExportedTable {
        name: "events",
        rate_hz: None,
        rows: list.len() as u64,
        columns: vec![
            ExportedColumn::text(
                "kind",
                "kind of event, by the names of recording.toml",
                list.iter()
                    .map(|event| event_words(event.kind).0.to_owned())
                    .collect(),
            ),
            ExportedColumn::real(
                "time_s",
                "s",
                "time of the event",
                list.iter()
                    .map(|event| sample_time_s(event.sample, rate_hz))
                    .collect(),
            ),
            ExportedColumn::real(
                "length_s",
                "s",
                "length; NaN or empty without one",
                lengths_s.collect(),
            ),
            ExportedColumn::text(
                "text",
                "details",
                list.iter()
                    .map(|event| event.text.clone().unwrap_or_default())
                    .collect(),
            ),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_have_the_names_of_recording_toml() {
        let names = EVENT_KINDS.map(|kind| event_words(kind).0);
        for (kind, name) in EVENT_KINDS.into_iter().zip(names) {
            assert_eq!(serde_json::to_value(kind).unwrap(), name);
        }
        let distinct: std::collections::BTreeSet<&str> = names.into_iter().collect();
        assert_eq!(distinct.len(), EVENT_KINDS.len());
    }
}
