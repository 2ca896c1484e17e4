//! Calls of `analyze --each` into one folder: recordings that two of them found, and files that changed in between.

#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use analysis::assumptions::Assumptions;
use analysis_parts::{PartOutcome, PartState, PartsError, PartsRequest, read_parts, write_parts};
use recording::manifest::MINIMAL;
use recording::study::DESCRIPTION_FILE;
use recording::writer::Ending;
use recording::{AudioFormat, Manifest, RecordingWriter, SIGNALS_FILE};
use study::exclusions::EXCLUSIONS_FILE;
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
        self.write_requested(&request, None, verify_inputs)
            .into_iter()
            .map(|outcome| (outcome.state, outcome.changed.len()))
            .collect()
    }

    /// Writes the parts that are requested, and returns the outcomes.
    fn write_requested(
        &self,
        request: &Request,
        lab: Option<&str>,
        verify_inputs: bool,
    ) -> Vec<PartOutcome> {
        let found = request.find().unwrap();
        let request = PartsRequest {
            request,
            found: &found,
            assumptions: &Assumptions::default(),
            lab,
            verify_inputs,
        };
        let outcomes = Mutex::new(Vec::new());
        write_parts(&self.parts(), &request, |outcome| {
            outcomes.lock().unwrap().push(PartOutcome {
                path: outcome.path.clone(),
                key: outcome.key.clone(),
                changed: outcome.changed.clone(),
                analysis: None,
                unread: outcome.unread.clone(),
                remedy: outcome.remedy.clone(),
                ..*outcome
            });
        })
        .unwrap();
        outcomes.into_inner().unwrap()
    }
}

fn write(folder: &Path, level: f32) {
    write_attempt(folder, "sub-03", level);
}

