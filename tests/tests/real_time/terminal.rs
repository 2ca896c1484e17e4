//! The dashboard on a real terminal, in real time: it shows the important values and restores the terminal.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]
#![expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use bench_tests::program::{find_program, friction_bench};
use bench_tests::recorded::require_orderly_interruption;
use bench_tests::running::wait_until;
use bench_tests::session::{SessionFolder, finish, patient_config, patient_config_of, text};
use config::CalibrationFile;
use mock_world::scenario::built_in;
use recording::study::LOCK_FILE;
use recording::study::event_log::ExitStatus;
use rustix::process::{Pid, Signal, kill_process};
use tempfile::TempDir;

const PATIENCE: Duration = Duration::from_secs(30);

/// A separate terminal, which ends with the test.
pub(super) struct Terminal {
    tmux: PathBuf,
    pub(super) folder: TempDir,
}

impl Terminal {
    pub(super) fn open(columns: u16, rows: u16, command: &str) -> Self {
        Self::open_prepared(columns, rows, |_| (), command)
    }

    /// Opens a terminal in a folder prepared by `prepare`. The program starts once the file `wait` is gone.
    pub(super) fn open_prepared(
        columns: u16,
        rows: u16,
        prepare: impl FnOnce(&Path),
        command: &str,
    ) -> Self {
        let terminal = Self {
            tmux: find_program("tmux"),
            folder: tempfile::tempdir().unwrap(),
        };
        patient_config(terminal.folder.path());
        prepare(terminal.folder.path());
        let size = [columns.to_string(), rows.to_string()];
        let script = terminal.script(command);
        terminal.tmux(&["new-session", "-d", "-x", &size[0], "-y", &size[1], &script]);
        terminal
    }

    /// Runs another command on the terminal after the previous one has ended.
    pub(super) fn rerun(&self, command: &str) {
        std::fs::remove_file(self.folder.path().join("status")).unwrap();
        self.tmux(&["respawn-pane", "-k", &self.script(command)]);
    }

    fn script(&self, command: &str) -> String {
        format!(
            "export LC_ALL=C.UTF-8; trap : HUP; cd '{}'; while [ -e wait ]; do sleep 0.05; done; stty -g > before; '{}' {command} --config bench.toml; echo $? > status; stty -g > after && {{ trap - HUP; sleep 60; }}",
            self.folder.path().display(),
            friction_bench().display(),
        )
    }

    fn ask(&self, arguments: &[&str]) -> Output {
        finish(
            Command::new(&self.tmux)
                .args(["-f", "/dev/null", "-S"])
                .arg(self.folder.path().join("socket"))
                .args(arguments),
        )
    }

    pub(super) fn tmux(&self, arguments: &[&str]) -> String {
        let output = self.ask(arguments);
        assert!(
            output.status.success(),
            "tmux {arguments:?}: {}",
            text(&output)
        );
        String::from_utf8(output.stdout).unwrap()
    }

    pub(super) fn screen(&self) -> String {
        self.tmux(&["capture-pane", "-p"])
    }

    pub(super) fn expect_text(&self, words: &[&str]) -> String {
        let mut screen = String::new();
        wait_until(PATIENCE, || {
            screen = self.screen();
            words.iter().all(|word| screen.contains(word)).then_some(())
        })
        .unwrap_or_else(|| panic!("no {words:?} in {PATIENCE:?} on:\n{screen}"));
        screen
    }

    /// Requires the command to succeed.
    pub(super) fn require_success(&self) {
        let status = self.expect_file("status");
        assert_eq!(status.trim(), "0", "{}", self.screen());
    }

    /// Returns the script's output in `file`, once it exists.
    pub(super) fn expect_file(&self, file: &str) -> String {
        let path = self.folder.path().join(file);
        wait_until(PATIENCE, || {
            std::fs::read_to_string(&path)
                .ok()
                .filter(|text| !text.is_empty())
        })
        .unwrap_or_else(|| {
            let screen = text(&self.ask(&["capture-pane", "-p"]));
            panic!("no {file}; the screen is:\n{screen}")
        })
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // A test may have closed it already.
        self.ask(&["kill-server"]);
    }
}

