//! What the keys that stop do by themselves.

use safety::{DriveStop, Trip};
use tasks::StopFlag;
use tui::Action;

/// Effects of the keys that stop, on the thread that reads them: the drive is silent before the task that decides about
/// it has heard of the key, and although it may never hear.
///
/// ```
/// use console::StopKeys;
/// use tasks::StopFlag;
/// use tui::Action;
///
/// let stop = StopFlag::default();
/// let keys = StopKeys::new(safety::DriveStop::default()).ending(stop.clone());
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
    /// Makes the keys that stop `drive`.
    #[must_use]
    pub fn new(drive: DriveStop) -> Self {
        Self { drive, ends: None }
    }

    /// Lets the keys that quit raise `stop` as well. A drill goes without: there, quitting may be the right answer.
    #[must_use]
    pub fn ending(self, stop: StopFlag) -> Self {
        Self {
            ends: Some(stop),
            ..self
        }
    }

    /// Shows the safety watch that keys are read.
    pub fn hear(&self) {
        self.drive.hear();
    }

    /// Does at once what `action` must not wait for.
    pub fn act(&self, action: &Action) {
        match action {
            Action::EmergencyStop => self.drive.trip(Trip::Operator),
            Action::Quit | Action::Interrupt => {
                let again = self.ends.as_ref().is_some_and(StopFlag::is_raised);
                if let Some(stop) = &self.ends {
                    // First: the watch of a bench that ends looks for no reason of the kill.
                    stop.raise();
                }
                self.drive.kill();
                if again && *action == Action::Interrupt {
                    interrupt();
                }
            }
            _ => {}
        }
    }
}

/// Ends a program that was asked to end before and waits for something that hangs.
fn interrupt() {
    #[cfg(unix)]
    let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::INT);
}
