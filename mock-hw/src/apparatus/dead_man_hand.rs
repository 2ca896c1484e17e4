//! Hand at the dead-man switch.

use std::sync::Arc;

use crate::pins::PinBoard;

/// Holds and releases the dead-man switch; any thread may hold a clone.
#[derive(Debug, Clone)]
pub struct DeadManHand(Arc<PinBoard>);

impl DeadManHand {
    pub(super) fn new(board: &Arc<PinBoard>) -> Self {
        Self(Arc::clone(board))
    }

    /// Holds the switch.
    pub fn hold(&self) {
        self.0.let_go_of_dead_man(false);
    }

    /// Releases the switch.
    pub fn let_go(&self) {
        self.0.let_go_of_dead_man(true);
    }
}
