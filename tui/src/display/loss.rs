//! Why the participant does not see what is drawn.

/// Why the participant does not see what is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DisplayLoss {
    /// The terminal has gone.
    #[error("the terminal has gone")]
    Gone,
    /// The terminal takes nothing any more, for example after Ctrl-S.
    #[error("the terminal stands still (Ctrl-Q lets it go on)")]
    Stuck,
}