fn shows_the_session_and_restores_the_terminal(columns: u16, rows: u16) {
    let command =
        "run --mock --study study --participant sub-01 --protocol demo --consent-by Tester";
    let terminal = Terminal::open(columns, rows, command);
    let screen = terminal.expect_text(&[
        "DRIVING",
        "simulated",
        "UNCALIBRATED",
        "sub-01",
        "practice 1/1",
        "|Z_m|",
        "now",
        "quit",
    ]);
    assert!(
        screen.lines().next().unwrap().contains("DRIVING"),
        "the safety line comes first:\n{screen}"
    );
    // A number, not a placeholder: the bare plate's 7 N·s/m, or more under the finger.
    wait_until(PATIENCE, || {
        let screen = terminal.screen();
        let value = screen.split_once("|Z_m|")?.1.split_whitespace().next()?;
        value
            .replace('−', "-")
            .parse::<f64>()
            .ok()
            .filter(|re| (6.5..40.0).contains(re))
    })
    .unwrap_or_else(|| panic!("no impedance on:\n{}", terminal.screen()));
    assert_eq!(
        terminal
            .tmux(&["display-message", "-p", "#{alternate_on}"])
            .trim(),
        "1"
    );

    terminal.tmux(&["send-keys", "q"]);
    terminal.expect_text(&["Quit?"]);
    terminal.tmux(&["send-keys", "y"]);
    assert_eq!(
        terminal.expect_file("status").trim(),
        "1",
        "a session that is not over"
    );
    assert_eq!(
        terminal.expect_file("after"),
        terminal.expect_file("before")
    );
    let modes = terminal.tmux(&[
        "display-message",
        "-p",
        "#{alternate_on} #{cursor_flag} #{mouse_any_flag}",
    ]);
    assert_eq!(modes.trim(), "0 1 0", "main screen, cursor, no mouse");
    let screen = terminal.screen();
    assert!(
        screen.contains("ended early"),
        "the summary stays on the terminal:\n{screen}"
    );
    assert!(!screen.contains("panicked"), "{screen}");
    let session = SessionFolder::read(&terminal.folder.path().join("study"), "sub-01").unwrap();
    assert_eq!(session.stops()[0].exit_status, ExitStatus::Abort);
}

#[test]
fn the_dashboard_works_on_a_terminal_of_80_by_24() {
    shows_the_session_and_restores_the_terminal(80, 24);
}

#[test]
fn the_dashboard_works_on_a_terminal_of_120_by_40() {
    shows_the_session_and_restores_the_terminal(120, 40);
}

#[test]
fn the_dashboard_asks_about_the_participant_after_consent_and_before_the_drive() {
    let command = "run --mock --study study --participant sub-01 --age 31";
    let terminal = Terminal::open(100, 30, command);
    terminal.expect_text(&["consent"]);
    terminal.tmux(&["send-keys", "c"]);
    terminal.expect_text(&["given consent?"]);
    terminal.tmux(&["send-keys", "y"]);
    let screen = terminal.expect_text(&["sex (1 female, 2 male, 3 other)"]);
    assert!(!screen.contains("DRIVING"), "{screen}");
    terminal.tmux(&["send-keys", "4", "Enter"]);
    terminal.expect_text(&["a number from 1 to 3"]);
    terminal.tmux(&["send-keys", "1", "Enter"]);
    terminal.expect_text(&["writing hand"]);
    terminal.tmux(&["send-keys", "Enter"]);
    terminal.expect_text(&["practice 1/2"]);
    terminal.tmux(&["send-keys", "q"]);
    terminal.expect_text(&["Quit?"]);
    terminal.tmux(&["send-keys", "y"]);
    terminal.expect_file("status");
    let table = terminal.folder.path().join("study/participants.tsv");
    let table = std::fs::read_to_string(table).unwrap();
    assert!(
        table.ends_with("\thuloux2021\t31\tfemale\tn/a\n"),
        "{table}"
    );
}

/// Longest time of an orderly stop.
const STOP: Duration = Duration::from_secs(1);

/// Starts a session and waits until one second of its first trial is recorded; returns it with its process.
pub(super) fn start_first_trial() -> (Terminal, Pid) {
    let command =
        "run --mock --study study --participant sub-01 --protocol demo --consent-by Tester";
    let terminal = Terminal::open(100, 30, command);
    terminal.expect_text(&["DRIVING", "practice 1/1"]);
    let study = terminal.folder.path().join("study");
    let signals = study.join("sub-01/ses-01/practice-01_attempt-1/signals.wav");
    // One second of the four inputs, 4 bytes each.
    let second_recorded = || {
        let bytes = signals.metadata().ok()?.len();
        (bytes > 192_000 * 16).then_some(())
    };
    wait_until(PATIENCE, second_recorded)
        .unwrap_or_else(|| panic!("nothing recorded:\n{}", terminal.screen()));
    let pid = std::fs::read_to_string(study.join(LOCK_FILE)).unwrap();
    (
        terminal,
        Pid::from_raw(pid.trim().parse().unwrap()).unwrap(),
    )
}

