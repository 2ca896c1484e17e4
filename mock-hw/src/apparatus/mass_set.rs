//! Known masses that any thread can place on the sensor.

use std::sync::{Arc, Mutex, PoisonError};

use mock_world::plant::{LoadedAxis, Plant};

/// A requested change of the masses.
#[derive(Debug, Clone, Copy)]
enum Placement {
    Place(LoadedAxis, f64),
    Remove,
}

/// Handle that places known masses; any thread may hold a clone. A placement takes effect with the next period.
#[derive(Debug, Clone, Default)]
pub struct MassSet(Arc<Mutex<Vec<Placement>>>);

impl MassSet {
    /// Puts the mass marked `mass_kg` on the plate or over the pulley, replacing the present one.
    pub fn place(&self, axis: LoadedAxis, mass_kg: f64) {
        self.ask(Placement::Place(axis, mass_kg));
    }

    /// Removes all masses.
    pub fn remove(&self) {
        self.ask(Placement::Remove);
    }

    fn ask(&self, placement: Placement) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(placement);
    }

    /// Applies the placements requested since the last call to the plant.
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
