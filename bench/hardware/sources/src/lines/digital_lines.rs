//! Digital lines of a bench, from any device.

use safety::{InputLine, OutputLine};

use crate::position::PositionSource;

/// Digital lines of a bench; a line that is not wired is `None`.
#[derive(Default)]
pub struct Lines {
    /// Signals A and B of the quadrature encoder.
    pub encoder: Option<[Box<dyn InputLine>; 2]>,
    /// Encoder counter of the device that provides the lines.
    pub counter: Option<Box<dyn PositionSource>>,
    /// Loop of the emergency stop: closed reads high, pressed or cut reads low.
    pub estop: Option<Box<dyn InputLine>>,
    /// The participant's button, high while pressed.
    pub button: Option<Box<dyn InputLine>>,
    /// The dead-man switch: held reads high, released or cut reads low.
    pub dead_man: Option<Box<dyn InputLine>>,
    /// Enable input of the amplifier, high for on.
    pub enable: Option<Box<dyn OutputLine>>,
    /// Heartbeat into the amplifier's retriggerable one-shot.
    pub heartbeat: Option<Box<dyn OutputLine>>,
}
