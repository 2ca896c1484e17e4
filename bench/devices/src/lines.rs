//! The bench's digital lines, each by what it is wired to.

use safety::{InputLine, OutputLine};

/// The lines of the bench; a line that is not wired is `None`.
#[derive(Default)]
pub struct Lines {
    /// Quadrature encoder, A and B.
    pub encoder: Option<[Box<dyn InputLine>; 2]>,
    /// Emergency stop: a closed loop reads high, pressed or cut reads low.
    pub estop: Option<Box<dyn InputLine>>,
    /// The participant's button, high while pressed.
    pub button: Option<Box<dyn InputLine>>,
    /// Amplifier enable, high = on.
    pub enable: Option<Box<dyn OutputLine>>,
    /// Heartbeat into the amplifier's retriggerable one-shot.
    pub heartbeat: Option<Box<dyn OutputLine>>,
}
