//! Constants as a bench states them.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2};

use crate::scenario::Scenario;

/// Constants that convert the samples of a bench; frequencies and delays are by the converter's clock.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedConstants {
    /// Actuator volts per sample value of the drive's read-back.
    pub drive_volts_per_unit: f64,
    /// Plate displacement per sample value of the pickup, m.
    pub metres_per_unit: f64,
    /// Delay of the pickup behind the drive's read-back, s: its phase is that of the carrier, x̃ = metres_per_unit · sample ·
    /// exp(+iω·delay).
    pub pickup_delay_s: f64,
    /// Resonance of the carrier mode, Hz.
    pub resonance_hz: f64,
    /// Modal mass m_p, kg.
    pub modal_mass_kg: f64,
    /// Force factor γ, N/V.
    pub force_factor_n_per_v: f64,
    /// Middle of the plate on the scale of the positions, m.
    pub centre_m: f64,
    /// Inverse of the force sensor's response.
    force_matrix: Matrix2<f64>,
    /// Readings without load, N.
    force_zero_n: Vector2<f64>,
}

impl StatedConstants {
    /// Returns the true constants of the bench of a drawn scenario at a sampling rate.
    #[must_use]
    pub fn new(scenario: &Scenario, rate_hz: f64) -> Self {
        let (plate, converter, force) =
            (&scenario.plate, &scenario.converter, &scenario.force_sensor);
        let clock = 1.0 + 1e-6 * converter.clock_ppm;
        let [normal, lateral] = force.response();
        let response = Matrix2::new(normal[0], normal[1], lateral[0], lateral[1]);
        Self {
            drive_volts_per_unit: converter.readback_volts_per_unit / converter.gain(0),
            metres_per_unit: scenario.pickup.metres_per_unit / converter.gain(1),
            pickup_delay_s: scenario.pickup.phase_rad / plate.omega_rad_per_s() * clock
                + (converter.skew(0) - converter.skew(1)) / rate_hz,
            resonance_hz: plate.resonance_hz / clock,
            modal_mass_kg: plate.modal_mass_kg,
            force_factor_n_per_v: plate.force_factor_n_per_v,
            centre_m: 0.5 * plate.length_m,
            force_matrix: response.try_inverse().unwrap_or_else(Matrix2::identity),
            force_zero_n: Vector2::new(force.normal_offset_n, force.lateral_offset_n),
        }
    }

    /// Returns the phase of the displacement relative to the pickup's sample values at a carrier, rad.
    #[must_use]
    pub fn phase_rad(&self, carrier_hz: f64) -> f64 {
        TAU * carrier_hz * self.pickup_delay_s
    }

    /// Returns normal and lateral force of a reading, N.
    pub(super) fn forces_n(&self, reading_n: [f64; 2]) -> [f64; 2] {
        (self.force_matrix * (Vector2::from(reading_n) - self.force_zero_n)).into()
    }
}
