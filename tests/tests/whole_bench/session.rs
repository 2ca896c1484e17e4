//! A whole session on simulated hardware: its output, its files, and its bit-for-bit reproducibility.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use bench_tests::program::workspace;
use bench_tests::recorded::Recording;
use bench_tests::session::{SessionFolder, finish, headless_run, text, write_demo_protocol};
use recording::RecordingReader;
use recording::manifest::{Direction, End, EventKind, RecordedIntervalKind};
use recording::study::event_log::{Document, ExitStatus};
use serde_json::Value;

const RATE_HZ: f64 = 192_000.0;

/// Fault 36.
#[test]
fn a_session_is_recorded_to_the_letter() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let output = finish(&mut headless_run(&study, "sub-01", "demo"));
    let transcript = text(&output);
    assert_eq!(output.status.code(), Some(0), "{transcript}");
    for line in [
        "trials accepted   4 of 4",
        "drop-outs         0 audio frames lost, 0 input and 0 output xruns",
    ] {
        assert!(transcript.contains(line), "no `{line}` in:\n{transcript}");
    }
    let number = |name: &str| -> f64 {
        let line = transcript.lines().find(|line| line.starts_with(name));
        let rest = line.unwrap_or_else(|| panic!("no `{name}` in:\n{transcript}"));
        let word = rest[name.len()..].split_whitespace().next().unwrap();
        word.parse().unwrap()
    };
    assert!(
        (0.5..0.8).contains(&number("mean normal force")),
        "{transcript}"
    );
    assert!(number("instances") >= 4.0 * 5.0, "{transcript}");
    assert!(transcript.contains(&study.join("sub-01").display().to_string()));

    require_study_files(&study);
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    require_ordered_log(&session);
    let recordings = session.recordings();
    let names: Vec<_> = recordings
        .iter()
        .map(|path| path.file_name().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(names[0], "practice-01_attempt-1");
    let repetitions = number("trials repeated") as usize;
    assert_eq!(names.len(), 5 + repetitions, "{names:?}");
    for (index, path) in recordings.iter().enumerate() {
        require_complete_recording(path, &session, index);
    }
}

fn require_study_files(study: &Path) {
    let read = |name: &str| std::fs::read_to_string(study.join(name)).unwrap();
    let description: Value = serde_json::from_str(&read("dataset_description.json")).unwrap();
    assert_eq!(description["DatasetType"], "raw");
    assert_eq!(description["GeneratedBy"][0]["Name"], "friction-bench");
    assert_eq!(
        read("participants.tsv"),
        "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness\n\
         sub-01\t2026-01-01\tdemo\tn/a\tn/a\tn/a\n"
    );
    let session = study.join("sub-01/ses-01");
    assert_eq!(
        std::fs::read_to_string(session.join("demo.toml")).unwrap(),
        std::fs::read_to_string(workspace().join("protocols/demo.toml")).unwrap()
    );
    let hardware = std::fs::read_to_string(session.join("bench.toml")).unwrap();
    config::Config::parse(&hardware, "the snapshot").unwrap();
}

/// Requires a log of start, descriptors, events numbered without gaps, and stop, with as many events as the stop declares.
fn require_ordered_log(session: &SessionFolder) {
    let documents = &session.documents;
    let Some(Document::Start(start)) = documents.first() else {
        panic!("the log begins with {:?}", documents.first());
    };
    assert_eq!((start.participant.as_str(), start.session), ("sub-01", 1));
    assert_eq!(start.devices["simulated"], "true");
    assert_eq!(start.calibration, None);
    assert!(start.configuration["audio"]["rate_hz"] == 192_000);
    let Some(Document::Stop(stop)) = documents.last() else {
        panic!("the log ends with {:?}", documents.last());
    };
    assert_eq!(
        (stop.exit_status, &stop.reason),
        (ExitStatus::Success, &None)
    );
    let mut streams = BTreeSet::new();
    let mut numbers = Vec::new();
    let mut audio_s = 0.0;
    for document in &documents[1..documents.len() - 1] {
        match document {
            Document::Descriptor(descriptor) => {
                assert!(numbers.is_empty(), "descriptors come before events");
                streams.insert(descriptor.stream.clone());
            }
            Document::Event(event) => {
                assert!(
                    streams.contains(&event.stream),
                    "{event:?} is not described"
                );
                assert!(event.audio_s >= audio_s, "{event:?} before {audio_s} s");
                audio_s = event.audio_s;
                numbers.push(event.seq_num);
            }
            document => panic!("{document:?} in the middle of the log"),
        }
    }
    assert_eq!(numbers, (1..=stop.num_events).collect::<Vec<_>>());
    let order: Vec<_> = session
        .named("trial_settled")
        .map(|event| event.data["record"]["key"]["number"].as_u64().unwrap())
        .collect();
    assert!(order.is_sorted(), "{order:?}");
    assert_eq!(
        session.named("consent_given").next().unwrap().data["by"],
        "A. Tester"
    );
}

