//! A simulated bench that is calibrated through its commands.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use config::CalibrationFile;

use crate::program::bench;
use crate::session::{finish, text};
use crate::shared::shared;

/// `calibrate` with the usual masses, where the simulated bench stands.
pub const WEIGH: [&str; 7] = [
    "force",
    "--normal-g",
    "20,50,100,200",
    "--lateral-g",
    "20,50,100",
    "--gravity",
    "9.80665",
];

/// A simulated bench in a folder of its own, calibrated by its commands.
pub struct Room {
    /// Where its files lie.
    pub folder: tempfile::TempDir,
    /// What is true of it.
    pub scenario: PathBuf,
    seed: String,
}

impl Room {
    /// The bench of `scenario` as `seed` realises it.
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

    /// The nominal bench with pickup, plate and force sensor calibrated, as the first room of this run was.
    ///
    /// # Panics
    /// When a calibration fails.
    pub fn calibrated() -> Self {
        let calibrated = shared("calibrated-room", |folder| {
            let first = Self::new("", 1);
            first.succeed(&["pickup"]);
            first.succeed(&["plate"]);
            first.weigh();
            copy_files(first.folder.path(), folder);
        });
        let room = Self::new("", 1);
        copy_files(&calibrated, room.folder.path());
        room
    }

    /// Where its calibration is kept.
    pub fn calibration(&self) -> PathBuf {
        self.folder.path().join("calibration.toml")
    }

    /// What names this room's simulated bench and its calibration.
    fn on_bench<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command
            .args(["--seed", &self.seed, "--mock"])
            .arg(&self.scenario)
            .arg("--calibration")
            .arg(self.calibration())
    }

    /// A command on this room's simulated bench, with its calibration.
    pub fn command(&self, words: &[&str]) -> Command {
        let mut command = bench();
        self.on_bench(command.args(words).args(["--speed", "max"]));
        command
    }

    /// `calibrate` with these words.
    pub fn calibrate(&self, words: &[&str]) -> Command {
        let mut command = bench();
        command.arg("calibrate").args(words);
        self.on_bench(command.args(["--speed", "max", "--operator", "A. Tester"]));
        command
    }

    /// `check`, whole.
    pub fn check(&self) -> Command {
        let mut command = bench();
        self.on_bench(command.arg("check"));
        command
    }

    /// `calibrate` with these words, which must pass; what it printed.
    pub fn succeed(&self, words: &[&str]) -> String {
        let output = finish(&mut self.calibrate(words));
        assert!(output.status.success(), "{words:?}: {}", text(&output));
        text(&output)
    }

    /// `monitor` for a second.
    pub fn watch(&self) -> Command {
        self.command(&["monitor", "--headless", "--duration-s", "1"])
    }

    /// Calibrates the force sensor with the usual masses.
    pub fn weigh(&self) -> String {
        self.succeed(&WEIGH)
    }

    /// Writes the calibration anew after `change`, as its owner would: with a hash that fits.
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

/// Runs a command that must be refused, and in these words.
pub fn refused(mut command: Command, words: &[&str]) {
    let output = finish(&mut command);
    let said = text(&output);
    assert!(
        !output.status.success(),
        "{command:?} was not refused: {said}"
    );
    for word in words {
        assert!(
            said.contains(word),
            "{command:?} does not say {word:?}: {said}"
        );
    }
    assert!(!said.contains("panicked"), "{said}");
}
