//! Digital lines of the bench, on any pin that implements embedded-hal 1.0, simulated or real.

use embedded_hal::digital::{InputPin, OutputPin};

/// Failure to read or drive a line.
#[derive(Debug, thiserror::Error)]
pub enum GpioError {
    /// Failure of a pin of this computer.
    #[error(
        "GPIO line {line} can no longer be read or driven: its chip is gone, or its driver failed; look at the cable of the chip"
    )]
    Pin {
        /// Name of the line.
        line: &'static str,
    },
    /// Failure of the device that reads and drives the lines.
    #[error("{why}")]
    Device {
        /// State of the device, and the remedy.
        why: String,
    },
}

/// Input line of any backend.
pub trait InputLine: Send {
    /// Returns whether the line is high now.
    ///
    /// # Errors
    /// If the backend cannot read the line.
    fn is_high(&mut self) -> Result<bool, GpioError>;
}

/// Output line of any backend.
pub trait OutputLine: Send {
    /// Drives the line high or low.
    ///
    /// # Errors
    /// If the backend cannot drive the line.
    fn set(&mut self, high: bool) -> Result<(), GpioError>;
}

struct Named<P> {
    line: &'static str,
    pin: P,
}

impl<P: InputPin + Send> InputLine for Named<P> {
    fn is_high(&mut self) -> Result<bool, GpioError> {
        let level = self.pin.is_high();
        level.map_err(|_| GpioError::Pin { line: self.line })
    }
}

impl<P: OutputPin + Send> OutputLine for Named<P> {
    fn set(&mut self, high: bool) -> Result<(), GpioError> {
        let set = if high {
            self.pin.set_high()
        } else {
            self.pin.set_low()
        };
        set.map_err(|_| GpioError::Pin { line: self.line })
    }
}

/// Makes an embedded-hal input pin a line named `line`.
pub fn input(line: &'static str, pin: impl InputPin + Send + 'static) -> Box<dyn InputLine> {
    Box::new(Named { line, pin })
}

/// Makes an embedded-hal output pin a line named `line`.
pub fn output(line: &'static str, pin: impl OutputPin + Send + 'static) -> Box<dyn OutputLine> {
    Box::new(Named { line, pin })
}

/// Levels of the lines that the watch uses; `None` for a line that is not wired.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LineLevels {
    /// Whether the emergency stop's loop is open: pressed or cut.
    pub estop_open: Option<bool>,
    /// Time at which the loop was last seen open, ns.
    pub estop_open_ns: Option<u64>,
    /// Whether the heartbeat beats.
    pub beats: Option<bool>,
    /// Whether a line could not be read or driven when it was last tried.
    pub has_failed: bool,
}

/// Lines that only the watch uses; a line that is not wired is `None`.
#[derive(Default)]
pub struct SafetyLines {
    /// Emergency stop: a closed loop reads high, pressed or cut reads low.
    pub estop: Option<Box<dyn InputLine>>,
    /// Dead-man switch: held reads high, released or cut reads low.
    pub dead_man: Option<Box<dyn InputLine>>,
    /// Amplifier enable, high = on.
    pub enable: Option<Box<dyn OutputLine>>,
    /// Heartbeat into the amplifier's retriggerable one-shot.
    pub heartbeat: Option<Box<dyn OutputLine>>,
}