fn write_attempt(folder: &Path, participant: &str, level: f32) {
    let text = format!(
        "{MINIMAL}participant = {{ id = \"{participant}\", session = 2 }}\ntrial = {{ number = 1, attempt = 1, practice = false, \
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

/// Two people of a study, of whom one withdraws.
struct Withdrawal {
    study: Study,
}

impl Withdrawal {
    fn new() -> Self {
        let study = Study::new([0.1, 0.2]);
        fs::remove_dir_all(study.folder.path().join("study/backup")).unwrap();
        let withdrawal = Self { study };
        write_attempt(&withdrawal.recording(), "sub-04", 0.2);
        withdrawal
    }

    fn folder(&self) -> PathBuf {
        self.study.folder.path().join("study")
    }

    /// Returns the recording of the person who withdraws.
    fn recording(&self) -> PathBuf {
        self.folder().join("sub-04/ses-02/trial-001_attempt-1")
    }

    fn exclude(&self) {
        let table = "participant_id\tsession\ttrial\treason\tby\nsub-04\tall\tall\twithdrew\tME\n";
        fs::write(self.folder().join(EXCLUSIONS_FILE), table).unwrap();
    }

    /// Writes the parts of the study, and returns the outcomes, those of `sub-04` last.
    fn write_parts(&self, include_excluded: bool, lab: Option<&str>) -> Vec<PartOutcome> {
        let request = Request {
            folders: vec![self.folder()],
            include_excluded,
            ..Request::default()
        };
        let mut outcomes = self.study.write_requested(&request, lab, false);
        outcomes.sort_by_key(|outcome| outcome.path.to_string_lossy().contains("sub-04"));
        outcomes
    }

    fn states(&self, include_excluded: bool) -> Vec<PartState> {
        let outcomes = self.write_parts(include_excluded, None);
        outcomes.iter().map(|outcome| outcome.state).collect()
    }

    /// Requires that neither the parts nor their index have anything of `sub-04`, and that `--from` counts the other person alone.
    fn require_gone(&self) {
        let mut folders = vec![self.study.parts()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                assert!(!path.ends_with("participant=sub-04"), "{}", path.display());
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        let index = self.study.parts().join("index");
        for (kind, count) in [("recordings", 1), ("calls", 1), ("sessions", 0)] {
            let found = fs::read_dir(index.join(kind)).map_or(0, Iterator::count);
            assert_eq!(found, count, "{kind}");
        }
        let analysed = read_parts(&self.study.parts(), |_| {}).unwrap().analysed;
        assert_eq!(analysed.recordings.len(), 1);
    }
}

#[test]
fn a_person_who_was_removed_leaves_the_parts() {
    let withdrawal = Withdrawal::new();
    assert_eq!(withdrawal.states(false), [PartState::Done; 2]);
    // An earlier call for the person alone.
    let recording = withdrawal.recording();
    withdrawal.study.write_parts(&[&recording], false);
    fs::remove_dir_all(withdrawal.folder().join("sub-04")).unwrap();
    let states = withdrawal.states(false);
    assert_eq!(states, [PartState::Kept, PartState::Removed]);
    withdrawal.require_gone();
    assert_eq!(withdrawal.states(false), [PartState::Kept]);
}

#[test]
fn a_person_who_was_excluded_leaves_the_parts_and_is_marked_if_asked_for() {
    let withdrawal = Withdrawal::new();
    withdrawal.states(false);
    withdrawal
        .study
        .write_parts(&[&withdrawal.recording()], false);
    withdrawal.exclude();
    let states = withdrawal.states(true);
    assert_eq!(states, [PartState::Kept, PartState::Done], "marked");
    assert_eq!(withdrawal.states(true), [PartState::Kept; 2]);
    let states = withdrawal.states(false);
    assert_eq!(states, [PartState::Kept, PartState::Removed]);
    withdrawal.require_gone();
}

#[test]
fn a_session_of_which_a_trial_remains_keeps_its_history() {
    let withdrawal = Withdrawal::new();
    let session = withdrawal.folder().join("sub-04/ses-02");
    fs::write(session.join("events.jsonl"), "").unwrap();
    let sessions = withdrawal.study.parts().join("index/sessions");
    let request = |folder: PathBuf| Request {
        folders: vec![folder],
        ..Request::default()
    };
    let named = request(withdrawal.recording());
    withdrawal.study.write_requested(&named, None, false);
    assert_eq!(fs::read_dir(&sessions).unwrap().count(), 1);
    // The trial counts under another name from now on.
    fs::rename(withdrawal.recording(), session.join("morning")).unwrap();
    let outcomes = withdrawal
        .study
        .write_requested(&request(session.clone()), None, false);
    let states: Vec<PartState> = outcomes.iter().map(|outcome| outcome.state).collect();
    assert!(
        states.contains(&PartState::Done) || states.contains(&PartState::Kept),
        "{states:?}"
    );
    assert_eq!(fs::read_dir(&sessions).unwrap().count(), 1);
}

#[test]
fn a_part_of_another_laboratory_or_study_is_left() {
    let withdrawal = Withdrawal::new();
    withdrawal.write_parts(false, Some("oslo"));
    let other = Withdrawal::new();
    let folders = [other.folder()];
    let request = Request {
        folders: folders.to_vec(),
        ..Request::default()
    };
    withdrawal
        .study
        .write_requested(&request, Some("lyon"), false);
    fs::remove_dir_all(withdrawal.folder().join("sub-04")).unwrap();
    let outcomes = withdrawal.write_parts(false, Some("bergen"));
    let states: Vec<PartState> = outcomes.iter().map(|outcome| outcome.state).collect();
    assert_eq!(states, [PartState::Done, PartState::Foreign]);
    let remedy = outcomes[1].remedy.as_ref().unwrap();
    assert!(remedy.contains("laboratory oslo"), "{remedy}");
    let part = PathBuf::from(remedy.rsplit("delete ").next().unwrap());
    assert!(part.is_file(), "{remedy}");
    let lyon = withdrawal.study.parts().join("lab=lyon");
    assert_eq!(fs::read_dir(lyon).unwrap().count(), 2);
}
