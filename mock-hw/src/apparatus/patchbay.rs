//! The cables to the sound card's inputs, to be connected from any thread.

use std::sync::{Arc, Mutex, PoisonError};

use mock_world::plant::InputWiring;

/// Handle that connects the cables of the inputs; any thread may hold a clone and reconnect them during a run.
#[derive(Debug, Clone, Default)]
pub struct Patchbay(Arc<Mutex<InputWiring>>);

impl Patchbay {
    /// Connects the cables from the next period on.
    pub fn wire(&self, wiring: InputWiring) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = wiring;
    }

    /// Returns how the cables are connected.
    #[must_use]
    pub fn wiring(&self) -> InputWiring {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