/// Ends a session by applying `end` to its process or its terminal, and checks the result.
fn require_orderly_end(end: impl Fn(&Terminal, Pid)) -> Terminal {
    let (terminal, pid) = start_first_trial();
    let start = Instant::now();
    end(&terminal, pid);
    terminal.expect_file("status");
    let duration = start.elapsed();
    assert!(duration < STOP, "the session ended in {duration:?}");
    println!("ended in {} ms", duration.as_millis());
    let session = SessionFolder::read(&terminal.folder.path().join("study"), "sub-01").unwrap();
    require_orderly_interruption(&session);
    terminal
}

fn require_signals_end(signals: &[Signal]) {
    let terminal = require_orderly_end(|_, pid| {
        for signal in signals {
            // A process that has ended after the first signal cannot take the second.
            let _ = kill_process(pid, *signal);
            std::thread::sleep(Duration::from_millis(20));
        }
    });
    assert_eq!(terminal.expect_file("status").trim(), "1");
    terminal.require_restored();
    let screen = terminal.expect_text(&["ended early"]);
    assert!(!screen.contains("panicked"), "{screen}");
}

/// Fault 29.
#[test]
fn sigint_twice_ends_a_session_with_its_dashboard() {
    require_signals_end(&[Signal::INT, Signal::INT]);
}

/// Fault 29.
#[test]
fn sigterm_ends_a_session_with_its_dashboard() {
    require_signals_end(&[Signal::TERM]);
}

/// Fault 29.
#[test]
fn sighup_ends_a_session_with_its_dashboard() {
    require_signals_end(&[Signal::HUP]);
}

/// Fault 29.
#[test]
fn a_terminal_that_is_closed_ends_its_session() {
    let terminal = require_orderly_end(|terminal, _| {
        terminal.tmux(&["kill-server"]);
    });
    // The exit status reports that the terminal failed.
    assert_eq!(terminal.expect_file("status").trim(), "2");
}

/// Seed of the simulated bench that is calibrated here.
const SEED: u64 = 5;

impl Terminal {
    pub(super) fn calibrate(columns: u16, rows: u16, options: &str) -> Self {
        let command =
            format!("calibrate {options} --operator Tester --mock bench-unknown --seed {SEED}");
        Self::open(columns, rows, &command)
    }

    /// Confirms that the plate is clear; it is driven only afterwards.
    pub(super) fn confirm_clear_plate(&self) {
        let screen = self.expect_text(&["Take everything off", "The plate is driven next"]);
        assert!(!screen.contains("DRIVING"), "{screen}");
        self.press(&["Enter"]);
    }

    pub(super) fn press(&self, keys: &[&str]) {
        let mut arguments = vec!["send-keys"];
        arguments.extend(keys);
        self.tmux(&arguments);
    }

    /// Returns the settled reading of the simulated vibrometer, µm, while the plate is driven at `drive_v`.
    fn instrument_um(&self, drive_v: f64) -> f64 {
        let value = |screen: &str, name: &str| {
            let rest = screen.rsplit_once(name)?.1;
            rest.split_whitespace().next()?.parse::<f64>().ok()
        };
        let mut last_um = None;
        wait_until(PATIENCE, || {
            std::thread::sleep(Duration::from_millis(300));
            let screen = self.screen();
            let volts = value(&screen, "drive ").filter(|v| (v / drive_v - 1.0).abs() < 0.1)?;
            let um = value(&screen, "instrument ").filter(|um| *um > 0.0 && volts > 0.0)?;
            let is_settled = last_um
                .replace(um)
                .is_some_and(|last_um: f64| (um / last_um - 1.0).abs() < 2e-3);
            is_settled.then_some(um)
        })
        .unwrap_or_else(|| panic!("no amplitude at {drive_v} V on:\n{}", self.screen()))
    }

