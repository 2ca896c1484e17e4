//! What a bench shows its operator, and what it is asked to do.

use tui::{Action, Event};

/// A front end: takes events and returns the operator's actions. Neither ever blocks.
pub trait Front: Send {
    /// Shows an event; drops it when the screen stands still.
    fn show(&mut self, event: Event);
    /// Returns the operator's next action; `None` when there is none.
    fn action(&mut self) -> Option<Action>;

    /// Returns whether the reader of what is shown has gone.
    fn is_unread(&self) -> bool {
        false
    }
}
