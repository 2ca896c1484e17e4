//! The standard errors of the estimates cover the effect of wrong calibration constants.

use contact::CalibrationErrors;
use estimation::dynamic::{self, DynamicOptions};
use estimation::trial::{self, PlateReadings, TrialFit, TrialOptions};
use estimation::{FitConditions, InstanceFit};
use num_complex::Complex64;

use crate::conditions;
use crate::record::{Record, Truth};
use crate::trial::{SKINS, instances, placed, records, references};

/// Size of each error. Its effects are linear to a few per cent.
const SIZE: f64 = 3e-3;

/// A bench with one constant wrong by [`SIZE`].
struct Wrong {
    name: &'static str,
    errors: CalibrationErrors,
    record: fn(&mut Record),
    /// Factor on every impedance.
    impedance: Complex64,
}

fn scale(of: &mut [f64], by: f64) {
    of.iter_mut().for_each(|value| *value *= by);
}

fn wrong() -> [Wrong; 5] {
    let exact = CalibrationErrors::default();
    let one = Complex64::ONE;
    [
        Wrong {
            name: "amplitude",
            errors: CalibrationErrors {
                amplitude_relative: SIZE,
                ..exact
            },
            record: |of| scale(&mut of.amplitude_m, SIZE.exp()),
            impedance: one,
        },
        Wrong {
            name: "impedance",
            errors: CalibrationErrors {
                impedance_relative: SIZE,
                ..exact
            },
            record: |_| (),
            impedance: one * SIZE.exp(),
        },
        Wrong {
            name: "phase",
            errors: CalibrationErrors {
                phase_rad: SIZE,
                ..exact
            },
            record: |_| (),
            impedance: Complex64::cis(SIZE),
        },
        Wrong {
            name: "normal force",
            errors: CalibrationErrors {
                normal_force_relative: SIZE,
                ..exact
            },
            record: |of| {
                scale(&mut of.normal_n, SIZE.exp());
                scale(&mut of.mu, (-SIZE).exp());
            },
            impedance: one,
        },
        Wrong {
            name: "lateral force",
            errors: CalibrationErrors {
                lateral_force_relative: SIZE,
                ..exact
            },
            record: |of| scale(&mut of.mu, SIZE.exp()),
            impedance: one,
        },
    ]
}

impl Wrong {
    fn records(&self, right: &[Record]) -> Vec<Record> {
        let wrong = |right: &Record| {
            let mut record = right.clone();
            (self.record)(&mut record);
            for z in record.corrected.iter_mut().chain(&mut record.plain) {
                *z *= self.impedance;
            }
            record
        };
        right.iter().map(wrong).collect()
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
fn of_instance(fit: &InstanceFit) -> Vec<(&'static str, f64, f64)> {
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

fn of_trial(fit: &TrialFit) -> Vec<(&'static str, f64, f64)> {
    let shared = &fit.shared;
    let ln = |name, of: &contact::uncertain::LogUncertain| (name, of.value.ln(), of.ln_std);
    let mut all = of_instance(&fit.instances[2]);
    all.extend([
        ln("S", &shared.contact_area_m2),
        ln("q0", &shared.q0_rad_per_m),
        ln("η", &shared.loss_factor),
        ln("τ of all", &shared.tau_s),
    ]);
    all
}

/// Compares the change of estimates by a wrong constant with the increase of their errors when the constant is stated as
/// uncertain. τ is stated at a mean gap that is taken as certain, so its error is slightly too large if the gap depends on the
/// constant.
fn assert_held(
    name: &str,
    right: &[(&'static str, f64, f64)],
    wrong: &[(&'static str, f64, f64)],
    stated: &[(&'static str, f64, f64)],
) {
    for ((right, wrong), stated) in right.iter().zip(wrong).zip(stated) {
        assert_eq!(right.1, stated.1, "an error that is stated moves nothing");
        let moved = (wrong.1 - right.1).abs();
        let held = (stated.2.powi(2) - right.2.powi(2)).max(0.0).sqrt();
        assert!(
            held > 0.9 * moved - 0.2 * SIZE && held < 1.1 * moved + 0.4 * SIZE,
            "{name}: {} moved by {moved}, its error holds {held} of that",
            right.0
        );
    }
}

#[test]
fn errors_of_a_trial_hold_those_of_the_calibration() {
    let right: Vec<Record> = (0..)
        .zip(records(&instances(SKINS[1], 5)))
        .map(|(seed, record)| record.with_noise(seed, 1e-5))
        .collect();
    let fitted = |records: &[Record], conditions: &FitConditions, readings: &PlateReadings| {
        let placed: Vec<_> = records.iter().map(|of| placed(of.series())).collect();
        of_trial(&trial::fit(&placed, conditions, readings, &TrialOptions::default()).unwrap())
    };
    let without = fitted(&right, &conditions(), &references(5));
    for wrong in wrong() {
        let stated = FitConditions {
            calibration: wrong.errors,
            ..conditions()
        };
        assert_held(
            wrong.name,
            &without,
            &fitted(
                &wrong.records(&right),
                &wrong.conditions(),
                &wrong.readings(references(5)),
            ),
            &fitted(&right, &stated, &references(5)),
        );
    }
}

#[test]
fn errors_of_an_instance_alone_hold_those_of_the_calibration() {
    let right = [SKINS[0]
        .record()
        .with_inertia(&SKINS[0])
        .with_noise(4, 1e-5)];
    let fitted = |records: &[Record], conditions: &FitConditions| {
        let series = records[0].series();
        of_instance(&dynamic::fit(&series, conditions, &DynamicOptions::default()).unwrap())
    };
    let without = fitted(&right, &conditions());
    for wrong in wrong() {
        let stated = FitConditions {
            calibration: wrong.errors,
            ..conditions()
        };
        assert_held(
            wrong.name,
            &without,
            &fitted(&wrong.records(&right), &wrong.conditions()),
            &fitted(&right, &stated),
        );
    }
}

/// The film's motion by other modes has no fitted parameter: at one standard deviation of it, no estimate moves by more than
/// its error, to first order.
#[test]
fn errors_of_a_trial_hold_what_other_modes_do_to_the_film() {
    let options = TrialOptions::default();
    let one_std = std::f64::consts::SQRT_2 * options.priors.residual_mobility_std_m_per_n_s;
    let fitted = |film_mobility: f64| {
        let skin = Truth {
            film_mobility,
            ..SKINS[1]
        };
        let records: Vec<Record> = (0..)
            .zip(records(&instances(skin, 5)))
            .map(|(seed, record)| record.with_noise(seed, 1e-5))
            .collect();
        let placed: Vec<_> = records.iter().map(|of| placed(of.series())).collect();
        of_trial(&trial::fit(&placed, &conditions(), &references(5), &options).unwrap())
    };
    let without = fitted(0.0);
    for film_mobility in [-one_std, one_std] {
        for (without, with) in without.iter().zip(fitted(film_mobility)) {
            let moved = (with.1 - without.1).abs();
            assert!(
                moved < 1.1 * without.2,
                "{} moves by {moved}, its error is {}",
                with.0,
                without.2
            );
        }
    }
}
