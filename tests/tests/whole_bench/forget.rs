//! `forget` removes one participant from a study, and no others.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use bench_tests::program::bench;
use bench_tests::session::{finish, text};
use recording::study::Study;
use tempfile::TempDir;

use super::refusals::assert_refusal;

/// Makes a study of three participants, two of whom have codes with the same beginning.
fn study() -> (TempDir, PathBuf) {
    let room = tempfile::tempdir().unwrap();
    let folder = room.path().join("study");
    // Written by hand: a lock of this process would be inherited by programs that other tests start at the same moment.
    let mut table = "participant_id\tfirst_session_date\tprotocol\n".to_owned();
    for id in ["sub-06", "sub-07", "sub-071"] {
        let session = folder.join(id).join("ses-01");
        let trial = session.join("trial-001_attempt-1");
        fs::create_dir_all(&trial).unwrap();
        fs::write(trial.join("signals.wav"), vec![0; 5000]).unwrap();
        fs::write(session.join("events.jsonl"), "").unwrap();
        table.push_str(&format!("{id}\t2026-01-31\tdemo\n"));
    }
    fs::write(folder.join("participants.tsv"), table).unwrap();
    let description = r#"{"Name": "study", "DatasetType": "raw", "GeneratedBy": []}"#;
    fs::write(folder.join("dataset_description.json"), description).unwrap();
    fs::write(folder.join(".friction-bench.lock"), "").unwrap();
    (room, folder)
}

fn forget(study: &Path, words: &[&str]) -> Output {
    let mut command = bench();
    finish(
        command
            .arg("forget")
            .arg(study)
            .args(words)
            .stdin(Stdio::null()),
    )
}

/// Returns every path in a folder, without following links.
fn tree(folder: &Path) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && !path.is_symlink() {
            paths.extend(tree(&path));
        }
        paths.push(path);
    }
    paths.sort();
    paths
}

