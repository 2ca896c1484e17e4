//! Sessions that are terminated or killed in the middle of a trial in real time: recorded data is kept, and the session can be
//! resumed.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]
#![expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use bench_tests::program::bench;
use bench_tests::recorded::{Recording, require_orderly_interruption};
use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, finish, patient_config, text, write_demo_protocol};
use recording::study::event_log::ExitStatus;
use rustix::process::Signal;
use serde_json::Value;
use tempfile::TempDir;

const MINUTE: Duration = Duration::from_secs(60);
/// Longest time of an orderly stop.
const STOP: Duration = Duration::from_secs(1);
/// Greatest part of a recording that a kill may lose, s.
const LOSS_S: f64 = 1.0;

/// A study for a protocol of three conditions in random order, on a bench that tolerates a busy machine.
struct StudyFolder {
    folder: TempDir,
    study: PathBuf,
    protocol: PathBuf,
    config: PathBuf,
}

impl StudyFolder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let conditions = "[[conditions]]\nname = \"slow\"\nmodulation_hz = 3.0\n\n[[conditions]]\nname = \"am-6hz-95\"\n\n\
                          [[conditions]]\nname = \"middle\"\nmodulation_hz = 4.5\n";
        let protocol = write_demo_protocol(
            folder.path(),
            &[
                ("practice = 1", "practice = 0"),
                ("per_condition = 4", "per_condition = 1"),
                ("order = \"fixed\"", "order = \"randomised\""),
                ("[[conditions]]", "[[removed]]"),
                (
                    "[\"left_to_right\", \"right_to_left\"]",
                    "[\"left_to_right\"]",
                ),
                ("min_instances = 5", "min_instances = 1"),
            ],
        );
        let text = std::fs::read_to_string(&protocol).unwrap();
        let (head, tail) = text.split_once("[[removed]]").unwrap();
        let tail = &tail[tail.find("[trials]").unwrap()..];
        std::fs::write(&protocol, format!("{head}{conditions}\n{tail}")).unwrap();
        let config = patient_config(folder.path());
        Self {
            study: folder.path().join("study"),
            protocol,
            config,
            folder,
        }
    }

    fn run(&self, speed: &str) -> Command {
        let mut command = bench();
        command
            .args([
                "run",
                "--mock",
                "--headless",
                "--speed",
                speed,
                "--seed",
                "5",
            ])
            .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
            .arg("--study")
            .arg(&self.study)
            .arg("--protocol")
            .arg(&self.protocol)
            .arg("--config")
            .arg(&self.config);
        command
    }

    fn session(&self) -> SessionFolder {
        SessionFolder::read(&self.study, "sub-01").unwrap()
    }

    /// Starts a session in real time and waits for `duration` after the folder of its first trial appears. Returns the session
    /// and the time of the folder's appearance.
    ///
    /// # Panics
    /// When the session ends first: on a late machine the safety watch ends it.
    fn start_first_trial(&self, duration: Duration) -> (Running, Instant) {
        let mut running = Running::start(&mut self.run("real"), &self.folder.path().join("output"));
        let session = self.study.join("sub-01/ses-01");
        let trial = running.wait_for(MINUTE, || first_trial(&session));
        assert!(trial.is_some(), "no trial: {}", running.output());
        let appearance = Instant::now();
        let continuation =
            running.wait_for(MINUTE, || (appearance.elapsed() >= duration).then_some(()));
        assert!(continuation.is_some(), "ended: {}", running.output());
        (running, appearance)
    }

    /// Resumes the session and completes it as fast as it computes.
    fn resume(&self) -> SessionFolder {
        let output = finish(self.run("max").arg("--resume"));
        assert!(output.status.success(), "{}", text(&output));
        self.session()
    }
}

/// Returns the trial's folder, once it has signals.
fn first_trial(session: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(session).ok()?;
    entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(|path| path.join("signals.wav").is_file())
}

fn order(event: &Value) -> Vec<String> {
    let names = event["order"].as_array().unwrap().iter();
    names
        .map(|name| name.as_str().unwrap().to_owned())
        .collect()
}

