//! Participants' details in a study, and exclusions from its analysis.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use bench_tests::program::{bench, protocol};
use bench_tests::session::{finish, headless_run, text};
use recording::manifest::MINIMAL;
use recording::writer::Ending;
use recording::{AudioFormat, Manifest, RecordingWriter};
use serde_json::Value;

use super::refusals::{assert_early_refusal, assert_refusal, room};

#[test]
fn only_requested_details_are_stored() {
    let (folder, study) = room();
    let plain_protocol = protocol("one-exploration.toml");
    assert_early_refusal(
        headless_run(&study, "sub-01", &plain_protocol).args(["--age", "31"]),
        &study,
        &["does not ask for the participant's age", "leave out --age"],
    );
    let asking_protocol = folder.path().join("asking.toml");
    let protocol_text = fs::read_to_string(&plain_protocol).unwrap();
    let question = "[participant]\nask = [\"age\", \"handedness\"]\n\n[drive]";
    fs::write(
        &asking_protocol,
        protocol_text.replacen("[drive]", question, 1),
    )
    .unwrap();
    assert_early_refusal(
        headless_run(&study, "sub-01", &asking_protocol).args(["--age", "17"]),
        &study,
        &["18 to 120", "not for children"],
    );
    assert_early_refusal(
        headless_run(&study, "sub-01", &asking_protocol).args(["--handedness", "both"]),
        &study,
        &["right, left, ambidextrous"],
    );
    let output =
        finish(headless_run(&study, "sub-01", &asking_protocol).args(["--handedness", "left"]));
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(transcript.contains("not stated: age"), "{transcript}");
    let table = fs::read_to_string(study.join("participants.tsv")).unwrap();
    assert_eq!(
        table,
        "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness\n\
         sub-01\t2026-01-01\tone-exploration\tn/a\tn/a\tleft\n"
    );
}

#[test]
fn a_stated_detail_is_kept_and_a_different_answer_reported() {
    let (folder, study) = room();
    let asking_protocol = folder.path().join("asking.toml");
    let protocol_text = fs::read_to_string(protocol("one-exploration.toml")).unwrap();
    let question = "[participant]\nask = [\"age\"]\n\n[drive]";
    fs::write(
        &asking_protocol,
        protocol_text.replacen("[drive]", question, 1),
    )
    .unwrap();
    for (age, option) in [("31", None), ("32", Some("--new-session"))] {
        let mut run = headless_run(&study, "sub-01", &asking_protocol);
        let output = finish(run.args(["--age", age]).args(option));
        let transcript = text(&output);
        assert!(output.status.success(), "{transcript}");
        let has_note = transcript.contains("already has age 31 for sub-01: 32 is ignored");
        assert_eq!(has_note, age == "32", "{transcript}");
    }
    let table = fs::read_to_string(study.join("participants.tsv")).unwrap();
    assert!(table.ends_with("\t31\tn/a\tn/a\n"), "{table}");
}

/// Writes a silent recording.
fn silence(folder: &Path) {
    let format = AudioFormat {
        sample_rate_hz: 96_000,
        channels: 2,
    };
    fs::create_dir_all(folder.parent().unwrap()).unwrap();
    let manifest = Manifest::parse(MINIMAL, "recording.toml").unwrap();
    let mut writer = RecordingWriter::create(folder, manifest, format).unwrap();
    writer.write_audio(&[0.0; 19_200]).unwrap();
    writer.finish(Ending::Completed).unwrap();
}

fn write_study(study: &Path) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    for (participant, trial) in [("sub-01", 1), ("sub-02", 1), ("sub-02", 2)] {
        let name = format!("trial-{trial:03}_attempt-1");
        let folder = study.join(participant).join("ses-01").join(name);
        silence(&folder);
        folders.push(folder);
    }
    let description = r#"{"Name": "study", "DatasetType": "raw", "GeneratedBy": []}"#;
    fs::write(study.join("dataset_description.json"), description).unwrap();
    fs::write(
        study.join("participants.tsv"),
        "participant_id\nsub-01\nsub-02\n",
    )
    .unwrap();
    folders
}

fn command(words: &[&str], study: &Path, options: &[&str]) -> Output {
    finish(bench().args(words).arg(study).args(options))
}

fn exclude(study: &Path, words: &[&str]) -> Output {
    finish(bench().arg("exclude").args(words).arg("--study").arg(study))
}

