//! Panics in a part of a driving bench: the drive is silent in time, recorded data is kept, the terminal is restored, and the
//! user learns which part failed and what to do. Each bench is a separate process, since a panic silences every drive in it.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, ExitStatus};
use std::time::Duration;

use bench_tests::panicking::{HAND, OTHER_THREAD, Report};
use bench_tests::program::workspace;
use bench_tests::running::wait_until;
use bench_tests::screen::{Screen, last_characters};
use bench_tests::session::{SessionFolder, patient_config};
use recording::RecordingReader;
use recording::manifest::End;
use recording::study::event_log;
use rustix::termios::LocalModes;

const MINUTE: Duration = Duration::from_secs(60);
/// Longest time from the panic to a still plate: the ramp and the plate's decay take 15 ms.
const STILL_NS: u64 = 50_000_000;
/// Longest time from the panic to the last edge of the heartbeat, and from there to the enable line, on a busy machine.
const LINES_NS: u64 = 200_000_000;

/// A bench that was driving when one of its parts panicked.
struct PanicRun {
    part: &'static str,
    folder: tempfile::TempDir,
    status: ExitStatus,
    /// Everything shown on its terminal.
    transcript: String,
    /// Whether the terminal was restored.
    is_restored: bool,
    report: Report,
}

impl PanicRun {
    fn bench(part: &'static str, command: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let config = patient_config(folder.path());
        let mut screen = Screen::open(100, 30);
        let modes = screen.local_modes();
        let mut bench = Command::new(env!("CARGO_BIN_EXE_panicking-bench"));
        bench
            .arg(part)
            .arg(folder.path())
            .args(command.split_whitespace())
            .arg("--config")
            .arg(&config)
            .current_dir(folder.path())
            .env("RUST_BACKTRACE", "1");
        screen.attach(&mut bench);
        let mut child = bench.spawn().unwrap();
        drop(bench);
        let mut is_idle = true;
        let status = wait_until(MINUTE, || {
            if is_idle && screen.output().contains("begins") {
                // A session waits for its participant, or for the operator's space bar.
                screen.press(" ");
                is_idle = false;
            }
            child.try_wait().unwrap()
        });
        if status.is_none() {
            child.kill().unwrap();
            child.wait().unwrap();
        }
        let final_modes = screen.local_modes();
        let transcript = screen.read_to_end();
        let status = status
            .unwrap_or_else(|| panic!("{part}: still running; {}", last_characters(&transcript)));
        let report = std::fs::read(folder.path().join("report.json"));
        let report = report
            .unwrap_or_else(|error| panic!("{part}: {error}; {}", last_characters(&transcript)));
        Self {
            part,
            status,
            is_restored: modes == final_modes
                && final_modes.contains(LocalModes::ICANON | LocalModes::ECHO),
            transcript,
            report: serde_json::from_slice(&report).unwrap(),
            folder,
        }
    }

    /// Requires the drive to be silent in time, by every means, and to stay silent.
    fn require_safe(&self) {
        let Self { part, report, .. } = self;
        let panicked_ns = report.panicked_ns;
        assert!(
            panicked_ns > 0,
            "{part} never panicked: {}",
            last_characters(&self.transcript)
        );
        let last_edge = |line: &str| report.edges.iter().rfind(|edge| edge.line == line).unwrap();
        let beat = last_edge("heartbeat");
        assert!(
            beat.at_ns < panicked_ns + LINES_NS,
            "{part}: {beat:?} after {panicked_ns}"
        );
        let enable = last_edge("enable");
        assert!(!enable.high, "{part}: still enabled");
        assert!(
            enable.at_ns < panicked_ns + 2 * LINES_NS,
            "{part}: {enable:?} after {panicked_ns}"
        );
        let amplitude_m = |from_ns: u64, to_ns: u64| {
            let truth = std::fs::read_to_string(self.folder.path().join("truth.csv")).unwrap();
            let rows = truth.lines().skip(1).map(|line| {
                let value = |cell: &str| cell.parse::<f64>().unwrap();
                let cells: Vec<&str> = line.split(',').collect();
                ((1e9 * value(cells[0])) as u64, value(cells[13]))
            });
            let rows = rows.filter(|(time_ns, _)| (from_ns..to_ns).contains(time_ns));
            rows.map(|(_, amplitude_m)| amplitude_m).fold(0.0, f64::max)
        };
        let driven_m = amplitude_m(panicked_ns - 300_000_000, panicked_ns);
        assert!(driven_m > 1e-8, "{part}: {driven_m} m before");
        let residual_m = amplitude_m(panicked_ns + STILL_NS, u64::MAX);
        assert!(
            residual_m < 0.01 * driven_m,
            "{part}: {residual_m} m of {driven_m} m"
        );
    }

