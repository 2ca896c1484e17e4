//! The set of known masses, to be placed on the sensor from any thread.

use std::sync::{Arc, Mutex, PoisonError};

use mock_world::plant::{Axis, Plant};

/// A change of the masses that was asked for.
#[derive(Debug, Clone, Copy)]
enum Placement {
    Place(Axis, f64),
    Remove,
}

/// Handle that places known masses; any thread may hold a clone. A placement takes effect with the next period.
#[derive(Debug, Clone, Default)]
pub struct MassSet(Arc<Mutex<Vec<Placement>>>);

impl MassSet {
    /// Puts the mass that is marked `mass_kg` on the plate or over the pulley, in place of what is there.
    pub fn place(&self, axis: Axis, mass_kg: f64) {
        self.ask(Placement::Place(axis, mass_kg));
    }

    /// Takes all masses away.
    pub fn remove(&self) {
        self.ask(Placement::Remove);
    }

    fn ask(&self, placement: Placement) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(placement);
    }

    /// Passes the placements asked for since the last call on to the plant.
    pub(super) fn carry_out(&self, plant: &mut Plant) {
        let mut placements = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for placement in placements.drain(..) {
            match placement {
                Placement::Place(axis, mass_kg) => plant.place_mass(axis, mass_kg),
                Placement::Remove => plant.remove_masses(),
            }
        }
    }
}
