//! Calls of `analyze --each` into one folder: recordings that two of them found, and files that changed in between.

#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use analysis::assumptions::Assumptions;
use analysis_parts::{PartState, PartsError, PartsRequest, read_parts, write_parts};
use recording::manifest::MINIMAL;
use recording::study::DESCRIPTION_FILE;
use recording::writer::Ending;
use recording::{AudioFormat, Manifest, RecordingWriter, SIGNALS_FILE};
use study_analysis::Request;
use tempfile::TempDir;

/// Two recordings of one study, which are the same attempt.
struct Study {
    folder: TempDir,
}

impl Study {
    /// Creates a study of two recordings of constant drives.
    fn new(levels: [f32; 2]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("study")).unwrap();
        fs::write(folder.path().join("study").join(DESCRIPTION_FILE), "{}").unwrap();
        let study = Self { folder };
        for (recording, level) in study.recordings().iter().zip(levels) {
            write(recording, level);
        }
        study
    }

    fn recordings(&self) -> [PathBuf; 2] {
        ["sub-03/ses-02/trial-001_attempt-1", "backup/morning"]
            .map(|name| self.folder.path().join("study").join(name))
    }

    fn parts(&self) -> PathBuf {
        self.folder.path().join("parts")
    }

    /// Writes the part of each recording in these folders, and returns their states.
    fn write_parts(&self, folders: &[&Path], verify_inputs: bool) -> Vec<(PartState, usize)> {
        let request = Request {
            folders: folders.iter().map(|path| (*path).to_owned()).collect(),
            ..Request::default()
        };
        let found = request.find().unwrap();
        let request = PartsRequest {
            request: &request,
            found: &found,
            assumptions: &Assumptions::default(),
            lab: None,
            verify_inputs,
        };
        let states = Mutex::new(Vec::new());
        write_parts(&self.parts(), &request, |outcome| {
            let state = (outcome.state, outcome.changed.len());
            states.lock().unwrap().push(state);
        })
        .unwrap();
        states.into_inner().unwrap()
    }
}

fn write(folder: &Path, level: f32) {
    let text = format!(
        "{MINIMAL}participant = {{ id = \"sub-03\", session = 2 }}\ntrial = {{ number = 1, attempt = 1, practice = false, \
         condition = \"c\", protocol = \"p\", seed = 1, end = \"completed\" }}\n"
    );
    fs::create_dir_all(folder.parent().unwrap()).unwrap();
    let format = AudioFormat {
        sample_rate_hz: 96_000,
        channels: 2,
    };
    let manifest = Manifest::parse(&text, "recording.toml").unwrap();
    let mut writer = RecordingWriter::create(folder, manifest, format).unwrap();
    writer.write_audio(&vec![level; 2 * 9600]).unwrap();
    writer.finish(Ending::Completed).unwrap();
}

#[test]
fn an_attempt_of_which_two_calls_found_other_contents_is_refused() {
    let study = Study::new([0.1, 0.2]);
    let [first, second] = &study.recordings();
    study.write_parts(&[first], false);
    read_parts(&study.parts(), |_| {}).unwrap();
    study.write_parts(&[second], false);
    let error = read_parts(&study.parts(), |_| {}).err().unwrap();
    assert!(matches!(error, PartsError::Ambiguous { .. }), "{error}");
    let text = error.to_string();
    for recording in [first, second] {
        assert!(text.contains(&recording.display().to_string()), "{text}");
    }
    assert!(
        text.contains("trial-001_attempt-1 of sub-03, session 2"),
        "{text}"
    );
    // The remedy of a call for one recording.
    let call = text.rsplit("delete ").next().unwrap();
    fs::remove_file(call).unwrap();
    let analysed = read_parts(&study.parts(), |_| {}).unwrap().analysed;
    assert_eq!(analysed.recordings.len(), 1);
}

#[test]
fn a_copy_that_two_calls_found_counts_once() {
    let study = Study::new([0.1, 0.1]);
    for recording in &study.recordings() {
        study.write_parts(&[recording], false);
    }
    let analysed = read_parts(&study.parts(), |_| {}).unwrap().analysed;
    assert_eq!(analysed.recordings.len(), 1);
}

#[test]
fn a_change_with_its_time_set_back_is_found_by_sums_alone() {
    let study = Study::new([0.1, 0.2]);
    let [recording, _] = &study.recordings();
    assert_eq!(
        study.write_parts(&[recording], false),
        [(PartState::Done, 0)]
    );
    let path = recording.join(SIGNALS_FILE);
    let modified = fs::metadata(&path).unwrap().modified().unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&path, bytes).unwrap();
    let file = File::options().write(true).open(&path).unwrap();
    file.set_modified(modified).unwrap();
    drop(file);
    assert_eq!(
        study.write_parts(&[recording], false),
        [(PartState::Kept, 0)]
    );
    assert_eq!(
        study.write_parts(&[recording], true),
        [(PartState::Done, 0)]
    );
    assert_eq!(
        study.write_parts(&[recording], false),
        [(PartState::Kept, 0)]
    );
}
