//! A disk that is full, stops accepting bytes or loses its folders: refused before a session; in a session, the drive stops and
//! data is kept.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;
use std::process::{Command, ExitStatus};
use std::time::Duration;

use bench_tests::campaign;
use bench_tests::program::{bench, friction_bench, protocol};
use bench_tests::recorded::Recording;
use bench_tests::running::Running;
use bench_tests::session::{
    SessionFolder, finish, headless_run, patient_config, text, write_demo_protocol,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::manifest::End;
use recording::study::event_log::ExitStatus as SessionStatus;
use recording::{RecordingReader, SIGNALS_FILE};
use serde_json::Value;

const MINUTE: Duration = Duration::from_secs(60);

/// Unit of `ulimit -f` in POSIX, bytes.
const LIMIT_UNIT: u64 = 512;

/// Returns `command` with a limit on the size of each file it writes. The shell leaves SIGXFSZ unchanged, which kills a process
/// that does not handle it.
fn limit_file_size(command: &Command, units: u64) -> Command {
    let mut shell = Command::new("sh");
    shell
        .arg("-c")
        .arg(format!("ulimit -f {units}; exec \"$0\" \"$@\""))
        .arg(friction_bench())
        .args(command.get_args());
    shell
}

/// Requires the program to have exited with an error and these words, without a panic.
fn require_failure(status: ExitStatus, transcript: &str, words: &[&str]) {
    assert!(
        status.code().is_some_and(|code| code != 0),
        "{status:?}: {transcript}"
    );
    assert!(!transcript.contains("panicked"), "{transcript}");
    for word in words {
        assert!(transcript.contains(word), "no `{word}` in:\n{transcript}");
    }
}

/// Returns the names of the recordings that the log reports as saved.
fn saved_recordings(session: &SessionFolder) -> Vec<&str> {
    session
        .events()
        .filter_map(|event| event.data.get("saved").and_then(Value::as_str))
        .collect()
}

/// Returns a session of one trial, which takes 16 MB.
fn one_trial(study: &Path) -> Command {
    headless_run(study, "sub-01", protocol("one-exploration.toml"))
}

/// Fault 25.
/// Hazard 14.
#[test]
fn a_file_size_limit_in_a_trial_stops_the_drive_and_keeps_what_is_recorded() {
    // Not divisible by the frame size of 16 bytes.
    run_with_limit(16_001);
}

/// Number of full disks at random moments in every test run; `FRICTION_BENCH_FULL_DISKS` asks for more.
const FULL_DISKS: usize = 2;

/// Fault 25.
#[test]
fn a_file_size_limit_at_a_random_moment_of_a_trial_does_too() {
    let disks = campaign::repeats("FRICTION_BENCH_FULL_DISKS", FULL_DISKS);
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let recorded_s = (0..disks).map(|_| run_with_limit(rng.random_range(8_000..28_000)));
    let (shortest_s, longest_s) = recorded_s.fold(
        (f64::INFINITY, 0.0_f64),
        |(shortest_s, longest_s), recorded_s| {
            (shortest_s.min(recorded_s), longest_s.max(recorded_s))
        },
    );
    let text = format!(
        "each kept what was recorded, {shortest_s:.1} to {longest_s:.1} s, and the session was resumed"
    );
    campaign::report("full disks at random moments", disks, &text);
}

/// Requires a session with files limited to `limit` units to stop and keep its recording; returns the recorded seconds.
fn run_with_limit(limit: u64) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let output = finish(&mut limit_file_size(&one_trial(&study), limit));
    let transcript = text(&output);
    let words = ["STOPPED", "failed", "a limit on file sizes", "ended early"];
    require_failure(output.status, &transcript, &words);

    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let stops = session.stops();
    assert_eq!(stops.len(), 1);
    assert_eq!(stops[0].exit_status, SessionStatus::Fail);
    assert!(stops[0].reason.as_ref().unwrap().contains("file sizes"));
    assert_eq!(saved_recordings(&session), Vec::<&str>::new());
    session.require_whole();

    let recordings = session.recordings();
    let [recording_path] = &recordings[..] else {
        panic!("{recordings:?}");
    };
    let recording = Recording::read(recording_path);
    assert_eq!(recording.warnings, Vec::<String>::new());
    let trial = recording.manifest.trial.as_ref().unwrap();
    assert_eq!(trial.end, Some(End::Interrupted));
    assert!(trial.interruption.as_ref().unwrap().contains("file sizes"));
    // As many whole frames as the limit allows.
    let frame_bytes = 4 * recording.channels as u64;
    let bytes = recording_path.join(SIGNALS_FILE).metadata().unwrap().len();
    let limit_bytes = limit * LIMIT_UNIT;
    assert!(
        (bytes..bytes + frame_bytes).contains(&limit_bytes),
        "{bytes}"
    );
    assert_eq!(recording.nonfinite_samples(), 0);
    assert!(recording.greatest_phase_step_rad() < 0.01);
    let message = format!("{:.1} s of it are readable", recording.duration_s());
    assert!(
        transcript.contains(&message),
        "no `{message}` in:\n{transcript}"
    );
    require_force_rows(recording.duration_s(), recording_path);

    // Without the limit the session can be resumed.
    let output = finish(one_trial(&study).arg("--resume"));
    assert!(output.status.success(), "{}", text(&output));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    assert_eq!(saved_recordings(&session), ["trial-001_attempt-2"]);
    recording.duration_s()
}

