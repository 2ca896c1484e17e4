//! The formats that a force sensor's serial line may speak.

use serde::{Deserialize, Serialize};

/// Which of the two formats the sensor speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ForceProtocol {
    /// Binary, COBS and CRC-16, with a sequence number.
    Frames,
    /// Text, one line a sample.
    Lines,
}
