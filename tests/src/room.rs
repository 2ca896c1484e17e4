//! A simulated bench that is calibrated through its commands.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use config::CalibrationFile;

use crate::program::bench;
use crate::session::{finish, text};
use crate::shared::shared_folder;

/// Words of `calibrate` for the usual masses at the simulated bench's site.
pub const WEIGH: [&str; 7] = [
    "force",
    "--normal-g",
    "20,50,100,200",
    "--lateral-g",
    "20,50,100",
    "--gravity",
    "9.80665",
];

/// A simulated bench in its own folder, calibrated by its commands.
pub struct Room {
    /// Folder of its files.
    pub folder: tempfile::TempDir,
    /// Scenario file with the true constants.
    pub scenario: PathBuf,
    seed: String,
}

impl Room {
    /// Returns the bench of `scenario` as `seed` realises it.
    pub fn new(scenario: &str, seed: u64) -> Self {
        let folder = tempfile::tempdir().expect("a room of its own");
        let path = folder.path().join("scenario.toml");
        fs::write(&path, scenario).expect("a room of its own");
        Self {
            folder,
            scenario: path,
            seed: seed.to_string(),
        }
    }

    /// Returns the nominal bench with pickup, plate and force sensor calibrated; the calibration is made once per run and
    /// copied.
    ///
    /// # Panics
    /// When a calibration fails.
    pub fn calibrated() -> Self {
        let calibrated = shared_folder("calibrated-room", |folder| {
            let bench = Self::new("", 1);
            bench.succeed(&["pickup"]);
            bench.succeed(&["plate"]);
            bench.weigh();
            copy_files(bench.folder.path(), folder);
        });
        let room = Self::new("", 1);
        copy_files(&calibrated, room.folder.path());
        room
    }

    /// Returns the path of its calibration.
    pub fn calibration(&self) -> PathBuf {
        self.folder.path().join("calibration.toml")
    }

    /// Adds the options that select this room's simulated bench and its calibration.
    fn add_bench_options<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command
            .args(["--seed", &self.seed, "--mock"])
            .arg(&self.scenario)
            .arg("--calibration")
            .arg(self.calibration())
    }

    /// Returns a command on this room's simulated bench, with its calibration.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = bench();
        self.add_bench_options(command.args(words).args(["--speed", "max"]));
        command
    }

    /// Returns `calibrate` with these words.
    pub fn calibrate(&self, words: &[&str]) -> Command {
        let mut command = bench();
        command.arg("calibrate").args(words);
        self.add_bench_options(command.args(["--speed", "max", "--operator", "A. Tester"]));
        command
    }

    /// Returns a complete `check`, for a session that has room on any disk.
    pub fn check(&self) -> Command {
        let mut command = bench();
        self.add_bench_options(command.args(["check", "--protocol", "demo"]));
        command
    }

    /// Runs `calibrate` with these words, which must pass; returns its output.
    pub fn succeed(&self, words: &[&str]) -> String {
        let output = finish(&mut self.calibrate(words));
        assert!(output.status.success(), "{words:?}: {}", text(&output));
        text(&output)
    }

    /// Returns `monitor` for one second.
    pub fn watch(&self) -> Command {
        self.command(&["monitor", "--headless", "--duration-s", "1"])
    }

    /// Calibrates the force sensor with the usual masses.
    pub fn weigh(&self) -> String {
        self.succeed(&WEIGH)
    }

    /// Rewrites the calibration after `change`, as its owner would: with a matching hash.
    pub fn change(&self, change: impl FnOnce(&mut CalibrationFile)) {
        let (mut calibration, _) =
            CalibrationFile::read(&self.calibration()).expect("a room of its own");
        change(&mut calibration);
        let text = calibration.to_text().expect("a calibration that was read");
        fs::write(self.calibration(), text).expect("a room of its own");
    }
}

fn copy_files(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_file() {
            let name = path.file_name().expect("a file's name");
            fs::copy(&path, to.join(name)).expect("a copy");
        }
    }
}

/// Runs a command that must be refused with these words.
pub fn require_refusal(mut command: Command, words: &[&str]) {
    let output = finish(&mut command);
    let transcript = text(&output);
    assert!(
        !output.status.success(),
        "{command:?} was not refused: {transcript}"
    );
    for word in words {
        assert!(
            transcript.contains(word),
            "{command:?} does not say {word:?}: {transcript}"
        );
    }
    assert!(!transcript.contains("panicked"), "{transcript}");
}
