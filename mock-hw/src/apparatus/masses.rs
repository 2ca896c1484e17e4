//! The set of known masses, and the hand that places them.

use std::sync::{Arc, Mutex, PoisonError};

use crate::plant::{Axis, Plant};

#[derive(Debug, Clone, Copy)]
enum Errand {
    Place(Axis, f64),
    Remove,
}

/// Places known masses; any thread may hold a clone. Each errand is done with the next period.
#[derive(Debug, Clone, Default)]
pub struct Masses(Arc<Mutex<Vec<Errand>>>);

impl Masses {
    /// Puts the mass that is marked `mass_kg` on the plate or over the pulley, in place of what is there.
    pub fn place(&self, axis: Axis, mass_kg: f64) {
        self.ask(Errand::Place(axis, mass_kg));
    }

    /// Takes all masses away.
    pub fn remove(&self) {
        self.ask(Errand::Remove);
    }

    fn ask(&self, errand: Errand) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(errand);
    }

    pub(super) fn do_errands(&self, plant: &mut Plant) {
        let mut errands = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for errand in errands.drain(..) {
            match errand {
                Errand::Place(axis, mass_kg) => plant.place_mass(axis, mass_kg),
                Errand::Remove => plant.remove_masses(),
            }
        }
    }
}
