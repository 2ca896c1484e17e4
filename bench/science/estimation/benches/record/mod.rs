//! Model-generated rising stretch of an exploration, for the benchmarks.

use std::f64::consts::TAU;

use contact::{AssumedConstants, CalibrationErrors, Contact, harmonic};
use estimation::trial::{
    self, PlacedInstance, PlateReadings, PlateReference, TrialFit, TrialOptions,
};
use estimation::{FitConditions, InstanceSamples, InstanceSeries};
use num_complex::Complex64;

/// Carrier f0.
pub const CARRIER_HZ: f64 = 35_000.0;
/// The unloaded plate, N·s/m.
pub const Z_P: Complex64 = Complex64::new(7.01, 0.0);
/// The finger's tissues, N·s/m.
pub const Z_T: Complex64 = Complex64::new(0.47, 3.16);
const SIGMA_T_M: f64 = 1.7e-6;

/// Contact of a finger with σ_t = 1.7 µm.
pub fn contact() -> Contact {
    Contact::new(&AssumedConstants::default(), SIGMA_T_M).expect("physical constants")
}

/// Vibration amplitude modulated at 6 Hz with index 95 %, as in the published protocol.
pub fn amplitude_m(time_s: f64) -> f64 {
    1.95e-6 * (1.0 + 0.95 * (TAU * 6.0 * time_s).sin())
}

/// Normal force, N.
pub fn normal_n(time_s: f64) -> f64 {
    0.65 + 0.03 * (TAU * 1.3 * time_s).cos()
}

/// Steady-state samples of one rising stretch; a fit takes as long on them as on any other.
pub struct Record {
    time_s: Vec<f64>,
    pub z_m: Vec<Complex64>,
    pub amplitude_m: Vec<f64>,
    normal_n: Vec<f64>,
    mu: Vec<f64>,
    lead: usize,
}

impl Record {
    /// Returns 80 ms of samples; the last 60 ms are the instance.
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

    /// Instances of a trial at 2 kHz: the skin differs from the assumed one, the plate drifts, and the lag is 0.9 ms.
    pub fn trial(instances: usize) -> Vec<Self> {
        (0..instances)
            .map(|k| Self::trial_instance(k as f64))
            .collect()
    }

    fn trial_instance(k: f64) -> Self {
        let (rate_hz, lead, tau_s, substeps) = (2000.0, 40, 0.9e-3, 32);
        let skin = AssumedConstants {
            contact_area_m2: 240e-6,
            q0_rad_per_m: 1.9e4,
            loss_factor: 0.36,
            ..AssumedConstants::default()
        };
        let contact =
            Contact::new(&skin, SIGMA_T_M * (1.0 + 0.01 * k)).expect("physical constants");
        let z_t = Complex64::new(Z_T.re, Z_T.im * (1.0 + 0.01 * k));
        let z_p = Z_P - Complex64::I * (0.02 * k);
        let force_n = |t: f64| normal_n(t) * (0.9 + 0.015 * k);
        let steady_m = |t: f64| {
            let (a, n) = (amplitude_m(t), force_n(t));
            contact.equilibrium_gap_m(a, n).expect("physical record")
        };
        let step_s = 1.0 / rate_hz / f64::from(substeps);
        let share = 1.0 - (-step_s / tau_s).exp();
        let mut record = Self {
            time_s: (0..160).map(|i| f64::from(i) / rate_hz - 0.05).collect(),
            z_m: Vec::new(),
            amplitude_m: Vec::new(),
            normal_n: Vec::new(),
            mu: Vec::new(),
            lead,
        };
        let begin_s = record.time_s[0] - 0.02;
        let mut gap_m = steady_m(begin_s);
        let mut step = 0;
        for (i, &t) in record.time_s.clone().iter().enumerate() {
            loop {
                let middle_s = begin_s + (f64::from(step) + 0.5) * step_s;
                if middle_s > t {
                    break;
                }
                gap_m += (steady_m(middle_s) - gap_m) * share;
                step += 1;
            }
            let (a, n) = (amplitude_m(t), force_n(t));
            let k_c = contact.stiffness_n_per_m(gap_m, a);
            let z_c = contact.impedance_n_s_per_m(k_c, TAU * CARRIER_HZ);
            let ripple = Complex64::from_polar(0.001, i as f64);
            record.z_m.push(harmonic::observed(z_p, z_t, z_c) + ripple);
            record.amplitude_m.push(a);
            record.normal_n.push(n);
            record.mu.push(0.8 * contact.friction_ratio(gap_m, n));
        }
        record
    }

    /// Returns the samples as the fits read them.
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

/// Fits instances of one trial together: by the published laws, and with the laws in doubt.
pub fn fit_trial(records: &[Record]) -> TrialFit {
    let places: Vec<PlacedInstance<'_>> = records
        .iter()
        .map(|record| PlacedInstance {
            series: record.series(),
            off_centre_m: 0.0,
        })
        .collect();
    // The plate as read before and after the finger, which shifted its resonance by 3 Hz.
    let references = [(-100.0, 0.0), (100.0, -0.28)].map(|(time_s, reactance)| PlateReference {
        time_s,
        z_p_n_s_per_m: Z_P + Complex64::I * reactance,
        std_n_s_per_m: 1e-3,
    });
    let readings = PlateReadings {
        references: references.to_vec(),
        touches_s: vec![(-99.0, 99.0)],
    };
    let options = TrialOptions::default();
    let fit = trial::fit(&places, &conditions(), &readings, &options)
        .expect("instances that the model allows");
    assert!(
        fit.shared.verdict.is_usable() && fit.within_laws.is_some(),
        "both fits are measured: {}",
        fit.shared.verdict
    );
    fit
}

/// Returns the known conditions of the fits.
pub fn conditions() -> FitConditions {
    FitConditions {
        assumed: AssumedConstants::default(),
        carrier_hz: CARRIER_HZ,
        z_p_plain_n_s_per_m: Z_P,
        z_p_corrected_n_s_per_m: Z_P,
        calibration: CalibrationErrors::default(),
        assumed_errors: CalibrationErrors::default(),
        mode_across: None,
    }
}
