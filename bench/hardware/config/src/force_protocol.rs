//! Formats of a force sensor's serial line (`docs/force-protocol.md`).

use serde::{Deserialize, Serialize};

/// Format in which the force sensor sends its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ForceProtocol {
    /// Binary frames with COBS, CRC-16 and a sequence number.
    Frames,
    /// Lines of text, one for each sample.
    Lines,
}
