//! A study exported in each format, and opened by programs that share no code with this one.
#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

mod python;
mod small_study;

use std::fs;
use std::path::Path;
use std::sync::Mutex;

use analysis::Settings;
use analysis::recording_analysis::analyse_with_series;
use clap::Parser;
use export::{ExportError, ExportOptions, ExportOrigin, ExportSummary, FileState, export};
use small_study::SmallStudy;

/// Command line of an export.
#[derive(Debug, Parser)]
struct Line {
    #[command(flatten)]
    options: ExportOptions,
}

/// States of the files of all recordings, and the reasons why others were not exported.
#[derive(Debug, Default)]
struct Report {
    states: Vec<FileState>,
    missing: Vec<String>,
    failures: Vec<String>,
}

fn run(arguments: &[&Path], format: &str) -> Result<(ExportSummary, Report), ExportError> {
    let [study, to, more @ ..] = arguments else {
        panic!("a study and a folder")
    };
    let line = [Path::new("export"), study, Path::new("--to"), to];
    let format = [Path::new("--as"), Path::new(format)];
    let line = Line::parse_from(line.into_iter().chain(format).chain(more.iter().copied()));
    let report = Mutex::new(Report::default());
    let origin = ExportOrigin {
        version: "0.1.0".to_owned(),
        day: "2026-01-31".to_owned(),
    };
    let summary = export(&line.options, &origin, |recording| {
        let mut report = report.lock().unwrap();
        match &recording.files {
            Ok(files) => {
                report.states.extend(&files.states);
                report.missing.extend(files.missing.iter().cloned());
            }
            Err(error) => report.failures.push(error.to_string()),
        }
    })?;
    Ok((summary, report.into_inner().unwrap()))
}

/// Exports the small study twice, the second time without effect, and reads the files by the script's function for the format.
fn export_and_open(format: &str) {
    let study = SmallStudy::new();
    let to = study.folder("export");
    let (summary, report) = run(&[&study.study(), &to], format).unwrap();
    assert_eq!((summary.exported, summary.failed), (4, 1), "{report:?}");
    assert!(report.failures[0].contains("recording.toml"), "{report:?}");
    for file in ["force.csv", "position.csv"] {
        let names_it = |missing: &String| missing.starts_with(file);
        assert!(report.missing.iter().any(names_it), "{report:?}");
    }
    let is_written = |state: &FileState| *state == FileState::Written;
    assert!(report.states.iter().all(is_written), "{report:?}");

    let (_, report) = run(&[&study.study(), &to], format).unwrap();
    let is_unchanged = |state: &FileState| *state == FileState::Unchanged;
    assert!(report.states.iter().all(is_unchanged), "{report:?}");

    python::open(format, &to, &study.recording());
}

#[test]
fn scipy_opens_the_mat_files() {
    export_and_open("mat");
}

#[test]
fn numpy_opens_the_archives_without_pickle() {
    export_and_open("npz");
}

#[test]
fn the_tables_have_the_recordings_numbers() {
    export_and_open("csv");
}

#[test]
fn the_dataset_has_the_recordings_numbers_and_passes_the_validator() {
    export_and_open("bids");
}