    /// Reads the vibrometer and types `factor` times its reading.
    pub(super) fn type_amplitude(&self, drive_v: f64, factor: f64) {
        let um = format!("{:.4}", self.instrument_um(drive_v) * factor);
        self.press(&[&um]);
        self.expect_text(&[&format!("{um}▏")]);
        self.press(&["Enter"]);
    }

    pub(super) fn require_restored(&self) {
        assert_eq!(self.expect_file("after"), self.expect_file("before"));
        let modes = self.tmux(&["display-message", "-p", "#{alternate_on} #{cursor_flag}"]);
        assert_eq!(modes.trim(), "0 1", "main screen, cursor");
    }
}

#[test]
fn an_operator_is_guided_through_the_pickups_calibration_and_measures_a_point_again() {
    let terminal = Terminal::calibrate(80, 24, "pickup --levels-v 10,20,30,40");
    terminal.confirm_clear_plate();
    let screen = terminal.expect_text(&["calibrate pickup", "type it", "DRIVING", "simulated"]);
    let safety_line = screen.lines().next().unwrap();
    assert!(
        safety_line.contains("DRIVING"),
        "the safety line comes first:\n{screen}"
    );
    terminal.type_amplitude(10.0, 1.0);
    terminal.expect_text(&["10.00 V", "step 4 of 7", "predicted"]);
    // Twice the plate's possible amplitude: asked for again.
    terminal.type_amplitude(20.0, 2.0);
    terminal.expect_text(&["peak, not RMS", "step 4 of 7"]);
    // A slip too small to be noticed at once.
    terminal.type_amplitude(20.0, 1.1);
    terminal.expect_text(&["20.00 V", "step 5 of 7"]);
    terminal.type_amplitude(30.0, 1.0);
    terminal.expect_text(&["step 6 of 7"]);
    terminal.type_amplitude(40.0, 1.0);
    let screen = terminal.expect_text(&[
        "measure one of the points",
        "step 7 of 7",
        "worst",
        "depart from a line",
    ]);
    let worst = screen
        .lines()
        .find(|line| line.contains("nm worst"))
        .unwrap();
    assert!(worst.starts_with("▸ 2"), "{screen}");
    // The other points must not be lost with the wrong one.
    terminal.press(&["Enter"]);
    terminal.expect_text(&["do not pass and cannot be put in force", "30.00 V"]);
    terminal.press(&["r"]);
    terminal.type_amplitude(20.0, 1.0);
    terminal.expect_text(&[
        "measure one of the points",
        "Enter accepts",
        "nonlinearity 0.",
    ]);
    let folder = terminal.folder.path();
    assert!(!folder.join("calibration.toml").exists(), "not yet kept");
    terminal.press(&["Enter"]);
    terminal.require_success();
    terminal.require_restored();
    terminal.expect_text(&["calibrate pickup", "passed", "wrote calibration.toml"]);
    let (calibration, _) = CalibrationFile::read(&folder.join("calibration.toml")).unwrap();
    let pickup = calibration.pickup.unwrap();
    let truth = built_in("bench-unknown").unwrap().draw(SEED);
    let error = pickup.metres_per_unit.value / truth.pickup.metres_per_unit - 1.0;
    assert!(error.abs() < 3e-3, "{error}");
    assert_eq!(pickup.points, 4);
    assert!(pickup.measured.method.contains("typed in"));
}

#[test]
fn leaving_a_guided_calibration_writes_nothing() {
    let terminal = Terminal::calibrate(120, 40, "pickup --levels-v 10,20,30");
    terminal.confirm_clear_plate();
    terminal.expect_text(&["type it", "DRIVING"]);
    terminal.type_amplitude(10.0, 1.0);
    terminal.expect_text(&["10.00 V", "step 4 of 6"]);
    terminal.press(&["q"]);
    terminal.expect_text(&["Nothing will be written"]);
    terminal.press(&["y"]);
    assert_eq!(terminal.expect_file("status").trim(), "2");
    terminal.require_restored();
    terminal.expect_text(&["nothing was written"]);
    assert!(!terminal.folder.path().join("calibration.toml").exists());
    assert!(
        !terminal
            .folder
            .path()
            .join("calibration-pickup.csv")
            .exists()
    );
}