#[test]
fn one_participant_is_removed_with_every_trace() {
    let (_room, study) = study();
    let other_paths: Vec<_> = tree(&study)
        .into_iter()
        .filter(|path| !path.starts_with(study.join("sub-07")))
        .collect();
    let output = forget(&study, &["sub-07", "--confirm", "sub-07"]);
    let transcript = text(&output);
    assert_eq!(output.status.code(), Some(0), "{transcript}");
    for word in [
        "sub-07: 2 files in 3 folders, 5000 bytes",
        "participants.tsv",
        "is removed",
    ] {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
    let removals = study.join("removals.tsv");
    let remaining_paths: Vec<_> = tree(&study)
        .into_iter()
        .filter(|path| *path != removals)
        .collect();
    assert_eq!(remaining_paths, other_paths);
    let table = fs::read_to_string(study.join("participants.tsv")).unwrap();
    let ids: Vec<_> = table
        .lines()
        .map(|line| line.split('\t').next().unwrap())
        .collect();
    assert_eq!(ids, ["participant_id", "sub-06", "sub-071"]);
    let log = fs::read_to_string(&removals).unwrap();
    assert!(!log.contains("sub-"), "{log}");
    let (header, line) = log.split_once('\n').unwrap();
    assert_eq!(header, "removed_on\twhat");
    let (date, action) = line.trim_end().split_once('\t').unwrap();
    assert!(date.parse::<jiff::civil::Date>().is_ok(), "{date}");
    assert_eq!(action, "a participant was removed");

    // Nothing is left to remove; removing another participant adds a line.
    let output = forget(&study, &["sub-07", "--confirm", "sub-07"]);
    assert_refusal(&output, &["has no data of sub-07"]);
    assert!(
        forget(&study, &["sub-06", "--confirm", "sub-06"])
            .status
            .success()
    );
    assert_eq!(fs::read_to_string(&removals).unwrap().lines().count(), 3);
    // The study can be continued.
    Study::open(&study)
        .unwrap()
        .next_session(&"sub-07".parse().unwrap())
        .unwrap();
}

#[test]
fn nothing_is_removed_without_both_answers() {
    let (_room, study) = study();
    let paths = tree(&study);
    for (words, message) in [
        (&["sub-07"][..], "--confirm sub-07 answers both"),
        (&["sub-07", "--confirm", "sub-06"], "--confirm names sub-06"),
        (&["sub-99", "--confirm", "sub-99"], "has no data of sub-99"),
        (&["../sub-07", "--confirm", "../sub-07"], "is not allowed"),
    ] {
        assert_refusal(&forget(&study, words), &[message]);
        assert_eq!(tree(&study), paths);
    }
    let folder = study.join("sub-06");
    assert_refusal(
        &forget(&folder, &["sub-07", "--confirm", "sub-07"]),
        &["is not a study"],
    );
    let lock = Study::open(&study).unwrap();
    assert_refusal(
        &forget(&study, &["sub-07", "--confirm", "sub-07"]),
        &["in use"],
    );
    drop(lock);
    assert_eq!(tree(&study), paths);
}

#[cfg(unix)]
#[test]
fn no_link_leads_out_of_the_study() {
    use std::os::unix::fs::symlink;
    let (room, study) = study();
    let target_folder = room.path().join("outside");
    fs::create_dir(&target_folder).unwrap();
    fs::write(target_folder.join("kept"), "kept").unwrap();
    let trial = study.join("sub-07/ses-01/trial-001_attempt-1");
    symlink(&target_folder, trial.join("link")).unwrap();
    symlink(target_folder.join("kept"), trial.join("force.csv")).unwrap();
    let output = forget(&study, &["sub-07", "--confirm", "sub-07"]);
    assert!(output.status.success(), "{}", text(&output));
    assert!(
        text(&output).contains("2 symbolic links"),
        "{}",
        text(&output)
    );
    assert_eq!(tree(&target_folder), [target_folder.join("kept")]);
    assert!(!study.join("sub-07").exists());

    // A participant's folder that is itself a link.
    symlink(&target_folder, study.join("sub-07")).unwrap();
    let output = forget(&study, &["sub-07", "--confirm", "sub-07"]);
    assert_refusal(&output, &["sub-07 is a symbolic link"]);
    assert_eq!(tree(&target_folder), [target_folder.join("kept")]);
}

#[test]
fn other_files_naming_the_participant_are_listed() {
    let (_room, study) = study();
    fs::create_dir(study.join("results")).unwrap();
    fs::write(
        study.join("results/all.json"),
        r#"{"path": "study/sub-07/ses-01"}"#,
    )
    .unwrap();
    fs::write(
        study.join("results/other.json"),
        r#"{"path": "study/sub-071/ses-01"}"#,
    )
    .unwrap();
    fs::write(study.join("sub-07.svg"), "").unwrap();
    // Copies of a backup and of a program that keeps folders alike.
    let copies = ["backup/sub-07", ".stversions/sub-07", "sub-07 (1)"];
    for folder in copies.into_iter().chain(["backup/sub-08"]) {
        fs::create_dir_all(study.join(folder)).unwrap();
        fs::write(study.join(folder).join("force.csv"), "").unwrap();
    }
    let transcript = text(&forget(&study, &["sub-07", "--confirm", "sub-07"]));
    assert!(
        transcript.contains("all.json") && transcript.contains("sub-07.svg"),
        "{transcript}"
    );
    assert!(!transcript.contains("other.json"), "{transcript}");
    for copy in copies {
        assert!(transcript.contains(&format!("{copy}\n")), "{transcript}");
        assert!(study.join(copy).exists());
    }
    assert!(!transcript.contains("sub-08"), "{transcript}");
    assert!(study.join("results/all.json").exists());
}

#[cfg(unix)]
#[test]
fn a_study_that_cannot_be_changed_is_left_as_it_is() {
    let (_room, study) = study();
    // A pipe in place of the table: it is not read, and no file is removed.
    let table = study.join("participants.tsv");
    fs::remove_file(&table).unwrap();
    let status = Command::new("mkfifo").arg(&table).status().unwrap();
    assert!(status.success());
    let paths = tree(&study);
    assert_refusal(
        &forget(&study, &["sub-07", "--confirm", "sub-07"]),
        &["participants.tsv", "a named pipe"],
    );
    assert_eq!(tree(&study), paths);
}

/// Answers both questions on a terminal; returns the exit status of the command and its output.
#[cfg(target_os = "linux")]
fn answer_questions(study: &Path, answers: &str) -> (Option<i32>, String) {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use std::io::Write;
    let operator = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&operator).unwrap();
    unlockpt(&operator).unwrap();
    let name = ptsname(&operator, Vec::new()).unwrap();
    let terminal = fs::File::options()
        .read(true)
        .write(true)
        .open(name.to_str().unwrap())
        .unwrap();
    fs::File::from(operator.try_clone().unwrap())
        .write_all(answers.as_bytes())
        .unwrap();
    let mut command = bench();
    command
        .arg("forget")
        .arg(study)
        .arg("sub-07")
        .stdin(terminal);
    let output = finish(&mut command);
    drop(operator);
    (output.status.code(), text(&output))
}

#[cfg(target_os = "linux")]
#[test]
fn forget_asks_twice_on_a_terminal() {
    let (_room, study) = study();
    let paths = tree(&study);
    for answers in ["no\n", "yes\nsub-06\n"] {
        let (code, transcript) = answer_questions(&study, answers);
        assert_eq!(code, Some(1), "{transcript}");
        assert!(transcript.contains("nothing was removed"), "{transcript}");
        assert_eq!(tree(&study), paths);
    }
    let (code, transcript) = answer_questions(&study, "yes\nsub-07\n");
    assert_eq!(code, Some(0), "{transcript}");
    assert!(!study.join("sub-07").exists());
}