#[test]
fn the_friction_over_time_is_that_of_the_analysis() {
    let study = SmallStudy::new();
    let to = study.folder("export");
    run(&[&study.study(), &to, Path::new("--no-signals")], "csv").unwrap();
    let folder = to.join("sub-01_ses-01_trial-001_attempt-1");
    assert!(!folder.join("signals.csv").exists());
    let mut table = csv::Reader::from_path(folder.join("friction.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let place = |name: &str| header.iter().position(|column| column == name).unwrap();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let (_, series) = analyse_with_series(&study.recording(), &Settings::default());
    let frames = series.explorations.iter().map(|e| e.time_s.len());
    assert_eq!(rows.len(), frames.sum::<usize>());
    let mut compared = 0;
    for (number, instance) in series.instances.iter().enumerate() {
        let Some(estimate) = &instance.trial else {
            continue;
        };
        let number = (number + 1).to_string();
        let cells = rows.iter().filter(|row| row[place("instance")] == number);
        let cells: Vec<_> = cells.collect();
        assert_eq!(cells.len(), instance.samples.time_s().len());
        for (k, row) in cells.iter().enumerate() {
            let cell = |name: &str| row[place(name)].parse::<f64>().unwrap();
            assert_eq!(cell("time_s"), instance.samples.time_s()[k]);
            assert_eq!(cell("gap_m"), estimate.contact.gap_m[k]);
            assert_eq!(cell("mu"), estimate.contact.mu[k]);
            assert_eq!(cell("measured_mu"), instance.samples.mu()[k]);
            compared += 1;
        }
    }
    assert!(compared > 500, "{compared} samples");
    // Outside the instances nothing is estimated.
    let outside = rows.iter().filter(|row| row[place("instance")] == *"0");
    assert!(outside.clone().count() > 100);
    assert!(outside.into_iter().all(|row| row[place("mu")].is_empty()));
}

#[test]
fn a_folder_with_other_files_and_the_study_itself_are_refused() {
    let study = SmallStudy::new();
    let to = study.folder("export");
    fs::create_dir(&to).unwrap();
    fs::write(to.join("thesis.tex"), "").unwrap();
    for format in ["mat", "bids"] {
        let error = run(&[&study.study(), &to], format).unwrap_err().to_string();
        assert!(error.contains("thesis.tex"), "{error}");
    }
    let inner = study.study().join("sub-01/export");
    let error = run(&[&study.study(), &inner], "npz").unwrap_err();
    assert!(matches!(error, ExportError::InsideStudy { .. }), "{error}");
    assert!(!inner.exists());
}

#[test]
fn an_accepted_trial_with_a_broken_recording_is_named() {
    let study = SmallStudy::new();
    let session = study.study().join("sub-02/ses-01");
    let key =
        |number| format!(r#"{{"number":{number},"attempt":1,"practice":false,"condition":"dry"}}"#);
    let settled = |number, outcome: &str| {
        let key = key(number);
        format!(
            r#"{{"event":"trial_settled","record":{{"key":{key},"outcome":{{"outcome":{outcome}}},"analysis":null}}}}"#
        )
    };
    let events = [
        format!(r#"{{"event":"trial_began","key":{}}}"#, key(1)),
        settled(1, r#""given_up","reasons":[]"#),
        format!(r#"{{"event":"trial_began","key":{}}}"#, key(2)),
        settled(2, r#""accepted""#),
    ];
    let lines = events.map(|data| {
        format!(r#"{{"document":"event","stream":"session","seq_num":1,"time":"","audio_s":1.0,"data":{data}}}"#) + "\n"
    });
    fs::write(session.join("events.jsonl"), lines.concat()).unwrap();
    let manifest = session.join("trial-002_attempt-1/recording.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, text.replace("\"completed\"", "\"interrupted\"")).unwrap();
    let arguments = [study.study(), study.folder("export"), "--no-signals".into()];
    let [study, to, no_signals] = arguments.each_ref().map(|path| path.as_path());
    let (summary, _) = run(&[study, to, no_signals], "npz").unwrap();
    assert_eq!((summary.exported, summary.failed), (3, 2), "{summary:?}");
    assert!(
        summary.left_out[0].contains("trial-002_attempt-1"),
        "{summary:?}"
    );
}

#[test]
fn a_recording_outside_a_study_has_no_place_in_a_dataset() {
    let study = SmallStudy::new();
    let alone = study.lone_recording();
    let (summary, report) = run(&[&alone, &study.folder("bids")], "bids").unwrap();
    assert_eq!((summary.exported, summary.failed), (0, 1));
    assert!(report.failures[0].contains("[participant]"), "{report:?}");
    let (summary, _) = run(&[&alone, &study.folder("mat")], "mat").unwrap();
    assert_eq!((summary.exported, summary.failed), (1, 0));
    assert!(study.folder("mat").join("alone.mat").exists());
}

#[test]
fn a_changed_recording_is_exported_anew() {
    let study = SmallStudy::new();
    let to = study.folder("export");
    let alone = study.lone_recording();
    run(&[&alone, &to], "npz").unwrap();
    let manifest = alone.join("recording.toml");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(
        &manifest,
        text.replace("modulation_hz = 6.0", "modulation_hz = 3.0"),
    )
    .unwrap();
    let (_, report) = run(&[&alone, &to], "npz").unwrap();
    assert_eq!(report.states, [FileState::Replaced]);
}
