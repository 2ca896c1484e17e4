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

/// Returns the name of a kind of event, as in `recording.toml`.
pub(crate) fn event_name(kind: EventKind) -> String {
    let name = serde_json::to_value(kind).ok();
    let name = name.as_ref().and_then(serde_json::Value::as_str);
    name.unwrap_or_default().to_owned()
}

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

/// Returns the table of events, in a recording with this sample rate.
pub(crate) fn events(manifest: &Manifest, sample_rate_hz: f64) -> ExportedTable {
    let list = &manifest.events;
    let lengths_s = list.iter().map(|event| event.frames.map_or(f64::NAN, |frames| frames as f64 / sample_rate_hz));
    ExportedTable {
        name: "events",
        rate_hz: None,
        rows: list.len() as u64,
        columns: vec![
            ExportedColumn::text(
                "kind",
                "kind of event, by the names of recording.toml",
                list.iter().map(|event| event_name(event.kind)).collect(),
            ),
            ExportedColumn::real(
                "time_s",
                "s",
                "time of the event",
                list.iter().map(|event| event.sample as f64 / sample_rate_hz).collect(),
            ),
            ExportedColumn::real("length_s", "s", "length; NaN or empty without one", lengths_s.collect()),
            ExportedColumn::text(
                "text",
                "details",
                list.iter().map(|event| event.text.clone().unwrap_or_default()).collect(),
            ),
        ],
    }
}
