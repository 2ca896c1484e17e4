//! Known masses on the plate and over the pulley, and their settling.

use std::f64::consts::TAU;

use rand_distr::{Distribution, StandardNormal};

use super::force_sensor::Forces;
use crate::scenario::MassesTable;
use crate::seed;

/// Axis of the force sensor that a known mass loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadedAxis {
    /// The normal axis: the mass lies on the plate.
    Normal,
    /// The lateral axis: the mass hangs over the pulley and pulls towards increasing position. A negative mass hangs over a
    /// pulley at the other end and pulls in the opposite direction.
    Lateral,
}

/// A weight that settles after a change.
#[derive(Debug, Clone, Copy, Default)]
struct Settling {
    from_n: f64,
    to_n: f64,
    since_s: f64,
}

impl Settling {
    /// Returns the weight at `time_s` for oscillations of frequency `hz` and decay time `decay_s`, N.
    fn force_at(&self, time_s: f64, hz: f64, decay_s: f64) -> f64 {
        let t = (time_s - self.since_s).max(0.0);
        self.to_n + (self.from_n - self.to_n) * (-t / decay_s).exp() * (TAU * hz * t).cos()
    }
}

/// The known masses on the plate and over the pulley.
#[derive(Debug, Clone)]
pub(crate) struct KnownMasses {
    scenario: MassesTable,
    seed: u64,
    on_plate: Settling,
    on_pulley: Settling,
}

impl KnownMasses {
    pub fn new(scenario: &MassesTable, seed: u64) -> Self {
        Self {
            scenario: scenario.clone(),
            seed,
            on_plate: Settling::default(),
            on_pulley: Settling::default(),
        }
    }

    /// Places the mass marked `mass_kg`, replacing the present one on that axis.
    pub fn place(&mut self, axis: LoadedAxis, mass_kg: f64, time_s: f64) {
        let weight_n = self.true_mass_kg(mass_kg) * self.scenario.gravity_m_per_s2;
        let (on_plate_n, on_pulley_n) = self.weights_n(time_s);
        let (slot, from_n) = match axis {
            LoadedAxis::Normal => (&mut self.on_plate, on_plate_n),
            LoadedAxis::Lateral => (&mut self.on_pulley, on_pulley_n),
        };
        *slot = Settling {
            from_n,
            to_n: weight_n,
            since_s: time_s,
        };
    }

    /// Removes all masses.
    pub fn remove(&mut self, time_s: f64) {
        for axis in [LoadedAxis::Normal, LoadedAxis::Lateral] {
            self.place(axis, 0.0, time_s);
        }
    }

    /// Returns the normal and lateral force of the masses on the sensor at `time_s`, N.
    pub fn forces(&self, time_s: f64) -> Forces {
        let (weight_n, hanging_n) = self.weights_n(time_s);
        let pull_n = hanging_n * (1.0 - self.scenario.pulley_friction);
        let (sin, cos) = self.scenario.tilt_rad.sin_cos();
        [weight_n * cos - pull_n * sin, weight_n * sin + pull_n * cos]
    }

    /// Returns the weight on the plate and that over the pulley at `time_s`, N.
    fn weights_n(&self, time_s: f64) -> (f64, f64) {
        let s = &self.scenario;
        (
            self.on_plate.force_at(time_s, s.bounce_hz, s.bounce_time_s),
            self.on_pulley.force_at(time_s, s.swing_hz, s.swing_time_s),
        )
    }

    /// Returns the true mass of the one marked `marked_kg`, kg; the same mark always gives the same mass.
    fn true_mass_kg(&self, marked_kg: f64) -> f64 {
        let milligrams = (1e6 * marked_kg.abs()).round() as u64;
        let mut rng = seed::stream(
            self.seed ^ milligrams.rotate_left(32),
            seed::RandomStream::Masses,
        );
        let white: f64 = StandardNormal.sample(&mut rng);
        marked_kg * (1.0 + self.scenario.error * white)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact() -> MassesTable {
        MassesTable {
            error: 0.0,
            ..MassesTable::default()
        }
    }

    #[test]
    fn a_mass_bounces_and_comes_to_rest_at_its_weight() {
        let mut masses = KnownMasses::new(&exact(), 1);
        masses.place(LoadedAxis::Normal, 0.1, 2.0);
        assert_eq!(masses.forces(2.0), [0.0, 0.0]);
        let peak_n = (0..200)
            .map(|i| masses.forces(2.0 + 1e-3 * f64::from(i))[0])
            .fold(0.0, f64::max);
        assert!(peak_n > 1.2 * 0.980_665, "{peak_n} N at its hardest");
        let [normal_n, lateral_n] = masses.forces(4.0);
        assert!((normal_n - 0.980_665).abs() < 1e-9 && lateral_n == 0.0);
        masses.remove(4.0);
        assert!(masses.forces(4.01)[0] > 0.0);
        assert!(masses.forces(6.0)[0].abs() < 1e-9);
    }

    #[test]
    fn tilt_turns_weight_into_pull_and_the_pulley_keeps_its_share() {
        let scenario = MassesTable {
            tilt_rad: 0.02,
            pulley_friction: 0.1,
            ..exact()
        };
        let mut masses = KnownMasses::new(&scenario, 1);
        masses.place(LoadedAxis::Normal, 0.1, 0.0);
        let [normal_n, lateral_n] = masses.forces(10.0);
        assert!((lateral_n / normal_n - 0.02f64.tan()).abs() < 1e-12);
        masses.remove(10.0);
        masses.place(LoadedAxis::Lateral, 0.1, 10.0);
        let [normal_n, lateral_n] = masses.forces(30.0);
        assert!((normal_n / lateral_n + 0.02f64.tan()).abs() < 1e-12);
        assert!((lateral_n.hypot(normal_n) - 0.9 * 0.980_665).abs() < 1e-12);
    }

    #[test]
    fn a_mark_names_one_mass() {
        let masses = KnownMasses::new(&MassesTable::default(), 5);
        let relative_error = |kg: f64| masses.true_mass_kg(kg) / kg - 1.0;
        assert_eq!(relative_error(0.05), relative_error(0.05));
        assert_ne!(relative_error(0.05), relative_error(0.1));
        assert!(relative_error(0.05).abs() < 3e-4);
    }
}
