//! The cables between the bench and the sound card's inputs.

use std::sync::{Arc, Mutex, PoisonError};

use crate::plant::Wiring;

/// Where the inputs' cables are plugged; any thread may hold a clone and replug them while the world runs.
#[derive(Debug, Clone, Default)]
pub struct Patchbay(Arc<Mutex<Wiring>>);

impl Patchbay {
    /// Plugs the cables; they stay so until plugged again. Takes effect with the next period.
    pub fn wire(&self, wiring: Wiring) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = wiring;
    }

    /// How they are plugged.
    #[must_use]
    pub fn wiring(&self) -> Wiring {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
