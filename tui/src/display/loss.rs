//! Loss of the participant's display.

/// Why the participant cannot see the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DisplayLoss {
    /// The terminal was closed.
    #[error("the terminal has gone")]
    Gone,
    /// The terminal no longer accepts output, for example after Ctrl-S.
    #[error("the terminal stands still (Ctrl-Q lets it go on)")]
    Stuck,
}
