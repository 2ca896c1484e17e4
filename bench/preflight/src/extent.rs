//! How thorough a preflight is.

use std::path::PathBuf;

/// How much is looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// Half a second, for the loop's delay alone.
    Delay,
    /// A little over a second, for the hardware stops alone.
    Stops,
    /// Two seconds, before the plate is driven.
    Quick,
    /// Ten seconds for drop-outs, and what the computer has for a session.
    Whole {
        /// Where the study lies, or will.
        study: PathBuf,
        /// What a session may take there, bytes.
        session_bytes: u64,
        /// Whether the session's dashboard will be shown on this terminal.
        dashboard: bool,
    },
}
