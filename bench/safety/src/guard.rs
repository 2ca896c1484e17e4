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

/// What the watch needs of the drive: its kill switch and its state.
pub trait DriveGuard: Send {
    /// Shows the drive that it is watched: one that is not shown this for a while stops by itself.
    fn attend(&self);
    /// Ramps the drive to zero at once and latches it, until its owner releases it after a new arming.
    fn kill(&self);
    /// Returns how often the drive was killed, by the watch or by others.
    fn kills(&self) -> u64;
    /// Returns the commanded envelope; `None` once the generator has refused its own output as impossible.
    fn commanded(&self) -> Option<Commanded>;
    /// Returns the audio callbacks so far, (output, input).
    fn callbacks(&self) -> (u64, u64);
    /// Returns how the sound card was lost; `None` while it is there.
    fn lost(&self) -> Option<Trip>;
}
