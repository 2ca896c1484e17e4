//! Thoroughness of a preflight.

use std::path::PathBuf;

use jiff::Timestamp;

/// Thoroughness of a preflight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// Half a second, for the loop delay alone.
    Delay,
    /// A little over a second, for the hardware stops alone.
    Stops,
    /// Two seconds, before the plate is driven.
    Quick,
    /// Ten seconds, to detect drop-outs and check the computer's resources for a session.
    Whole {
        /// Folder of the study, which need not exist yet.
        study: PathBuf,
        /// Largest size of a session, bytes.
        session_bytes: u64,
        /// Whether the session's dashboard will be shown on this terminal.
        dashboard: bool,
        /// Present time by the computer's clock.
        now: Timestamp,
    },
}
