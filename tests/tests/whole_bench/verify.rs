//! `verify` on whole and on damaged studies.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bench_tests::program::bench;
use bench_tests::session::{finish, headless_run, text, write_demo_protocol};
use bench_tests::shared::shared_folder;
use recording::{FORCE_FILE, MANIFEST_FILE, POSITION_FILE, SIGNALS_FILE};
use serde_json::Value;
use tempfile::TempDir;

const SESSION: &str = "sub-01/ses-01";
pub(super) const TRIAL: &str = "trial-001_attempt-1";
const PRACTICE: &str = "practice-01_attempt-1";

/// Returns a study of one short session: a practice trial and two others.
fn recorded_study() -> PathBuf {
    shared_folder("verified-study", |folder| {
        let protocol = write_demo_protocol(
            folder,
            &[
                ("per_condition = 4", "per_condition = 2"),
                (
                    "[\"left_to_right\", \"right_to_left\"]",
                    "[\"left_to_right\"]",
                ),
                ("speed_m_per_s = 0.050", "speed_m_per_s = 0.080"),
                ("countdown_s = 1.0", "countdown_s = 0.2"),
                ("min_instances = 5", "min_instances = 1"),
            ],
        );
        let output = finish(&mut headless_run(&folder.join("study"), "sub-01", protocol));
        assert!(output.status.success(), "{}", text(&output));
    })
}

/// A copy of that study, to be damaged.
pub(super) struct StudyCopy {
    folder: TempDir,
}

impl StudyCopy {
    pub(super) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        copy(
            &recorded_study().join("study"),
            &folder.path().join("study"),
        );
        Self { folder }
    }

    pub(super) fn study(&self) -> PathBuf {
        self.folder.path().join("study")
    }

    pub(super) fn session(&self) -> PathBuf {
        self.study().join(SESSION)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.session().join(TRIAL).join(name)
    }

    /// Replaces part of a text file.
    pub(super) fn edit(&self, file: &Path, part: &str, replacement: &str) {
        let text = fs::read_to_string(file).unwrap();
        assert!(text.contains(part), "no `{part}` in {text}");
        fs::write(file, text.replacen(part, replacement, 1)).unwrap();
    }

    /// Removes the lines of the log selected by `is_removed`.
    fn remove_lines(&self, is_removed: impl Fn(&str) -> bool) {
        let log = self.session().join("events.jsonl");
        let text = fs::read_to_string(&log).unwrap();
        let content: String = text
            .lines()
            .filter(|line| !is_removed(line))
            .map(|l| format!("{l}\n"))
            .collect();
        assert!(content.len() < text.len(), "no such line");
        fs::write(log, content).unwrap();
    }

    /// Resumes the session.
    pub(super) fn resume(&self, options: &[&str]) -> Output {
        let protocol = recorded_study().join("protocol.toml");
        let mut run = headless_run(&self.study(), "sub-01", protocol);
        finish(run.arg("--resume").args(options))
    }

    /// Returns the exit status and the output.
    pub(super) fn verify(&self) -> (i32, String) {
        let output = finish(bench().arg("verify").arg(self.study()));
        (output.status.code().unwrap(), text(&output))
    }

    /// Requires `verify` to report damage in these words.
    fn require_damage(&self, words: &[&str]) {
        let (status, transcript) = self.verify();
        assert_eq!(status, 1, "{transcript}");
        for word in words.iter().chain(&["NOT WHOLE"]) {
            assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
        }
        assert!(!transcript.contains("panicked"), "{transcript}");
    }
}

