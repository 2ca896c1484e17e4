//! Sidecars: descriptions in JSON of the tables.

use serde_json::{Map, Value, json};

use crate::bids::names::TASK;
use crate::column::ExportedTable;
use crate::content::RecordingContent;
use crate::marks::{EVENT_KINDS, event_words};
use crate::recorded_tables::STIMULUS;
use crate::stream::RowTimes;

/// Returns the text of a JSON file.
pub(crate) fn to_text(value: &Value) -> String {
    format!("{value:#}\n")
}

/// Returns the sidecar of a table without a header, with rows at `rate_hz` from `start_s` on.
pub(crate) fn series(
    content: &RecordingContent,
    table: &ExportedTable,
    (rate_hz, start_s): (f64, f64),
) -> String {
    let mut sidecar = task(content);
    let names = table.columns.iter().map(|column| &*column.name);
    sidecar.insert("SamplingFrequency".to_owned(), rate_hz.into());
    sidecar.insert("StartTime".to_owned(), start_s.into());
    sidecar.insert("Columns".to_owned(), names.collect());
    if table.name != STIMULUS {
        sidecar.insert("PhysioType".to_owned(), "generic".into());
    }
    for column in &table.columns {
        let mut words = Map::new();
        words.insert("Description".to_owned(), (&*column.meaning).into());
        if !column.unit.is_empty() {
            words.insert("Units".to_owned(), column.unit.into());
        }
        sidecar.insert(column.name.clone().into_owned(), words.into());
    }
    to_text(&sidecar.into())
}

/// Returns the sidecar of the positions.
pub(crate) fn motion(content: &RecordingContent, times: RowTimes) -> String {
    let mut sidecar = task(content);
    let hardware = content.manifest.hardware.as_ref();
    let sensor = hardware.and_then(|hardware| hardware.position_sensor.as_deref());
    for (name, value) in [
        ("SamplingFrequency", times.rate_hz.into()),
        ("TrackingSystemName", "position".into()),
        ("MotionChannelCount", 1.into()),
        ("TrackedPointsCount", 1.into()),
        ("POSChannelCount", 1.into()),
        ("LATENCYChannelCount", 1.into()),
        ("MissingValues", "n/a".into()),
    ] {
        sidecar.insert(name.to_owned(), value);
    }
    if let Some(sensor) = sensor {
        sidecar.insert("ManufacturersModelName".to_owned(), sensor.into());
    }
    to_text(&sidecar.into())
}

/// Returns the description of the columns of all tables of events.
pub(crate) fn events() -> String {
    let mut levels = Map::new();
    levels.insert("unloaded".to_owned(), "no finger is on the plate".into());
    levels.insert(
        "exploration".to_owned(),
        "the finger slides over the plate".into(),
    );
    for (name, meaning) in EVENT_KINDS.map(event_words) {
        levels.insert(name.to_owned(), meaning.into());
    }
    to_text(&json!({
        "TaskName": TASK,
        "TaskDescription": TASK_DESCRIPTION,
        "onset": { "Description": "time from sample 0 of the recording", "Units": "s" },
        "duration": { "Description": "length; n/a for an event without one", "Units": "s" },
        "trial_type": { "Description": "interval, or event of the recording", "Levels": levels },
        "direction": {
            "Description": "direction of an exploration",
            "Levels": {
                "left_to_right": "towards growing position",
                "right_to_left": "towards falling position"
            }
        },
        "condition": { "Description": "condition of the protocol" }
    }))
}

/// Description of the task.
const TASK_DESCRIPTION: &str = "A fingertip slides over a glass plate that vibrates at an ultrasonic frequency with a modulated amplitude.";

/// Returns the keys that describe the task, the trial and its origin.
fn task(content: &RecordingContent) -> Map<String, Value> {
    let mut sidecar = Map::new();
    sidecar.insert("TaskName".to_owned(), TASK.into());
    sidecar.insert("TaskDescription".to_owned(), TASK_DESCRIPTION.into());
    let trial = content.manifest.trial.as_ref();
    let provenance = &content.provenance;
    sidecar.insert("Simulated".to_owned(), provenance.simulated.into());
    sidecar.insert("Calibrated".to_owned(), provenance.calibrated.into());
    if !provenance.rehearsed.is_empty() {
        let faults = provenance.rehearsed.as_slice();
        sidecar.insert("Rehearsed".to_owned(), faults.into());
    }
    for (name, value) in [
        ("Condition", trial.map(|trial| trial.condition.as_str())),
        ("Protocol", trial.map(|trial| trial.protocol.as_str())),
    ] {
        if let Some(value) = value.filter(|value| !value.is_empty()) {
            sidecar.insert(name.to_owned(), value.into());
        }
    }
    sidecar
}
