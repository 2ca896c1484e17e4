//! Interface between the watch and the drive.

use crate::trip::Trip;

/// Envelope that the drive was last commanded to render.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Commanded {
    /// Number of the latest rendered frame.
    pub frame: u64,
    /// Envelope at that frame, V peak.
    pub envelope_v: f64,
}

/// Interface of the drive to the watch: its kill switch and its state.
pub trait DriveGuard: Send {
    /// Shows the drive that it is watched: it stops if this call is missing for a while.
    fn attend(&self);
    /// Ramps the drive to zero at once and latches it, until its owner releases it after a new arming.
    fn kill(&self);
    /// Returns the number of kills of the drive, by the watch or by other parts.
    fn kills(&self) -> u64;
    /// Returns the commanded envelope; `None` once the generator has refused its own output as impossible.
    fn commanded(&self) -> Option<Commanded>;
    /// Returns the number of audio callbacks so far, (output, input).
    fn callbacks(&self) -> (u64, u64);
    /// Returns the reason for the loss of the sound card; `None` while it is present.
    fn lost(&self) -> Option<Trip>;
}