/// Requires all force rows of a recording to be readable, and the last ones to reach the end of its audio.
fn require_force_rows(end_s: f64, recording: &Path) {
    let mut rows = RecordingReader::open(recording).unwrap().force().unwrap();
    let last_row = rows.by_ref().map(Result::unwrap).last().unwrap();
    assert_eq!(rows.warnings(), []);
    assert!(
        (last_row.time_s - end_s).abs() < 0.2,
        "{} s",
        last_row.time_s
    );
}

/// Fault 25.
#[test]
fn a_file_size_limit_that_lets_no_session_begin() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    // Too small for the lock, then for the copy of the protocol.
    for limit in [0, 2] {
        let output = finish(&mut limit_file_size(&one_trial(&study), limit));
        require_failure(
            output.status,
            &text(&output),
            &["cannot write", "a limit on file sizes"],
        );
        assert!(!text(&output).contains("trial 1"), "{}", text(&output));
    }
    // The files left by these attempts do not prevent a session.
    let output = finish(one_trial(&study).arg("--resume"));
    assert!(output.status.success(), "{}", text(&output));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    assert_eq!(saved_recordings(&session), ["trial-001_attempt-1"]);
}

/// Fault 25.
#[test]
fn a_session_folder_removed_in_a_trial_stops_the_drive() {
    for speed in ["max", "real"] {
        let transcript = remove_in_trial(speed);
        assert!(!transcript.contains("accepted: "), "{transcript}");
    }
}

/// Runs a session and moves the participant's folder away during the first trial; returns the session's output.
fn remove_in_trial(speed: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let config = patient_config(folder.path());
    let mut run = bench();
    run.args(["run", "--mock", "--headless", "--speed", speed])
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .arg("--study")
        .arg(&study)
        .arg("--config")
        .arg(&config)
        .args(["--protocol", "demo"]);
    let mut running = Running::start(&mut run, &folder.path().join("output"));
    running.skip_verification();
    let participant = study.join("sub-01");
    let signals = participant
        .join("ses-01/practice-01_attempt-1")
        .join(SIGNALS_FILE);
    let has_recorded = running.wait_for(MINUTE, || {
        let bytes = signals.metadata().ok()?.len();
        (bytes > 1_000_000).then_some(())
    });
    assert!(has_recorded.is_some(), "{}", running.output());
    let new_path = folder.path().join("elsewhere");
    std::fs::rename(&participant, &new_path).unwrap();
    let status = running.wait(MINUTE);
    let transcript = running.output();
    // The message is the same whether the recorder or the log accesses the disk first.
    require_failure(status, &transcript, &["does not exist"]);
    assert!(!participant.exists(), "made anew");
    // Moved away, not lost.
    let recording = Recording::read(&new_path.join("ses-01/practice-01_attempt-1"));
    assert!(recording.frames() * recording.channels * 4 > 900_000);
    transcript
}

/// Fault 25.
#[test]
fn a_study_where_no_folder_can_be_made() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "kept").unwrap();
    let mut studies = vec![file.join("study"), file.clone()];
    if cfg!(target_os = "linux") {
        // No permissions keep the superuser out, but no user can make a folder here.
        studies.push("/proc/study".into());
    }
    for study in studies {
        let output = finish(&mut one_trial(&study));
        let name = study.display().to_string();
        require_failure(output.status, &text(&output), &["cannot create", &name]);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "kept");
    }
}

/// Fault 25.
/// Hazard 14.
#[test]
fn a_session_that_does_not_fit_on_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    // The longest possible protocol: years.
    let conditions: String = (0..63)
        .map(|number| format!("[[conditions]]\nname = \"more-{number}\"\n\n"))
        .collect();
    let protocol = write_demo_protocol(
        folder.path(),
        &[
            ("[[conditions]]", &(conditions + "[[conditions]]")),
            ("per_condition = 4", "per_condition = 1000"),
            ("speed_m_per_s = 0.050", "speed_m_per_s = 0.001"),
            ("countdown_s = 1.0", "countdown_s = 60.0"),
        ],
    );
    let output = finish(&mut headless_run(&study, "sub-01", &protocol));
    let words = ["GB free", "GB are needed", "--study"];
    require_failure(output.status, &text(&output), &words);
    assert!(!study.join("sub-01").exists());
}
