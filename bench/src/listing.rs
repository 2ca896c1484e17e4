//! `list`: recordings, one a line, for other programs.

use std::io::Write;

use escaping::escaped;
use study::exclusions;
use study::listing::{ListedRecording, RecordingList, list};

use crate::cli::{List, ListFormat};

/// Columns of the table, in order; new ones are added behind.
const COLUMNS: [&str; 15] = [
    "path",
    "study",
    "participant",
    "session",
    "trial",
    "attempt",
    "practice",
    "condition",
    "standing",
    "seconds",
    "bytes",
    "simulated",
    "calibrated",
    "archived",
    "fault",
];

/// Runs the command. Returns true if every listed recording can be read.
///
/// # Errors
/// A folder has no recording or cannot be listed, or the exclusions of a study cannot be read.
pub fn run(options: &List) -> anyhow::Result<bool> {
    let RecordingList {
        mut recordings,
        unread_logs,
    } = list(&options.paths)?;
    for line in &unread_logs {
        let _ = writeln!(standard_streams::stderr(), "warning: {}", escaped(line));
    }
    if !options.only.is_empty() {
        recordings.retain(|recording| {
            options.only.contains(&recording.standing)
                && (options.practice || recording.practice != Some(true))
        });
    }
    let mut out = standard_streams::data_out();
    match (options.null, options.format) {
        (true, _) => {
            for recording in &recordings {
                out.write_all(&[recording.path.as_os_str().as_encoded_bytes(), &[0]].concat())?;
            }
        }
        (false, ListFormat::Tsv) => write!(out, "{}", escaped(&table(&recordings)))?,
        (false, ListFormat::Json) => {
            let text = serde_json::to_string_pretty(&recordings)?;
            writeln!(out, "{}", escaped(&text))?;
        }
    }
    Ok(recordings.iter().all(|recording| recording.fault.is_none()))
}

/// Returns the recordings as a table with a header.
fn table(recordings: &[ListedRecording]) -> String {
    let mut text = COLUMNS.join("\t") + "\n";
    for recording in recordings {
        let cells = cells(recording);
        let cells: Vec<String> = cells.iter().map(|cell| exclusions::cell(cell)).collect();
        text.push_str(&cells.join("\t"));
        text.push('\n');
    }
    text
}

/// Returns the cells of a recording in the order of [`COLUMNS`]; an unknown value is n/a, as in the other tables of a study.
fn cells(recording: &ListedRecording) -> [String; 15] {
    fn known<T: ToString>(value: Option<&T>) -> String {
        value.map_or_else(|| "n/a".to_owned(), T::to_string)
    }
    let seconds = recording.seconds.map(|seconds| format!("{seconds:.3}"));
    [
        recording.path.to_string_lossy().into_owned(),
        known(recording.study.as_ref()),
        known(recording.participant.as_ref()),
        known(recording.session.as_ref()),
        known(recording.trial.as_ref()),
        known(recording.attempt.as_ref()),
        known(recording.practice.as_ref()),
        known(recording.condition.as_ref()),
        recording.standing.word().to_owned(),
        known(seconds.as_ref()),
        recording.bytes.to_string(),
        recording.simulated.to_string(),
        recording.calibrated.to_string(),
        recording.archived.to_string(),
        recording.fault.clone().unwrap_or_default(),
    ]
}