fn require_complete_recording(path: &Path, session: &SessionFolder, index: usize) {
    let path_text = path.display();
    let files: BTreeSet<_> = std::fs::read_dir(path)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let expected = ["force.csv", "position.csv", "recording.toml", "signals.wav"];
    assert_eq!(files, expected.map(str::to_owned).into(), "{path_text}");

    let recording = Recording::read(path);
    assert_eq!(recording.warnings, Vec::<String>::new(), "{path_text}");
    assert_eq!(
        (f64::from(recording.rate_hz), recording.channels),
        (RATE_HZ, 4)
    );
    assert_eq!(recording.nonfinite_samples(), 0, "{path_text}");
    // An independent reader finds the same frames.
    let wav = hound::WavReader::open(path.join("signals.wav")).unwrap();
    assert_eq!(wav.spec().sample_format, hound::SampleFormat::Float);
    assert_eq!(wav.duration() as usize, recording.frames(), "{path_text}");

    // The recording runs from the frame at which the trial began to the frame at which its data were complete, according to the
    // log.
    let began_s = session.named("trial_began").nth(index).unwrap().audio_s;
    let ended_s = session.phases("verdict").nth(index).unwrap().audio_s;
    let frames = ((ended_s - began_s) * RATE_HZ).round() as usize;
    assert_eq!(recording.frames(), frames, "{path_text}");
    // And no frame was lost and replaced by another.
    let step_rad = recording.greatest_phase_step_rad();
    assert!(
        step_rad < 0.01,
        "{path_text}: the carrier jumps by {step_rad} rad"
    );

    let manifest = &recording.manifest;
    assert!(
        manifest.hardware.as_ref().unwrap().uncalibrated,
        "{path_text}"
    );
    let trial = manifest.trial.as_ref().unwrap();
    assert_eq!(
        (trial.end, &trial.interruption),
        (Some(End::Completed), &None)
    );
    assert_eq!(trial.practice, index == 0);
    let kinds: Vec<_> = manifest.events.iter().map(|event| event.kind).collect();
    let repeats = (trial.attempt > 1).then_some(EventKind::Redo);
    assert_eq!(kinds, Vec::from_iter(repeats), "{path_text}");
    let kinds: Vec<_> = manifest
        .intervals
        .iter()
        .map(|interval| interval.kind)
        .collect();
    assert_eq!(
        kinds,
        [
            RecordedIntervalKind::Unloaded,
            RecordedIntervalKind::Exploration(Direction::LeftToRight),
            RecordedIntervalKind::Exploration(Direction::RightToLeft),
        ]
    );
    let mut end_s = 0.0;
    for interval in &manifest.intervals {
        assert!(interval.start_s >= end_s, "{path_text}: {interval:?}");
        end_s = interval.end_s;
    }
    assert!(end_s < recording.duration_s(), "{path_text}");
    let slide_s = manifest.intervals[1].end_s - manifest.intervals[1].start_s;
    assert!(
        (slide_s - 0.085 / 0.050).abs() < 1e-6,
        "{path_text}: {slide_s} s"
    );

    let reader = RecordingReader::open(path).unwrap();
    let force: Vec<f64> = reader
        .force()
        .unwrap()
        .map(|row| row.unwrap().time_s)
        .collect();
    let position: Vec<f64> = reader
        .position()
        .unwrap()
        .map(|row| row.unwrap().time_s)
        .collect();
    for (name, times_s, rate_hz) in [("force", force, 10_000.0), ("position", position, 1_000.0)] {
        let rows = times_s.len() as f64;
        let expected = recording.duration_s() * rate_hz;
        assert!(
            (rows - expected).abs() < 0.01 * expected,
            "{path_text}: {rows} rows of {name}, not {expected}"
        );
        assert!(times_s.is_sorted_by(|a, b| a < b), "{path_text}: {name}");
        assert!(
            times_s[0] >= 0.0 && times_s[times_s.len() - 1] <= recording.duration_s() + 1e-6,
            "{path_text}: {name}"
        );
    }
}

/// Returns every file of a study except the lock, by its path.
fn contents(study: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![study.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path
                .file_name()
                .is_some_and(|name| name != ".friction-bench.lock")
            {
                let name = path.strip_prefix(study).unwrap().display().to_string();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_other_signals() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = write_demo_protocol(
        folder.path(),
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 2"),
        ],
    );
    let run = |run: &str, seed: &str| {
        let study = folder.path().join(run).join("study");
        let output = finish(headless_run(&study, "sub-07", &protocol).args(["--seed", seed]));
        assert!(output.status.success(), "{}", text(&output));
        contents(&study)
    };
    let (first_files, second_files, other_files) =
        (run("first", "42"), run("again", "42"), run("other", "43"));
    assert_eq!(
        first_files.keys().collect::<Vec<_>>(),
        second_files.keys().collect::<Vec<_>>()
    );
    let differences: Vec<_> = first_files
        .iter()
        .filter(|(name, bytes)| second_files[*name] != **bytes)
        .map(|(name, _)| name)
        .collect();
    assert!(
        differences.is_empty(),
        "the same seed gives another {differences:?}"
    );
    for file in ["signals.wav", "force.csv", "position.csv"] {
        let name = format!("sub-07/ses-01/trial-001_attempt-1/{file}");
        assert_ne!(
            first_files[&name], other_files[&name],
            "{name} does not depend on the seed"
        );
    }
}