    /// Requires a restored terminal with a message that names the part and the remedy.
    fn require_words(&self) {
        let Self {
            part, transcript, ..
        } = self;
        assert!(self.is_restored, "{part}: the terminal is not as before");
        assert_ne!(self.status.code(), None, "{part}: {}", self.status);
        assert!(!self.status.success(), "{part}");
        let message = match transcript.rsplit_once("\x1b[?1049l") {
            Some((_, message)) => message,
            None => transcript,
        };
        assert!(
            !transcript.contains("\x1b[?1049h") || message.len() < transcript.len(),
            "{part}: {}",
            last_characters(transcript)
        );
        // Lines are broken at the terminal's width.
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        for words in [
            &format!("an error in the program itself, in its part `{part}`: on purpose"),
            "look at the plate",
        ] {
            assert!(
                message.contains(words),
                "{part}: no {words:?} in {message:?}"
            );
        }
        for words in ["panicked at", "RUST_BACKTRACE", "stack backtrace"] {
            assert!(
                !transcript.contains(words),
                "{part}: {words:?} in {message:?}"
            );
        }
    }

    /// Requires the interrupted recording to be readable, and the log to be whole.
    fn require_recording(&self) {
        let Self {
            part, transcript, ..
        } = self;
        let session = SessionFolder::read(&self.folder.path().join("study"), "sub-01").unwrap();
        let recordings = session.recordings();
        assert_eq!(
            recordings.len(),
            1,
            "{part}: {}",
            last_characters(transcript)
        );
        let reader = RecordingReader::open(&recordings[0]).unwrap();
        let duration_s = reader.frames() as f64 / f64::from(reader.format().sample_rate_hz);
        assert!(duration_s > 0.3, "{part}: {duration_s} s kept");
        let trial = reader.manifest().trial.as_ref().unwrap();
        assert_eq!(trial.end, Some(End::Interrupted), "{part}: {trial:?}");
        let reason = trial.interruption.clone().unwrap_or_default();
        assert!(reason.contains(&format!("`{part}`")), "{part}: {reason}");
        let [stop] = &session.stops()[..] else {
            panic!("{part}: {:?}", session.stops());
        };
        assert_eq!(stop.exit_status, event_log::ExitStatus::Fail, "{part}");
        session.require_whole();
    }

    /// Returns the bench's tasks.
    fn tasks(&self) -> BTreeSet<&str> {
        let readers = self.report.clock_readers.iter().map(String::as_str);
        readers
            .filter(|name| !["main", HAND, ""].contains(name))
            .collect()
    }
}

/// Makes each of these parts of the bench panic in turn.
fn require_panics(command: &str, parts: &[&'static str], check: fn(&PanicRun)) {
    let tasks: BTreeSet<&str> = parts
        .iter()
        .copied()
        .filter(|part| *part != OTHER_THREAD)
        .collect();
    for part in parts {
        let bench = PanicRun::bench(part, command);
        bench.require_safe();
        bench.require_words();
        check(&bench);
        let untested: Vec<_> = bench
            .tasks()
            .difference(&tasks)
            .map(ToString::to_string)
            .collect();
        assert!(untested.is_empty(), "no test lets {untested:?} panic");
    }
}

const SESSION: [&str; 12] = [
    "safety",
    "field",
    "session",
    "refit",
    "acquisition",
    "recorder",
    "journal",
    "room",
    "interference",
    "driving time",
    "plate's warmth",
    OTHER_THREAD,
];
/// Tasks without a test: a replay drives nothing, and the task of the participant's window needs a window; the session's
/// schedule runs it like the others.
const UNTESTED: [&str; 2] = ["replay", "participant's window"];
/// The task that each other command has in place of the session's.
const OTHER_COMMANDS: [(&str, &str); 4] = [
    ("monitor", "monitor --mock --uncalibrated --drive-v 10"),
    (
        "calibration",
        "calibrate plate --mock --operator Tester --headless",
    ),
    ("check", "check --mock --quick"),
    (
        "drill",
        "drill --mock --uncalibrated --headless --operator Tester --only estop",
    ),
];

/// Fault 30.
/// Hazard 15.
#[test]
fn a_panic_in_any_part_of_a_session_stops_the_drive_then_keeps_the_files_then_restores_the_terminal()
 {
    let command =
        "run --mock --study study --participant sub-01 --protocol demo --consent-by Tester";
    require_panics(command, &SESSION, PanicRun::require_recording);
}

/// Fault 30.
#[test]
fn a_panic_in_any_other_command_that_drives_stops_the_drive_and_restores_the_terminal() {
    for (part, command) in OTHER_COMMANDS {
        let bench = PanicRun::bench(part, command);
        bench.require_safe();
        bench.require_words();
    }
}

/// Each task of the program has a panic test above, or a reason to have none.
#[test]
fn every_task_has_a_panic_test() {
    let mut names = BTreeSet::new();
    let mut folders = vec![workspace().join("bench")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && path.file_name().unwrap() != "tests" {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                names.extend(tasks_of(&path));
            }
        }
    }
    let mut tested: BTreeSet<_> = SESSION.map(str::to_owned).into();
    tested.extend(OTHER_COMMANDS.map(|(task, _)| task.to_owned()));
    tested.remove(OTHER_THREAD);
    tested.extend(UNTESTED.map(str::to_owned));
    assert_eq!(names, tested);
}

/// Returns the names of the tasks that a source file implements, without its tests.
fn tasks_of(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    let code: String = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect();
    let tasks = code.split("Task for ").skip(1);
    let name = |task: &str| Some(task.split_once("fn name")?.1.split('"').nth(1)?.to_owned());
    tasks.map(|task| name(task).unwrap()).collect()
}
