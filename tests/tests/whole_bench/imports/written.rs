//! Files that Python writes of a recording, and their import.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bench_tests::program::{bench, python, workspace};
use bench_tests::session::{finish, text};

use super::results::RecordingResults;

/// Runs a script of tests/python that writes files of a recording into a folder, one folder for each of `kinds`.
pub(super) fn write(script: &str, recording: &Path, folder: &Path, kinds: &[&str]) {
    let script = workspace().join("tests/python").join(script);
    let mut command = Command::new(python());
    command.arg(script).arg(recording).arg(folder).args(kinds);
    let output = finish(&mut command);
    assert!(output.status.success(), "{}", text(&output));
}

/// Returns the study of a map: recordings of another map are not replaced.
fn study(folder: &Path, map: &str) -> PathBuf {
    folder.join(map).with_extension("study")
}

/// Runs `import` of a map of a folder into the map's study.
pub(super) fn run_import(folder: &Path, map: &str) -> Output {
    let mut command = bench();
    command.arg("import").arg(folder.join(map));
    command.arg("--study").arg(study(folder, map));
    finish(&mut command)
}

/// Imports the only recording in the files of a folder by one of its maps; returns its folder.
///
/// # Panics
/// When it is refused.
pub(super) fn import(folder: &Path, map: &str) -> PathBuf {
    let output = run_import(folder, map);
    assert!(output.status.success(), "{}", text(&output));
    study(folder, map).join("sub-01/ses-01/trial-001_attempt-1")
}

/// Imports the recording in the files of a folder, with the intervals of its marks; returns its results.
pub(super) fn results(folder: &Path) -> RecordingResults {
    let recording = import(folder, "marks.toml");
    RecordingResults::new(&recording, &folder.join("results.json"), &[])
}