#[test]
fn exclusions_are_left_out_counted_and_named_in_every_result() {
    let (folder, study) = room();
    let recordings = write_study(&study);
    let reason = ["--because", "the sensor's\tcable", "--by", "N. H."];
    assert_refusal(
        &exclude(
            &study,
            &["sub-20", reason[0], reason[1], reason[2], reason[3]],
        ),
        &["did you mean `sub-02`?"],
    );
    assert_refusal(
        &exclude(
            &study,
            &[
                "sub-02", "--trial", "3", reason[0], reason[1], reason[2], reason[3],
            ],
        ),
        &["no recording of trial 3", "there are 1, 2"],
    );
    assert_refusal(
        &exclude(&study, &["sub-02", "--because", " ", "--by", "me"]),
        &["--because is empty"],
    );
    assert!(!study.join("exclusions.tsv").exists());
    let output = exclude(
        &study,
        &[
            "sub-02", "--trial", "2", reason[0], reason[1], reason[2], reason[3],
        ],
    );
    assert!(output.status.success(), "{}", text(&output));
    assert_refusal(
        &exclude(
            &study,
            &[
                "sub-02", "--trial", "2", reason[0], reason[1], reason[2], reason[3],
            ],
        ),
        &["already"],
    );

    let figure_folder = folder.path().join("out");
    let figures = figure_folder.display().to_string();
    let output = command(&["analyze"], &study, &["--table", "--figures", &figures]);
    let transcript = text(&output);
    assert!(
        transcript.contains("excluded: 1 of 3 recordings"),
        "{transcript}"
    );
    assert!(
        transcript.contains("sub-02, trial 2: the sensor's"),
        "{transcript}"
    );
    let table = fs::read_to_string(figure_folder.join("excluded.tsv")).unwrap();
    assert!(
        table.contains("sub-02\tall\t2\tthe sensor's\\tcable\tN. H.\t"),
        "{table}"
    );
    let json = |options: &[&str]| -> Value {
        let output = command(&["analyze"], &study, &[&["--json", "-"], options].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let results = json(&[]);
    assert_eq!(results["recordings"].as_array().unwrap().len(), 2);
    assert_eq!(results["excluded"][0]["reason"], "the sensor's\tcable");
    assert_eq!(results["excluded"][0]["trial"], "2");
    let path = results["excluded"][0]["recordings"][0].as_str().unwrap();
    assert_eq!(Path::new(path), recordings[2]);
    let all_results = json(&["--include-excluded"]);
    assert_eq!(all_results["recordings"].as_array().unwrap().len(), 3);
    assert_eq!(all_results["excluded"], Value::Array(Vec::new()));
    let exclusion = &all_results["exclusions_overridden"][0];
    assert_eq!(exclusion["reason"], "the sensor's\tcable");
    assert_eq!(
        all_results["attempts"]["analysed"], 3,
        "{}",
        all_results["attempts"]
    );
    assert_eq!(results["attempts"]["excluded"], 1);
    let page = command(
        &["analyze"],
        &study,
        &["--include-excluded", "--report", "-"],
    );
    let page = text(&page);
    assert!(page.contains("These decisions were overridden"), "{page}");
    assert!(!page.contains("No recording is excluded"), "{page}");
    assert_refusal(
        &finish(bench().arg("analyze").arg(&recordings[2])),
        &["nothing is left to analyse", "--include-excluded"],
    );

    let transcript = text(&command(&["verify"], &study, &[]));
    assert!(
        transcript.contains("excluded from analysis: sub-02, trial 2"),
        "{transcript}"
    );
    // An invalid edit by hand stops the analysis.
    let table = study.join("exclusions.tsv");
    let content = fs::read_to_string(&table).unwrap();
    fs::write(&table, content.replace("\t2\tthe", "\t7\tthe")).unwrap();
    assert_refusal(
        &command(&["analyze"], &study, &[]),
        &["exclusions.tsv, line 2", "trial 7"],
    );
    let transcript = text(&command(&["verify"], &study, &[]));
    assert!(
        transcript.contains("WRONG: ") && transcript.contains("trial 7"),
        "{transcript}"
    );

    // Removing a participant also removes the lines of this table.
    let output = command(&["forget"], &study, &["sub-02", "--confirm", "sub-02"]);
    let transcript = text(&output);
    assert!(
        transcript.contains("a line in exclusions.tsv"),
        "{transcript}"
    );
    assert!(!transcript.contains("would stay"), "{transcript}");
    assert!(!fs::read_to_string(&table).unwrap().contains("sub-02"));
    assert!(!command(&["analyze"], &study, &[]).stdout.is_empty());
}
