//! The standard errors of the estimates cover the effect of wrong calibration constants.

use contact::CalibrationErrors;
use estimation::dynamic::{self, DynamicOptions};
use estimation::trial::{self, PlateReadings, TrialFit, TrialOptions};
use estimation::{FitConditions, InstanceFit};
use num_complex::Complex64;

use crate::conditions;
use crate::record::{Record, Truth};
use crate::trial::{SKINS, instances, place, records, references};

/// Size of each error. Its effects are linear to a few per cent.
const SIZE: f64 = 3e-3;

/// A bench with one constant wrong by [`SIZE`].
struct Miscalibration {
    name: &'static str,
    errors: CalibrationErrors,
    record: fn(&mut Record),
    /// Factor on every impedance.
    impedance: Complex64,
}

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

fn miscalibrations() -> [Miscalibration; 6] {
    let exact = CalibrationErrors::default();
    let unity = Complex64::ONE;
    [
        Miscalibration {
            name: "amplitude",
            errors: CalibrationErrors {
                amplitude_relative: SIZE,
                ..exact
            },
            record: |record| scale(&mut record.amplitude_m, SIZE.exp()),
            impedance: unity,
        },
        Miscalibration {
            name: "impedance",
            errors: CalibrationErrors {
                impedance_relative: SIZE,
                ..exact
            },
            record: |_| (),
            impedance: unity * SIZE.exp(),
        },
        Miscalibration {
            name: "phase",
            errors: CalibrationErrors {
                phase_rad: SIZE,
                ..exact
            },
            record: |_| (),
            impedance: Complex64::cis(SIZE),
        },
        Miscalibration {
            name: "normal force",
            errors: CalibrationErrors {
                normal_force_relative: SIZE,
                ..exact
            },
            record: |record| {
                scale(&mut record.normal_n, SIZE.exp());
                scale(&mut record.mu, (-SIZE).exp());
            },
            impedance: unity,
        },
        Miscalibration {
            name: "lateral force",
            errors: CalibrationErrors {
                lateral_force_relative: SIZE,
                ..exact
            },
            record: |record| scale(&mut record.mu, SIZE.exp()),
            impedance: unity,
        },
        Miscalibration {
            name: "crosstalk",
            errors: CalibrationErrors {
                lateral_per_normal: SIZE,
                ..exact
            },
            record: |record| record.mu.iter_mut().for_each(|mu| *mu += SIZE),
            impedance: unity,
        },
    ]
}

impl Miscalibration {
    fn records(&self, right: &[Record]) -> Vec<Record> {
        let biased_record = |right: &Record| {
            let mut record = right.clone();
            (self.record)(&mut record);
            for z in record.corrected.iter_mut().chain(&mut record.plain) {
                *z *= self.impedance;
            }
            record
        };
        right.iter().map(biased_record).collect()
    }

    fn conditions(&self) -> FitConditions {
        let right = conditions();
        FitConditions {
            z_p_plain_n_s_per_m: right.z_p_plain_n_s_per_m * self.impedance,
            z_p_corrected_n_s_per_m: right.z_p_corrected_n_s_per_m * self.impedance,
            ..right
        }
    }

    fn readings(&self, mut readings: PlateReadings) -> PlateReadings {
        for reference in &mut readings.references {
            reference.z_p_n_s_per_m *= self.impedance;
        }
        readings
    }
}

/// Returns the estimates of an instance in order, with standard errors.
fn instance_estimates(fit: &InstanceFit) -> Vec<(&'static str, f64, f64)> {
    let (z_t, z_t_std) = (fit.z_t_n_s_per_m, fit.z_t_std_n_s_per_m);
    let middle = fit.series.mu.len() / 2;
    vec![
        ("σ_t", fit.sigma_t_m.ln(), fit.sigma_t_std_m / fit.sigma_t_m),
        ("Re Z_t", z_t.re, z_t_std.re),
        ("Im Z_t", z_t.im, z_t_std.im),
        ("τ, ms", 1e3 * fit.tau_s, 1e3 * fit.tau_std_s),
        ("μ0", fit.mu0, fit.mu0_std),
        (
            "gap",
            fit.series.gap_m[middle].ln(),
            fit.series.gap_std_m[middle] / fit.series.gap_m[middle],
        ),
        ("μ", fit.series.mu[middle], fit.series.mu_std[middle]),
    ]
}

