//! The drive as the watch sees it.

/// What the drive was last told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Commanded {
    /// The latest rendered frame.
    pub frame: u64,
    /// Envelope there, V peak.
    pub envelope_v: f64,
}

/// The drive, as far as safety is concerned.
pub trait DriveGuard: Send {
    /// Ramps the drive to zero at once and latches it, until its owner releases it after a new arming.
    fn kill(&self);
    /// How often it was killed, by anybody.
    fn kills(&self) -> u64;
    /// What is commanded; `None` once the generator refused its own output.
    fn commanded(&self) -> Option<Commanded>;
    /// Callbacks of the card so far, (output, input).
    fn callbacks(&self) -> (u64, u64);
    /// The card was lost.
    fn lost(&self) -> bool;
}
