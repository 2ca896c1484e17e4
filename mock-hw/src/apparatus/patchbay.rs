//! Cables to the sound card's inputs, which any thread can reconnect.

use std::sync::{Arc, Mutex, PoisonError};

use mock_world::plant::InputWiring;

/// Handle that connects the cables of the inputs; any thread may hold a clone, also during a run.
#[derive(Debug, Clone, Default)]
pub struct Patchbay(Arc<Mutex<InputWiring>>);

impl Patchbay {
    /// Connects the cables; takes effect at the next period.
    pub fn wire(&self, wiring: InputWiring) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = wiring;
    }

    /// Returns the connections of the cables.
    #[must_use]
    pub fn wiring(&self) -> InputWiring {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