#[test]
fn a_stopped_guided_calibration_is_left_in_good_order() {
    let terminal = Terminal::calibrate(80, 24, "pickup --levels-v 10,20,30");
    terminal.confirm_clear_plate();
    terminal.expect_text(&["type it", "DRIVING"]);
    terminal.press(&["e"]);
    let screen = terminal.expect_text(&["TRIPPED", "stopped by the operator", "kept", "quit"]);
    assert!(
        screen.lines().next().unwrap().contains("TRIPPED"),
        "{screen}"
    );
    terminal.press(&["q"]);
    terminal.expect_text(&["Quit the calibration?"]);
    terminal.press(&["y"]);
    assert_eq!(terminal.expect_file("status").trim(), "2");
    terminal.require_restored();
    assert!(!terminal.folder.path().join("calibration.toml").exists());
}

#[test]
fn an_operator_is_guided_through_the_plates_calibration() {
    let terminal = Terminal::calibrate(120, 40, "plate");
    terminal.confirm_clear_plate();
    let screen = terminal.expect_text(&[
        "calibrate plate",
        "measure one of the points",
        "resonance",
        "quality",
    ]);
    assert!(
        screen.contains("calibrate pickup` first"),
        "what is missing is told:\n{screen}"
    );
    terminal.press(&["Enter"]);
    terminal.expect_text(&["Enter once more"]);
    terminal.press(&["Enter"]);
    assert_eq!(
        terminal.expect_file("status").trim(),
        "1",
        "without a sensitivity it does not pass"
    );
    terminal.require_restored();
    terminal.expect_text(&["FAILED"]);
}

impl Terminal {
    /// Confirms each request until `words` is on the screen.
    fn obey_until(&self, words: &str) -> String {
        wait_until(4 * PATIENCE, || {
            let screen = self.screen();
            if screen.contains(words) {
                return Some(screen);
            }
            if screen.contains("Enter when done") {
                self.press(&["Enter"]);
            }
            None
        })
        .unwrap_or_else(|| panic!("no {words:?} on:\n{}", self.screen()))
    }
}

#[test]
fn an_operator_names_the_masses_and_is_guided_through_the_force_sensors_calibration() {
    let terminal = Terminal::calibrate(80, 24, "force");
    terminal.expect_text(&["calibrate force", "put on the plate", "no points yet"]);
    terminal.press(&["100", "Enter"]);
    terminal.expect_text(&["100 g normal"]);
    terminal.press(&["2000", "Enter"]);
    terminal.expect_text(&["2000 g weigh", "use masses up to"]);
    terminal.press(&["50", "Enter"]);
    terminal.expect_text(&["50 g normal"]);
    terminal.press(&["Enter"]);
    terminal.expect_text(&["over the pulley"]);
    terminal.press(&["Enter"]);
    terminal.expect_text(&["step 1 of 5", "Take everything off"]);
    let screen = terminal.obey_until("measure one of the points");
    assert!(
        screen.contains("50 g lateral") && screen.contains("worst"),
        "{screen}"
    );
    terminal.press(&["Enter"]);
    terminal.require_success();
    terminal.require_restored();
    let path = terminal.folder.path().join("calibration.toml");
    let (calibration, _) = CalibrationFile::read(&path).unwrap();
    assert_eq!(calibration.force.unwrap().masses, 4);
}

#[test]
fn an_operator_is_guided_through_the_channels_calibration() {
    // Regression test: a field box reports its e-stop only after the streams have opened, and no delay was measured.
    let prepare = |folder: &Path| {
        patient_config_of(folder, "field-box");
    };
    let command = "calibrate channels --operator Tester --mock field-box";
    let terminal = Terminal::open_prepared(100, 30, prepare, command);
    terminal.expect_text(&["calibrate channels", "all inputs at once"]);
    terminal.press(&["Enter"]);
    terminal.obey_until("leave the other inputs open");
    terminal.obey_until("as for a measurement");
    terminal.press(&["Enter"]);
    terminal.expect_text(&["Keep them"]);
    let path = terminal.folder.path().join("calibration.toml");
    assert!(!path.exists(), "not yet kept");
    terminal.press(&["Enter"]);
    let status = terminal.expect_file("status");
    assert_eq!(status.trim(), "0", "{}", terminal.screen());
    terminal.require_restored();
    let path = terminal.folder.path().join("calibration.toml");
    let (calibration, _) = CalibrationFile::read(&path).unwrap();
    let channels = calibration.channels.unwrap();
    assert!(channels.loop_delay.is_some(), "{}", terminal.screen());
}
