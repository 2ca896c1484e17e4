//! The bench's digital lines, each by what it is wired to.

use safety::{Input, Output};

/// The lines of the bench; a line that is not wired is `None`.
#[derive(Default)]
pub struct Lines {
    /// Quadrature encoder, A and B.
    pub encoder: Option<[Box<dyn Input>; 2]>,
    /// Emergency stop: a closed loop reads high, pressed or cut reads low.
    pub estop: Option<Box<dyn Input>>,
    /// The participant's button, high while pressed.
    pub button: Option<Box<dyn Input>>,
    /// Amplifier enable, high = on.
    pub enable: Option<Box<dyn Output>>,
    /// Heartbeat into the amplifier's retriggerable one-shot.
    pub heartbeat: Option<Box<dyn Output>>,
}
