//! What a bench shows and hears from its operator.

use tui::{Action, Event};

/// Takes events and gives the operator's wishes; neither ever waits.
pub trait Front: Send {
    /// Shows an event, or drops it when the screen stands still.
    fn show(&mut self, event: Event);
    /// The operator's next wish.
    fn action(&mut self) -> Option<Action>;

    /// Nobody reads any more what is shown.
    fn is_unread(&self) -> bool {
        false
    }
}
