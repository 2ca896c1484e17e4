//! Conditions of one name with different drives, of which a mean is of neither.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use analysis::RecordingAnalysis;
use protocols::{Drive, Protocol};
use serde_json::Value;
use study::protocol_copies::protocol_copies;

/// Returns a line for each condition with different drives, by the protocols next to the recordings; one that cannot be read states
/// nothing.
pub(crate) fn unlike_drives(recordings: &[RecordingAnalysis]) -> Vec<String> {
    let mut protocols: HashMap<PathBuf, Option<Protocol>> = HashMap::new();
    let mut conditions: BTreeMap<String, Vec<(&Path, Drive)>> = BTreeMap::new();
    for recording in recordings {
        let Ok(findings) = &recording.findings else {
            continue;
        };
        let Some(trial) = &findings.manifest.trial else {
            continue;
        };
        let copies = protocol_copies(&recording.path, &findings.manifest);
        let Some(copy) = copies.into_iter().next() else {
            continue;
        };
        let protocol = protocols
            .entry(copy)
            .or_insert_with_key(|path| protocol(path));
        let drive = protocol.as_ref().and_then(|protocol| {
            let mut conditions = protocol.conditions.iter();
            let condition = conditions.find(|condition| condition.name == trial.condition)?;
            Some(condition.drive)
        });
        let known = conditions.entry(trial.condition.clone()).or_default();
        known.extend(drive.map(|drive| (&*recording.path, drive)));
    }
    let lines = conditions.iter().filter_map(|(condition, drives)| {
        let (first, others) = drives.split_first()?;
        let other = others.iter().find(|other| other.1 != first.1)?;
        Some(line(condition, first, other))
    });
    lines.collect()
}

/// Returns the protocol in a file; `None` if it cannot be read.
fn protocol(path: &Path) -> Option<Protocol> {
    let text = bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES).ok()?;
    Protocol::parse(&text, &path.display().to_string()).ok()
}

fn line(condition: &str, first: &(&Path, Drive), other: &(&Path, Drive)) -> String {
    let keys = |(_, drive): &(&Path, Drive)| match serde_json::to_value(drive) {
        Ok(Value::Object(keys)) => keys,
        _ => serde_json::Map::new(),
    };
    let other_keys = keys(other);
    let differences = keys(first).into_iter().filter_map(|(key, value)| {
        let other_value = other_keys.get(&key)?;
        (value != *other_value).then(|| format!("{key} = {value} and {other_value}"))
    });
    let differences: Vec<String> = differences.collect();
    format!(
        "the condition {condition} has {} in {} and {}: its means are over both; give conditions of different drives different names, or \
         analyze them one at a time",
        differences.join(", "),
        first.0.display(),
        other.0.display()
    )
}

#[cfg(test)]
mod tests {
    use protocols::Carrier;

    use super::*;

    #[test]
    fn a_line_names_what_differs_and_where() {
        let drive = |mean_amplitude_v: f64| Drive {
            carrier: Carrier::PlateResonance,
            mean_amplitude_v,
            modulation_hz: 6.0,
            modulation_index: 0.95,
        };
        let first = (Path::new("sub-01/ses-01/trial-001_attempt-1"), drive(24.0));
        let other = (Path::new("sub-02/ses-01/trial-001_attempt-1"), drive(12.5));
        assert_eq!(
            line("am", &first, &other),
            "the condition am has mean_amplitude_v = 24.0 and 12.5 in sub-01/ses-01/trial-001_attempt-1 and \
             sub-02/ses-01/trial-001_attempt-1: its means are over both; give conditions of different drives different names, or analyze \
             them one at a time"
        );
    }
}
