//! Times that the hardware stops took when they were exercised.

use serde::Serialize;

/// A line that stops the amplifier without the computer's consent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StopLine {
    /// The heartbeat, through the one-shot.
    Heartbeat,
    /// The amplifier's enable line.
    Enable,
}

/// Times of a stop, as the read-back shows them, including the delays of the loop and of the demodulation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StopTimes {
    /// The line.
    pub line: StopLine,
    /// Time from the line to the silent read-back, s; `None` if it did not fall within 0.3 s.
    pub off_s: Option<f64>,
    /// Time from the line's return to the tone's, s; `None` if it did not come back within 0.3 s.
    pub back_s: Option<f64>,
}
