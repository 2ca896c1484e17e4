//! Lateral force of a sliding finger: friction coefficient, presliding and ageing.

use super::exposure::Exposure;
use crate::fingertip::Pad;
use crate::scenario::FrictionTable;

/// Reference speed of a person's μ0, m/s.
const REFERENCE_M_PER_S: f64 = 0.05;
/// Speed below which friction no longer depends on it, m/s.
const LEAST_M_PER_S: f64 = 1e-3;

/// Friction of one finger.
#[derive(Debug, Clone)]
pub(super) struct Friction {
    friction: FrictionTable,
    presliding_m: f64,
    bristle_m: f64,
    age: Exposure,
}

impl Friction {
    pub fn new(friction: &FrictionTable, presliding_m: f64, pad: &Pad) -> Self {
        Self {
            friction: friction.clone(),
            presliding_m,
            bristle_m: 0.0,
            age: Exposure::new(pad.ageing_time_s),
        }
    }

    /// Advances by `dt_s` with the finger off the plate.
    pub fn lift(&mut self, dt_s: f64) {
        self.bristle_m = 0.0;
        self.age.advance(dt_s, false);
    }

    /// Advances by `dt_s` with the finger on the plate; returns the factor of μ0 from age, speed and load.
    pub fn factor(&mut self, dt_s: f64, pad: &Pad, normal_n: f64, velocity_m_per_s: f64) -> f64 {
        let mut factor = 1.0 + pad.ageing * self.age.advance(dt_s, true);
        if pad.speed_exponent != 0.0 {
            let speed = velocity_m_per_s.abs().max(LEAST_M_PER_S) / REFERENCE_M_PER_S;
            factor *= speed.powf(pad.speed_exponent);
        }
        if self.friction.load_exponent != 0.0 {
            factor *= normal_n.powf(self.friction.load_exponent);
        }
        factor
    }

    /// Advances by `dt_s` of sliding; returns the lateral force, N, for the coefficient of full sliding.
    pub fn lateral_n(&mut self, dt_s: f64, mu: f64, normal_n: f64, velocity_m_per_s: f64) -> f64 {
        let viscous_n = self.friction.viscous_n_s_per_m * velocity_m_per_s;
        mu * normal_n * self.slide(velocity_m_per_s * dt_s) + viscous_n
    }

    /// Returns the fraction of full friction, −1 to 1, which builds up over the presliding distance (Dahl's model).
    fn slide(&mut self, travel_m: f64) -> f64 {
        let reach = self.presliding_m;
        let full = reach * travel_m.signum();
        self.bristle_m = full + (self.bristle_m - full) * (-travel_m.abs() / reach).exp();
        self.bristle_m / reach
    }
}

/// Returns friction relative to rest if asperities carry the fraction `carried` of the load.
pub(super) fn relative_friction(pad: &Pad, carried: f64) -> f64 {
    pad.floor + (1.0 - pad.floor) * carried
}