fn copy(source: &Path, target: &Path) {
    fs::create_dir_all(target).unwrap();
    for entry in fs::read_dir(source).unwrap() {
        let entry = entry.unwrap();
        let target = target.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

#[test]
fn a_whole_study_passes_with_every_sum() {
    let study = StudyCopy::new();
    let (status, transcript) = study.verify();
    assert_eq!(status, 0, "{transcript}");
    for line in [
        "complete, 2 of 2 trials accepted",
        "practice              sums agree",
        "accepted              sums agree",
        "nothing is damaged or missing",
    ] {
        assert!(transcript.contains(line), "no `{line}` in:\n{transcript}");
    }
    assert!(!transcript.contains("note"), "{transcript}");
    // One session of it, and as JSON.
    let output = finish(bench().args(["verify", "--json", "-"]).arg(study.session()));
    let findings: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(findings["whole"], true);
    let trials = findings["sessions"][0]["trials"].as_array().unwrap();
    assert!(trials.len() >= 3, "{findings:#}");
    assert!(trials.iter().all(|trial| trial["integrity"] == "intact"));
    assert_eq!(trials[0]["name"], PRACTICE);
    assert_eq!(trials[0]["practice"], true);
    // The checksums are those of any other program.
    let log = fs::read_to_string(study.session().join("events.jsonl")).unwrap();
    let event: Value = log
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap())
        .find(|line| line["data"]["saved"] == TRIAL)
        .unwrap();
    let sums: String = event["data"]["sha256"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(file, sum)| format!("{}  {file}\n", sum.as_str().unwrap()))
        .collect();
    assert_eq!(sums.lines().count(), 4);
    fs::write(study.file("SHA256SUMS"), sums).unwrap();
    let output = finish(
        Command::new("sha256sum")
            .args(["--check", "--strict", "SHA256SUMS"])
            .current_dir(study.session().join(TRIAL)),
    );
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn a_flipped_byte_is_found() {
    let study = StudyCopy::new();
    let path = study.file(SIGNALS_FILE);
    let mut bytes = fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(path, bytes).unwrap();
    study.require_damage(&[
        "trial-001_attempt-1        accepted              DAMAGED",
        "signals.wav has changed since it was recorded",
    ]);
}

#[test]
fn a_missing_file_and_a_missing_folder_are_found() {
    let study = StudyCopy::new();
    fs::remove_file(study.file(FORCE_FILE)).unwrap();
    let mut position = fs::read_to_string(study.file(POSITION_FILE)).unwrap();
    position += "99.0,0.05\n";
    fs::write(study.file(POSITION_FILE), position).unwrap();
    fs::remove_dir_all(study.session().join(PRACTICE)).unwrap();
    fs::remove_file(study.session().join("bench.toml")).unwrap();
    fs::write(study.session().join("calibration.toml"), "format = 1\n").unwrap();
    study.require_damage(&[
        "calibration.toml: it was edited",
        "DAMAGED",
        "force.csv is missing",
        "position.csv has changed since it was recorded",
        "practice-01_attempt-1      practice              MISSING",
        "its folder is missing",
        "bench.toml is missing",
    ]);
}

#[test]
fn files_of_no_recording_are_named_and_damage_nothing() {
    let study = StudyCopy::new();
    fs::write(study.file(".DS_Store"), "").unwrap();
    assert!(!study.verify().1.contains("note"));
    fs::copy(study.file(FORCE_FILE), study.file("force (1).csv")).unwrap();
    let (status, transcript) = study.verify();
    assert_eq!(status, 0, "{transcript}");
    let note = "force (1).csv is no file of a recording: nothing reads it";
    assert!(transcript.contains(note), "{transcript}");
    fs::write(study.file("notes.txt"), "").unwrap();
    let transcript = study.verify().1;
    assert!(
        transcript.contains("force (1).csv and 1 more are no files of a recording"),
        "{transcript}"
    );
    // A name that a terminal would obey.
    fs::write(study.file("a\u{1b}[31m\nnothing is damaged"), "").unwrap();
    let transcript = study.verify().1;
    assert!(
        transcript.contains(r"a\u001b[31m\nnothing is damaged and 2 more"),
        "{transcript}"
    );
}

#[test]
fn a_truncated_wav_and_an_edited_description_are_found_also_without_sums() {
    let study = StudyCopy::new();
    // A log from before checksums were recorded.
    let log = study.session().join("events.jsonl");
    let content: String = fs::read_to_string(&log)
        .unwrap()
        .lines()
        .map(|line| {
            let mut line: Value = serde_json::from_str(line).unwrap();
            if let Some(data) = line["data"].as_object_mut() {
                data.remove("sha256");
            }
            format!("{line}\n")
        })
        .collect();
    fs::write(&log, content).unwrap();
    let (status, transcript) = study.verify();
    assert_eq!(status, 0, "{transcript}");
    assert!(transcript.contains("no sum recorded: "), "{transcript}");
    assert!(!transcript.contains("sums agree"), "{transcript}");

    let path = study.file(SIGNALS_FILE);
    let length = path.metadata().unwrap().len();
    let file = fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.set_len(length - 1000).unwrap();
    let second_trial = study.session().join("trial-002_attempt-1");
    study.edit(
        &second_trial.join(MANIFEST_FILE),
        "number = 2",
        "number = 7",
    );
    study.require_damage(&["truncated", "recording.toml is of trial-007_attempt-1"]);
}

#[test]
fn an_edited_description_has_another_sum_and_a_broken_one_is_named() {
    let study = StudyCopy::new();
    study.edit(
        &study.file(MANIFEST_FILE),
        "modulation_index = 0.95",
        "modulation_index = 0.9",
    );
    let second_trial = study.session().join("trial-002_attempt-1");
    study.edit(&second_trial.join(MANIFEST_FILE), "carrier_hz", "carier_hz");
    study.require_damage(&[
        "recording.toml has changed since it was recorded",
        "unknown key `carier_hz`",
    ]);
}

/// Trials used to be accepted although a hung or failing disk had interrupted their recordings, and `verify` printed "nothing
/// is damaged or missing".
///
/// Fault 27.
#[test]
fn an_accepted_trial_without_its_whole_recording_is_found_and_missed_by_the_analysis() {
    let study = StudyCopy::new();
    // Without checksums, as when the recording could not be read back.
    study.remove_lines(|line| line.contains(&format!("\"saved\":\"{TRIAL}\"")));
    let manifest = study.file(MANIFEST_FILE);
    study.edit(&manifest, "end = \"completed\"", "end = \"interrupted\"");
    study.require_damage(&[
        "trial-001_attempt-1        accepted              DAMAGED",
        "the log says that the trial was accepted, and recording.toml that its recording was broken off",
        "the log says that the trial was accepted, and not that its recording was saved",
    ]);
    let output = finish(bench().arg("analyze").arg(study.study()));
    assert_eq!(output.status.code(), Some(1));
    let transcript = text(&output);
    for line in [
        "accepted 2, analysed 1; left out: 1 missed",
        "trial-001_attempt-1 (accepted): its recording was broken off",
    ] {
        assert!(transcript.contains(line), "no `{line}` in:\n{transcript}");
    }

    let study = StudyCopy::new();
    let force = study.file(FORCE_FILE);
    let rows = fs::read_to_string(&force).unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    fs::write(&force, rows[..rows.len() / 2].join("\n") + "\n").unwrap();
    study.require_damage(&[
        "force.csv has no rows from",
        "although the trial was accepted",
    ]);
}

/// A program that was frozen for seconds reads its sensors once more before it stops.
///
/// Fault 7.
#[test]
fn a_row_long_after_the_end_is_wrong_in_a_completed_recording_alone() {
    let study = StudyCopy::new();
    study.remove_lines(|line| line.contains(&format!("\"saved\":\"{TRIAL}\"")));
    let position = study.file(POSITION_FILE);
    let rows = fs::read_to_string(&position).unwrap();
    fs::write(&position, rows + "1000.0,0.05\n").unwrap();
    let message = "WRONG: position.csv: 1 rows are left out";
    study.require_damage(&[message]);
    let manifest = study.file(MANIFEST_FILE);
    study.edit(&manifest, "end = \"completed\"", "end = \"interrupted\"");
    let (_, transcript) = study.verify();
    assert!(!transcript.contains(message), "{transcript}");
    assert!(
        transcript.contains("position.csv: 1 rows are left out"),
        "{transcript}"
    );
}

#[test]
fn lost_frames_that_no_event_explains_are_found() {
    let study = StudyCopy::new();
    let path = study.file(SIGNALS_FILE);
    let mut bytes = fs::read(&path).unwrap();
    let frame_bytes = usize::from(u16::from_le_bytes([bytes[32], bytes[33]]));
    let start = bytes.len() - 10 * frame_bytes;
    for sample in bytes[start..].chunks_exact_mut(4) {
        sample.copy_from_slice(&f32::NAN.to_le_bytes());
    }
    fs::write(path, bytes).unwrap();
    let manifest = study
        .session()
        .join("trial-002_attempt-1")
        .join(MANIFEST_FILE);
    let text = fs::read_to_string(&manifest).unwrap();
    let gap = "\n[[events]]\nkind = \"gap\"\nsample = 100\nframes = 5\n";
    fs::write(&manifest, text + gap).unwrap();
    study.require_damage(&[
        "10 frames of signals.wav are lost, and no event",
        "5 frames from 100 on were lost, but signals.wav has samples there",
    ]);
}

#[test]
fn a_line_that_is_removed_from_the_log_is_found() {
    let study = StudyCopy::new();
    study.remove_lines(|line| line.contains("trial_settled") && line.contains("\"number\":2"));
    study.require_damage(&["events.jsonl", "lines are missing or in another order"]);
    // The same for the first and the last line.
    for (part, word) in [
        ("\"document\":\"start\"", "before any start"),
        ("\"saved\":\"trial-002_attempt-1\"", "lines are missing"),
    ] {
        let study = StudyCopy::new();
        study.remove_lines(|line| line.contains(part));
        study.require_damage(&[word]);
    }
    let study = StudyCopy::new();
    fs::remove_file(study.session().join("events.jsonl")).unwrap();
    study.require_damage(&["events.jsonl is missing"]);
}

#[test]
fn foreign_files_are_named() {
    let study = StudyCopy::new();
    let session = study.session();
    copy(&session.join(TRIAL), &session.join("trial-009_attempt-1"));
    copy(&session.join(TRIAL), &session.join("a copy"));
    fs::create_dir(session.join("figures")).unwrap();
    fs::create_dir(study.study().join("sub-09")).unwrap();
    study.require_damage(&[
        "trial-009_attempt-1        unknown               DAMAGED",
        "it is not in the log",
        "a copy is a recording, but not a trial of this session",
        "note: figures is not part of the session",
        "note: sub-09 is not in participants.tsv",
    ]);
}

#[test]
fn a_participant_in_another_folder_is_found() {
    let study = StudyCopy::new();
    fs::rename(study.study().join("sub-01"), study.study().join("sub-02")).unwrap();
    study.require_damage(&[
        "participants.tsv lists sub-01",
        "events.jsonl is of sub-01, session 1",
    ]);
}

/// Cuts the study to the state after a kill in its last trial: without the trial's end and all later data. Returns the trial.
fn cut_in_last_trial(study: &StudyCopy) -> String {
    let log = study.session().join("events.jsonl");
    let text = fs::read_to_string(&log).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let index = lines
        .iter()
        .rposition(|line| line.contains("trial_began"))
        .unwrap();
    fs::write(&log, lines[..=index].join("\n") + "\n{\"docu").unwrap();
    let event: Value = serde_json::from_str(lines[index]).unwrap();
    let key = &event["data"]["key"];
    let name = format!(
        "trial-{:03}_attempt-{}",
        key["number"].as_u64().unwrap() - 1,
        key["attempt"]
    );
    study.edit(
        &study.session().join(&name).join(MANIFEST_FILE),
        "end = \"completed\"\n",
        "",
    );
    name
}

#[test]
fn an_interrupted_session_passes_and_its_last_trial_is_reported_on_resuming() {
    let study = StudyCopy::new();
    let name = cut_in_last_trial(&study);
    let (status, transcript) = study.verify();
    assert_eq!(status, 0, "{transcript}");
    for word in [
        "unfinished: the program was killed",
        "interrupted           no sum recorded",
        "was torn",
    ] {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
    let output = study.resume(&[]);
    assert!(output.status.success(), "{}", text(&output));
    let line = format!("the last trial before this: {name}: interrupted, no sum recorded");
    assert!(text(&output).contains(&line), "{}", text(&output));
    let (status, transcript) = study.verify();
    assert_eq!(status, 0, "{transcript}");
    assert!(transcript.contains("complete, 2 of 2"), "{transcript}");
}

#[test]
fn a_damaged_last_trial_is_reported_on_resuming() {
    let study = StudyCopy::new();
    // The operator ended it after the first trial.
    let log = study.session().join("events.jsonl");
    let content = fs::read_to_string(&log).unwrap();
    let lines: Vec<&str> = content.lines().collect();
    let is_settled = |line: &&str| line.contains("trial_settled") && line.contains("\"number\":2");
    let index = lines.iter().position(is_settled).unwrap();
    fs::write(&log, lines[..=index].join("\n") + "\n").unwrap();
    for entry in fs::read_dir(study.session()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if name.starts_with("trial-") && name > TRIAL {
            fs::remove_dir_all(path).unwrap();
        }
    }
    fs::remove_file(study.file(FORCE_FILE)).unwrap();
    let output = study.resume(&[]);
    assert!(output.status.success(), "{}", text(&output));
    let line =
        format!("the last trial before this: {TRIAL}: accepted, DAMAGED; force.csv is missing");
    assert!(text(&output).contains(&line), "{}", text(&output));
}

#[test]
fn a_session_whose_log_has_a_hole_is_not_resumed() {
    for damage in [
        "trial_settled",
        "half a line",
        "lost",
        "emptied",
        "another person",
        "an older copy",
    ] {
        let study = StudyCopy::new();
        cut_in_last_trial(&study);
        let log = study.session().join("events.jsonl");
        match damage {
            "trial_settled" => study.remove_lines(|line| line.contains(damage)),
            "half a line" => study.edit(&log, "{\"document\":\"event\"", "{\"docu"),
            "lost" => fs::remove_file(&log).unwrap(),
            "emptied" => fs::write(&log, "").unwrap(),
            "an older copy" => {
                let content = fs::read_to_string(&log).unwrap();
                let is_before = |line: &&str| !line.contains("\"number\":1");
                let lines: Vec<&str> = content.lines().take_while(is_before).collect();
                // A simulated session that is killed may lose as many lines.
                let text = lines
                    .join("\n")
                    .replace("\"simulated\":\"true\"", "\"simulated\":\"false\"");
                fs::write(&log, text + "\n").unwrap();
            }
            _ => study.edit(
                &log,
                "\"participant\":\"sub-01\"",
                "\"participant\":\"sub-05\"",
            ),
        }
        let content_before = fs::read(&log).ok();
        let output = study.resume(&[]);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        for word in ["cannot be trusted", "events.jsonl", "--new-session"] {
            assert!(text(&output).contains(word), "{}", text(&output));
        }
        let content_after = fs::read(&log).ok();
        assert!(content_before == content_after, "the log is left as it is");
    }
}

#[test]
fn a_participant_whose_row_was_lost_is_entered_again() {
    let study = StudyCopy::new();
    cut_in_last_trial(&study);
    let table = study.study().join("participants.tsv");
    let before = fs::read_to_string(&table).unwrap();
    let row = |text: &str| {
        let mut lines = text.lines().filter(|line| line.starts_with("sub-01\t"));
        let cells = lines.next().map(|line| line.split('\t').map(str::to_owned));
        cells.map(|cells| cells.take(3).collect::<Vec<_>>())
    };
    assert!(row(&before).is_some(), "{before}");
    fs::remove_file(&table).unwrap();
    let output = study.resume(&[]);
    assert!(output.status.success(), "{}", text(&output));
    let after = fs::read_to_string(&table).unwrap();
    assert_eq!(row(&after), row(&before), "{after}");
}

#[test]
fn copies_that_were_edited_are_named_and_not_compared_with() {
    let study = StudyCopy::new();
    cut_in_last_trial(&study);
    for name in ["bench.toml", "demo.toml"] {
        let copy = study.session().join(name);
        let content = fs::read_to_string(&copy).unwrap();
        fs::write(&copy, content.replace('\n', "\r\n")).unwrap();
    }
    let output = finish(bench().arg("verify").arg(study.study()));
    assert!(!text(&output).contains("was changed"), "{}", text(&output));
    for name in ["bench.toml", "demo.toml"] {
        let copy = study.session().join(name);
        let content = fs::read_to_string(&copy).unwrap();
        fs::write(&copy, content + "# edited\n").unwrap();
    }
    let output = finish(bench().arg("verify").arg(study.study()));
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    for name in ["bench.toml", "demo.toml"] {
        let words = format!("{name} was changed after the session wrote it");
        assert!(text(&output).contains(&words), "{}", text(&output));
    }
    let output = study.resume(&[]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    let words = "the session's copy of its protocol, was changed";
    assert!(text(&output).contains(words), "{}", text(&output));
}

#[test]
fn a_misspelt_folder_suggests_the_right_one() {
    let study = StudyCopy::new();
    let output = finish(
        bench()
            .arg("verify")
            .arg(study.folder.path().join("studdy")),
    );
    let transcript = text(&output);
    assert_eq!(output.status.code(), Some(2), "{transcript}");
    let suggestion = format!("did you mean `{}`?", study.study().display());
    assert!(transcript.contains(&suggestion), "{transcript}");
    // A recording or another file is not a study.
    for (path, words) in [
        (study.session().join(TRIAL), "is a recording"),
        (study.session().join("demo.toml"), "is not a folder"),
    ] {
        let output = finish(bench().arg("verify").arg(path));
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(words), "{}", text(&output));
    }
}
