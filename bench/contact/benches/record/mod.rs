//! A rising stretch of an exploration as the model has it, for the benchmarks.

use std::f64::consts::TAU;

use contact::fit::{FitConditions, InstanceSamples, InstanceSeries};
use contact::{AssumedConstants, Contact, harmonic};
use num_complex::Complex64;

/// Carrier f0.
pub const CARRIER_HZ: f64 = 35_000.0;
/// The unloaded plate, N·s/m.
pub const Z_P: Complex64 = Complex64::new(7.01, 0.0);
/// The finger's tissues, N·s/m.
pub const Z_T: Complex64 = Complex64::new(0.47, 3.16);
const SIGMA_T_M: f64 = 1.7e-6;

/// A finger of σ_t = 1.7 µm.
pub fn contact() -> Contact {
    Contact::new(&AssumedConstants::default(), SIGMA_T_M).expect("physical constants")
}

/// 6 Hz at 95 %, as the published protocol drives the plate.
pub fn amplitude_m(time_s: f64) -> f64 {
    1.95e-6 * (1.0 + 0.95 * (TAU * 6.0 * time_s).sin())
}

/// What the finger presses with.
pub fn normal_n(time_s: f64) -> f64 {
    0.65 + 0.03 * (TAU * 1.3 * time_s).cos()
}

/// Steady-state samples of one rising stretch; the fits take as long on them as on any.
pub struct Record {
    time_s: Vec<f64>,
    pub z_m: Vec<Complex64>,
    pub amplitude_m: Vec<f64>,
    normal_n: Vec<f64>,
    mu: Vec<f64>,
    lead: usize,
}

impl Record {
    /// 80 ms of which the last 60 are the instance.
    pub fn at_rate(rate_hz: f64) -> Self {
        let contact = contact();
        let lead = (0.02 * rate_hz) as usize;
        let time_s: Vec<f64> = (0..lead + (0.06 * rate_hz) as usize)
            .map(|i| i as f64 / rate_hz - 0.05)
            .collect();
        let amplitude_m: Vec<f64> = time_s.iter().map(|&t| amplitude_m(t)).collect();
        let normal_n: Vec<f64> = time_s.iter().map(|&t| normal_n(t)).collect();
        let mut gap_m = vec![0.0; time_s.len()];
        contact
            .equilibrium_gaps_m(&amplitude_m, &normal_n, &mut gap_m)
            .expect("physical record");
        let z_m = gap_m
            .iter()
            .zip(&amplitude_m)
            .enumerate()
            .map(|(i, (&gap, &a))| {
                let z_c = contact
                    .impedance_n_s_per_m(contact.stiffness_n_per_m(gap, a), TAU * CARRIER_HZ);
                let ripple = Complex64::from_polar(0.01, i as f64);
                harmonic::observed(Z_P, Z_T, z_c) + ripple
            })
            .collect();
        let mu = gap_m
            .iter()
            .zip(&normal_n)
            .map(|(&gap, &n)| 0.8 * contact.friction_ratio(gap, n))
            .collect();
        Self {
            time_s,
            z_m,
            amplitude_m,
            normal_n,
            mu,
            lead,
        }
    }

    /// As the fits read it.
    pub fn series(&self) -> InstanceSeries<'_> {
        let samples = InstanceSamples {
            time_s: &self.time_s,
            z_m_plain_n_s_per_m: &self.z_m,
            z_m_corrected_n_s_per_m: &self.z_m,
            amplitude_m: &self.amplitude_m,
            normal_n: &self.normal_n,
            mu: &self.mu,
        };
        InstanceSeries::new(samples, self.lead).expect("valid record")
    }
}

/// What the fits take as known.
pub fn conditions() -> FitConditions {
    FitConditions {
        assumed: AssumedConstants::default(),
        carrier_hz: CARRIER_HZ,
        z_p_plain_n_s_per_m: Z_P,
        z_p_corrected_n_s_per_m: Z_P,
    }
}
