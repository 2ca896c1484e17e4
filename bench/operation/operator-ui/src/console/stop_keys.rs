//! Immediate effects of the keys that stop the drive.

use safety::{DriveStop, Trip};
use tasks::StopFlag;
use tui::Action;

/// Effects of the keys that stop the drive, on the thread that reads the keys: the drive is silenced before the task that
/// controls it receives the action, and even if that task hangs.
///
/// ```
/// use operator_ui::console::StopKeys;
/// use tasks::StopFlag;
/// use tui::Action;
///
/// let stop = StopFlag::default();
/// let keys = StopKeys::new(safety::DriveStop::default()).with_end(stop.clone());
/// keys.act(&Action::Pause);
/// keys.act(&Action::EmergencyStop);
/// assert!(!stop.is_raised());
/// keys.act(&Action::Quit);
/// assert!(stop.is_raised());
/// ```
#[derive(Clone, Default)]
pub struct StopKeys {
    drive: DriveStop,
    ends: Option<StopFlag>,
}

impl StopKeys {
    /// Creates the keys that stop `drive`.
    #[must_use]
    pub fn new(drive: DriveStop) -> Self {
        Self { drive, ends: None }
    }

    /// Makes the keys that quit raise `stop` as well. A drill omits this, because quitting may be the right response there.
    #[must_use]
    pub fn with_end(self, stop: StopFlag) -> Self {
        Self {
            ends: Some(stop),
            ..self
        }
    }

    /// Shows the safety watch that keys are being read.
    pub fn hear(&self) {
        self.drive.hear();
    }

    /// Carries out the part of `action` that must not wait.
    pub fn act(&self, action: &Action) {
        match action {
            Action::EmergencyStop => self.drive.trip(Trip::Operator),
            Action::Quit | Action::Interrupt => {
                let is_repeated = self.ends.as_ref().is_some_and(StopFlag::is_raised);
                if let Some(stop) = &self.ends {
                    // Raised first, so that the watch of a bench that is ending does not report the kill as a fault.
                    stop.raise();
                }
                self.drive.kill();
                if is_repeated && *action == Action::Interrupt {
                    interrupt();
                }
            }
            _ => {}
        }
    }
}

/// Interrupts a program that hangs after an earlier request to end.
fn interrupt() {
    #[cfg(unix)]
    let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::INT);
}
