//! Loss of the participant's display.

/// Why the participant cannot see the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DisplayLoss {
    /// The terminal was closed.
    #[error("the terminal is gone")]
    Gone,
    /// The terminal no longer accepts output, for example after Ctrl-S.
    #[error("the terminal is stopped (Ctrl-Q resumes it)")]
    Stuck,
}
