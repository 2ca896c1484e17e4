//! Test of the e-stop: a person presses it, and the bench sees its loop open and close again. A file in the folder of
//! the calibration records the press, because a bench may be driven only within some hours of it.

use std::path::{Path, PathBuf};

use config::{Config, GpioBackend};
use jiff::Timestamp;
use recording::disk::replace_file;
use serde::{Deserialize, Serialize};

use crate::machine;

/// Longest wait for the press, and for the release, s.
pub const PATIENCE_S: f64 = 60.0;
/// Time for which a level must last to count, s: a contact bounces.
const STEADY_S: f64 = 0.05;

/// Action required of the person at the e-stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PressStep {
    /// The e-stop is open already: it must be released first.
    ReleaseFirst,
    /// Press it.
    Press,
    /// Release it.
    Release,
    /// It was pressed and released.
    Done,
    /// The action was not done in time.
    TimedOut,
}

/// Progress of one press, fed with the level of the line.
#[derive(Debug, Clone, Copy)]
pub struct PressTest {
    step: PressStep,
    /// Start of the wait for the step, and since when the line has had the level that ends it, s.
    request_s: f64,
    reached_s: Option<f64>,
}

impl PressTest {
    /// Begins at `now_s` with the line at a level; high is a closed loop.
    #[must_use]
    pub fn new(high: bool, now_s: f64) -> Self {
        Self {
            step: if high {
                PressStep::Press
            } else {
                PressStep::ReleaseFirst
            },
            request_s: now_s,
            reached_s: None,
        }
    }

    /// Takes the level of the line at `now_s`; returns the required action.
    pub fn poll(&mut self, high: bool, now_s: f64) -> PressStep {
        let next = match self.step {
            PressStep::ReleaseFirst if high => PressStep::Press,
            PressStep::Press if !high => PressStep::Release,
            PressStep::Release if high => PressStep::Done,
            last @ (PressStep::Done | PressStep::TimedOut) => return last,
            waiting => {
                self.reached_s = None;
                if now_s - self.request_s > PATIENCE_S {
                    self.step = PressStep::TimedOut;
                    return self.step;
                }
                return waiting;
            }
        };
        if now_s - *self.reached_s.get_or_insert(now_s) >= STEADY_S {
            *self = Self {
                step: next,
                request_s: now_s,
                reached_s: None,
            };
        }
        self.step
    }
}

/// Record of the latest press.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstopPress {
    /// Time at which it was pressed and released.
    pub pressed: Timestamp,
    /// Line on which the press was seen: a press of another bench proves nothing.
    pub line: String,
    /// Computer that saw the press, since each computer has a line of this name; absent if it has no identifier.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
}

/// A press that is missing, too old, of another line, or dated in the future.
#[derive(Debug, thiserror::Error)]
pub enum EstopPressError {
    /// The e-stop has no record of a press.
    #[error("the e-stop has never been tested on this bench: {HOW}")]
    Never,
    /// The record cannot be read.
    #[error("{} cannot be used: {HOW}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Cause of the failure.
        source: anyhow::Error,
    },
    /// The record is of another line.
    #[error("the e-stop was tested on {found}, and this bench has it on {line}: {HOW}")]
    OtherLine {
        /// Line of the record.
        found: String,
        /// Line of this bench.
        line: String,
    },
    /// The record is of another computer.
    #[error("the e-stop was tested on another computer: {HOW}")]
    OtherComputer,
    /// The press is too long ago.
    #[error(
        "the e-stop was last tested {hours:.1} hours ago, more than safety.estop_test_hours = {most}: {HOW}"
    )]
    TooOld {
        /// Age, h.
        hours: f64,
        /// Largest age allowed, h.
        most: f64,
    },
    /// The press is dated in the future.
    #[error(
        "the e-stop was tested at {pressed}, in the future: set the computer's clock, or: {HOW}"
    )]
    Future {
        /// Date of the press.
        pressed: Timestamp,
    },
}

const HOW: &str = "press it once, `friction-bench check --press-estop`";
/// Largest lead of a date that the clock's inaccuracy explains, h.
const AHEAD_H: f64 = 0.1;

/// Returns the path of the record, in the folder of the calibration at `calibration` and named after it: several
/// benches may have their files in one folder. The `estop.toml` of earlier versions, which may belong to any of them,
/// is not read.
#[must_use]
pub fn record_path(calibration: &Path) -> PathBuf {
    let stem = calibration.file_stem().unwrap_or_default();
    calibration.with_file_name(format!("{}-estop.toml", stem.to_string_lossy()))
}

/// Returns the name of the line to which the e-stop of `config` is wired; `None` without an e-stop.
#[must_use]
pub fn line_name(config: &Config) -> Option<String> {
    let gpio = &config.gpio;
    if gpio.backend == GpioBackend::FieldBox {
        let field_box = config.field_box.as_ref()?.identity();
        return Some(format!("field box {field_box}, e-stop"));
    }
    let line = gpio.estop?;
    let chip = match (gpio.backend, &gpio.chip) {
        (GpioBackend::Gpiocdev, Some(chip)) => chip.display().to_string(),
        (GpioBackend::Nidaqmx, _) => format!("nidaqmx {}", config.audio.input_device),
        (backend, _) => format!("{backend:?}").to_lowercase(),
    };
    Some(format!("{chip}, line {line}"))
}

