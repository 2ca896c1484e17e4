//! Interface between a bench and its operator: events to show, and the operator's actions.

use tui::{Action, Event};

/// A front end, which shows events and returns the operator's actions. Its methods never block.
pub trait Front: Send {
    /// Shows an event, or drops it while the screen is stalled.
    fn show(&mut self, event: Event);
    /// Returns the operator's next action, if any.
    fn action(&mut self) -> Option<Action>;

    /// Returns whether the reader of the output has gone.
    fn is_unread(&self) -> bool {
        false
    }
}