fn trial_estimates(fit: &TrialFit) -> Vec<(&'static str, f64, f64)> {
    // Doubts about the laws are no errors of the calibration.
    let fit = fit.within_laws.as_deref().unwrap();
    let shared = &fit.shared;
    let ln = |name, estimate: &contact::uncertain::LogUncertain| {
        (name, estimate.value.ln(), estimate.ln_std)
    };
    let mut estimates = instance_estimates(&fit.instances[2]);
    estimates.extend([
        ln("S", &shared.contact_area_m2),
        ln("q0", &shared.q0_rad_per_m),
        ln("η", &shared.loss_factor),
        ln("τ of all", &shared.tau_s),
    ]);
    estimates
}

/// Compares the change of estimates by a wrong constant with the increase of their errors when the constant is stated as
/// uncertain. τ is stated at a mean gap that is taken as certain, so its error is slightly too large if the gap depends on the
/// constant.
fn assert_covered(
    name: &str,
    right: &[(&'static str, f64, f64)],
    wrong: &[(&'static str, f64, f64)],
    uncertain: &[(&'static str, f64, f64)],
) {
    for ((right, wrong), uncertain) in right.iter().zip(wrong).zip(uncertain) {
        assert_eq!(
            right.1, uncertain.1,
            "an error that is stated moves nothing"
        );
        let change = (wrong.1 - right.1).abs();
        let increase = (uncertain.2.powi(2) - right.2.powi(2)).max(0.0).sqrt();
        assert!(
            increase > 0.9 * change - 0.2 * SIZE && increase < 1.1 * change + 0.4 * SIZE,
            "{name}: {} moved by {change}, its error holds {increase} of that",
            right.0
        );
    }
}

#[test]
fn errors_of_a_trial_cover_those_of_the_calibration() {
    let right: Vec<Record> = (0..)
        .zip(records(&instances(SKINS[1], 5)))
        .map(|(seed, record)| record.with_noise(seed, 1e-5))
        .collect();
    let estimates = |records: &[Record], conditions: &FitConditions, readings: &PlateReadings| {
        let places: Vec<_> = records
            .iter()
            .map(|record| place(record.series()))
            .collect();
        let fit = trial::fit(&places, conditions, readings, &TrialOptions::default()).unwrap();
        let floor = fit.shared.friction_floor.unwrap();
        let mut estimates = trial_estimates(&fit);
        estimates.push(("φ", floor.value, floor.std));
        estimates
    };
    let reference = estimates(&right, &conditions(), &references(5));
    for miscalibration in miscalibrations() {
        let conditions_with_errors = FitConditions {
            calibration: miscalibration.errors,
            ..conditions()
        };
        assert_covered(
            miscalibration.name,
            &reference,
            &estimates(
                &miscalibration.records(&right),
                &miscalibration.conditions(),
                &miscalibration.readings(references(5)),
            ),
            &estimates(&right, &conditions_with_errors, &references(5)),
        );
    }
}

#[test]
fn errors_of_a_single_instance_cover_those_of_the_calibration() {
    let right = [SKINS[0]
        .record()
        .with_inertia(&SKINS[0])
        .with_noise(4, 1e-5)];
    let estimates = |records: &[Record], conditions: &FitConditions| {
        let series = records[0].series();
        instance_estimates(&dynamic::fit(&series, conditions, &DynamicOptions::default()).unwrap())
    };
    let reference = estimates(&right, &conditions());
    for miscalibration in miscalibrations() {
        let conditions_with_errors = FitConditions {
            calibration: miscalibration.errors,
            ..conditions()
        };
        assert_covered(
            miscalibration.name,
            &reference,
            &estimates(
                &miscalibration.records(&right),
                &miscalibration.conditions(),
            ),
            &estimates(&right, &conditions_with_errors),
        );
    }
}

/// The film's motion by other modes has no fitted parameter: at one standard deviation of it, no estimate moves by more than
/// its error, to first order.
#[test]
fn errors_of_a_trial_cover_the_film_motion_by_other_modes() {
    let options = TrialOptions::default();
    let one_std = std::f64::consts::SQRT_2 * options.priors.residual_mobility_std_m_per_n_s;
    let estimates = |film_mobility: f64| {
        let skin = Truth {
            film_mobility,
            ..SKINS[1]
        };
        let records: Vec<Record> = (0..)
            .zip(records(&instances(skin, 5)))
            .map(|(seed, record)| record.with_noise(seed, 1e-5))
            .collect();
        let places: Vec<_> = records
            .iter()
            .map(|record| place(record.series()))
            .collect();
        trial_estimates(&trial::fit(&places, &conditions(), &references(5), &options).unwrap())
    };
    let reference = estimates(0.0);
    for film_mobility in [-one_std, one_std] {
        for (reference, estimate) in reference.iter().zip(estimates(film_mobility)) {
            let change = (estimate.1 - reference.1).abs();
            assert!(
                change < 1.1 * reference.2,
                "{} moves by {change}, its error is {}",
                estimate.0,
                reference.2
            );
        }
    }
}