impl EstopPress {
    /// Writes the record of a press on `line` now.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn record(path: &Path, line: String, pressed: Timestamp) -> anyhow::Result<Self> {
        let press = Self {
            pressed,
            line,
            machine: machine::id(),
        };
        replace_file(path, toml::to_string(&press)?.as_bytes())?;
        Ok(press)
    }

    /// Returns the record at `path` if it is of `line` of this computer and not older than `most_hours` at `now`.
    ///
    /// # Errors
    /// [`EstopPressError`] names the fault of the record and the remedy.
    pub fn require(
        path: &Path,
        line: &str,
        now: Timestamp,
        most_hours: f64,
    ) -> Result<Self, EstopPressError> {
        let unreadable = |source: anyhow::Error| EstopPressError::Unreadable {
            path: path.to_owned(),
            source,
        };
        let text = match bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(EstopPressError::Never);
            }
            Err(error) => return Err(unreadable(error.into())),
        };
        let press: Self = toml::from_str(&text)
            .map_err(|_| unreadable(anyhow::anyhow!("it is damaged, or of another version")))?;
        if press.line != line {
            return Err(EstopPressError::OtherLine {
                found: press.line,
                line: line.to_owned(),
            });
        }
        if press.machine != machine::id() {
            return Err(EstopPressError::OtherComputer);
        }
        let hours = now.duration_since(press.pressed).as_secs_f64() / 3600.0;
        if hours < -AHEAD_H {
            return Err(EstopPressError::Future {
                pressed: press.pressed,
            });
        }
        if hours > most_hours {
            return Err(EstopPressError::TooOld {
                hours,
                most: most_hours,
            });
        }
        Ok(press)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(levels: &[(bool, f64)]) -> Vec<PressStep> {
        let mut test = PressTest::new(levels[0].0, 0.0);
        let (mut now_s, mut sequence) = (0.0, Vec::new());
        for &(high, for_s) in levels {
            let until_s = now_s + for_s;
            while now_s < until_s {
                let step = test.poll(high, now_s);
                if sequence.last() != Some(&step) {
                    sequence.push(step);
                }
                now_s += 0.01;
            }
        }
        sequence
    }

    #[test]
    fn a_press_is_seen_open_and_closed() {
        use PressStep::{Done, Press, Release, ReleaseFirst};
        assert_eq!(
            steps(&[(true, 1.0), (false, 1.0), (true, 1.0)]),
            [Press, Release, Done]
        );
        assert_eq!(
            steps(&[(false, 1.0), (true, 1.0), (false, 1.0), (true, 1.0)]),
            [ReleaseFirst, Press, Release, Done]
        );
    }

    #[test]
    fn a_bouncing_contact_is_no_press() {
        let bounce = [
            (true, 0.1),
            (false, 0.02),
            (true, 0.02),
            (false, 0.03),
            (true, 1.0),
        ];
        assert_eq!(steps(&bounce), [PressStep::Press]);
    }

    #[test]
    fn the_wait_for_a_press_has_a_limit() {
        use PressStep::{Press, Release, TimedOut};
        assert_eq!(steps(&[(true, 61.0)]), [Press, TimedOut]);
        // A cut wire stays open.
        assert_eq!(
            steps(&[(true, 1.0), (false, 62.0)]),
            [Press, Release, TimedOut]
        );
    }

    /// Hazard 16.
    #[test]
    fn two_benches_in_one_folder_have_a_record_each() {
        let [a, b] = ["a.toml", "b.toml"].map(|name| record_path(&Path::new("benches").join(name)));
        assert_eq!(a, Path::new("benches").join("a-estop.toml"));
        assert_ne!(a, b);
    }

    /// Fault 51.
    #[test]
    fn only_a_fresh_press_of_this_line_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = record_path(&folder.path().join("calibration.toml"));
        let timestamp = |text: &str| text.parse::<Timestamp>().unwrap();
        let now = timestamp("2026-05-04T12:00:00Z");
        let require = |line: &str, now| EstopPress::require(&path, line, now, 24.0);
        assert!(matches!(require("a", now), Err(EstopPressError::Never)));
        let press = EstopPress::record(&path, "a".to_owned(), now).unwrap();
        assert_eq!(
            require("a", timestamp("2026-05-05T11:59:00Z")).unwrap(),
            press
        );
        let old = require("a", timestamp("2026-05-05T12:01:00Z"));
        assert!(matches!(old, Err(EstopPressError::TooOld { .. })));
        let other_line = require("b", now);
        assert!(matches!(other_line, Err(EstopPressError::OtherLine { .. })));
        let early = require("a", timestamp("2026-05-04T11:00:00Z"));
        assert!(matches!(early, Err(EstopPressError::Future { .. })));
        // The same line on another computer, and a record of a version that did not name the computer.
        for text in ["", "machine = \"0123456789abcdef\"\n"] {
            if text.is_empty() && machine::id().is_none() {
                continue;
            }
            let text = format!("pressed = \"{now}\"\nline = \"a\"\n{text}");
            std::fs::write(&path, text).unwrap();
            let other_computer = require("a", now);
            assert!(matches!(
                other_computer,
                Err(EstopPressError::OtherComputer)
            ));
        }
        std::fs::write(&path, "pressed = 1").unwrap();
        let damaged = require("a", now);
        assert!(matches!(damaged, Err(EstopPressError::Unreadable { .. })));
    }
}