/// Requires the resumed session to repeat the interrupted trial and keep the order.
fn require_same_order(session: &SessionFolder) {
    let starts = session.starts();
    assert_eq!(
        starts.iter().map(|start| start.resumed).collect::<Vec<_>>(),
        [false, true]
    );
    let orders: Vec<_> = session
        .named("session_started")
        .map(|event| order(&event.data.clone().into()))
        .collect();
    assert_eq!(orders.len(), 2);
    assert_eq!(orders[0], orders[1]);
    let mut conditions = orders[0].clone();
    conditions.sort();
    assert_eq!(conditions, ["am-6hz-95", "middle", "slow"]);
    let accepted_conditions: Vec<_> = session
        .named("trial_settled")
        .map(|event| &event.data["record"])
        .filter(|record| {
            record["outcome"]["outcome"] == "accepted" || record["outcome"] == "accepted"
        })
        .map(|record| record["key"]["condition"].as_str().unwrap())
        .collect();
    assert_eq!(
        accepted_conditions,
        orders[0].iter().map(String::as_str).collect::<Vec<_>>()
    );
    assert_eq!(
        session.stops().last().unwrap().exit_status,
        ExitStatus::Success
    );
    // The interrupted attempt is kept next to its repetition.
    let recordings = session.recordings();
    let names: Vec<_> = recordings
        .iter()
        .map(|path| path.file_name().unwrap().to_str().unwrap())
        .collect();
    assert!(
        names.contains(&"trial-001_attempt-1") && names.contains(&"trial-001_attempt-2"),
        "{names:?}"
    );
}

/// Sends `signal` in the middle of a trial; returns the place with the remaining files, and the time to the end.
fn interrupt(signal: Signal) -> (StudyFolder, Duration) {
    let folder = StudyFolder::new();
    let (mut running, _) = folder.start_first_trial(Duration::from_millis(1500));
    let start = Instant::now();
    running.signal(signal);
    let status = running.wait(MINUTE);
    let duration = start.elapsed();
    let transcript = running.output();
    // On a late machine the safety watch stops the session before this test does.
    assert!(
        transcript.contains("stopped before its end"),
        "{transcript}"
    );
    assert_eq!(status.code(), Some(1), "{transcript}");
    assert!(!transcript.contains("panicked"), "{transcript}");
    (folder, duration)
}

fn require_orderly_end(signal: Signal) {
    let (folder, duration) = interrupt(signal);
    assert!(
        duration < STOP,
        "{signal:?} ended a session in {duration:?}"
    );
    println!("{signal:?}: ended in {} ms", duration.as_millis());

    let session = folder.session();
    let recording = require_orderly_interruption(&session);
    assert!(recording.greatest_phase_step_rad() < 0.01);
    require_same_order(&folder.resume());
}

/// Fault 29.
#[test]
fn sigint_ends_a_session_in_good_order() {
    require_orderly_end(Signal::INT);
}

/// Fault 29.
#[test]
fn sigterm_ends_a_session_in_good_order() {
    require_orderly_end(Signal::TERM);
}

/// Fault 29.
#[test]
fn sighup_ends_a_session_in_good_order() {
    require_orderly_end(Signal::HUP);
}

/// Fault 28.
#[test]
fn sigquit_ends_a_session_in_good_order() {
    require_orderly_end(Signal::QUIT);
}

#[test]
fn a_signal_during_the_test_of_the_bench_says_nothing_about_the_bench() {
    let mut interrupted = 0;
    for delay_ms in [50, 100, 200, 400, 800] {
        let folder = StudyFolder::new();
        let output = folder.folder.path().join("output");
        let mut running = Running::start(&mut folder.run("max"), &output);
        let start = Instant::now();
        let delay = Duration::from_millis(delay_ms);
        running.wait_for(MINUTE, || (start.elapsed() >= delay).then_some(()));
        running.signal(Signal::TERM);
        running.wait(MINUTE);
        let transcript = running.output();
        assert!(!transcript.contains("is not ready"), "{transcript}");
        interrupted += u32::from(transcript.contains("during the test of the bench"));
    }
    println!("{interrupted} of 5 signals came during the test of the bench");
}

#[test]
fn sigkill_at_any_moment_takes_at_most_a_second() {
    for delay_ms in [170, 1430, 3070] {
        let loss_s = kill(Duration::from_millis(delay_ms));
        assert!(
            loss_s < LOSS_S,
            "killed after {delay_ms} ms: {loss_s} s are gone"
        );
        println!("killed after {delay_ms} ms: {loss_s:.3} s lost");
    }
}

/// Kills a session; returns the time between the kill and the last sample on disk, s. All else must be readable, and the
/// session resumable.
fn kill(delay: Duration) -> f64 {
    let folder = StudyFolder::new();
    let (mut running, appearance) = folder.start_first_trial(delay);
    running.signal(Signal::KILL);
    let recorded_s = appearance.elapsed().as_secs_f64();
    let status = running.wait(MINUTE);
    assert_eq!(status.code(), None, "ended by itself: {}", running.output());
    let session = folder.session();
    assert!(session.stops().is_empty());
    let recording = Recording::read(&session.recordings()[0]);
    let trial = recording.manifest.trial.as_ref().unwrap();
    assert_eq!(trial.end, None);
    assert!(
        recording
            .warnings
            .iter()
            .any(|warning| warning.contains("cut off")),
        "{:?}",
        recording.warnings
    );
    assert_eq!(recording.nonfinite_samples(), 0);
    require_same_order(&folder.resume());
    recorded_s - recording.duration_s()
}
