//! The fit of a whole trial, on instances that [`record`](crate::record) makes.

use approx::assert_relative_eq;
use contact::fit::dynamic::{self, DynamicOptions};
use contact::fit::trial::{self, TrialFit, TrialOptions};
use contact::fit::{FitError, FitParameter, FitVerdict, InstanceSeries};
use num_complex::Complex64;

use crate::conditions;
use crate::record::{LEAD, Record, TRUTH, Truth};

const SKINS: [Truth; 3] = [
    TRUTH,
    Truth {
        area_m2: 130e-6,
        q0_rad_per_m: 2.6e4,
        loss_factor: 0.45,
        tau_s: 0.6e-3,
        friction_floor: 0.12,
        ..TRUTH
    },
    Truth {
        area_m2: 390e-6,
        q0_rad_per_m: 0.8e4,
        loss_factor: 0.2,
        tau_s: 1.7e-3,
        friction_floor: 0.05,
        ..TRUTH
    },
];

/// A trial in which moisture grows, the plate warms and no two instances are pressed alike.
fn instances(skin: Truth, n: usize) -> Vec<Truth> {
    (0..n)
        .map(|i| i as f64 / n as f64)
        .map(|part| Truth {
            sigma_t_m: skin.sigma_t_m * (1.0 + 0.2 * part),
            z_t: skin.z_t + Complex64::new(0.1, 0.6) * part,
            plate_offset: -0.2 + 1.0 * part,
            plate_damping: 0.25 * part,
            mu0: skin.mu0 - 0.1 * part,
            normal_n: skin.normal_n * (0.85 + 0.3 * part),
            ..skin
        })
        .collect()
}

fn fitted(records: &[Record]) -> TrialFit {
    let series: Vec<InstanceSeries<'_>> = records.iter().map(Record::series).collect();
    trial::fit(&series, &conditions(), &TrialOptions::default()).unwrap()
}

/// Nothing about the skin is assumed, and all of it is found; what an instance has of its own is told apart.
#[test]
fn a_trial_recovers_the_skin_and_every_instance() {
    for skin in SKINS {
        let truths = instances(skin, 5);
        let fit = fitted(&truths.iter().map(Truth::record).collect::<Vec<_>>());
        assert_eq!(fit.shared.verdict, FitVerdict::Converged);
        // The priors pull by what they weigh beside residuals that hardly are.
        assert_relative_eq!(
            fit.shared.contact_area_m2.value,
            skin.area_m2,
            max_relative = 3e-4
        );
        assert_relative_eq!(
            fit.shared.q0_rad_per_m.value,
            skin.q0_rad_per_m,
            max_relative = 1e-3
        );
        assert_relative_eq!(
            fit.shared.loss_factor.value,
            skin.loss_factor,
            max_relative = 1e-4
        );
        assert_relative_eq!(fit.shared.tau_s.value, skin.tau_s, max_relative = 1e-3);
        let floor = fit.shared.friction_floor.unwrap().value;
        assert_relative_eq!(floor, skin.friction_floor, epsilon = 3e-4);
        assert_relative_eq!(fit.shared.lateral_lag_s.unwrap().value, 0.0, epsilon = 1e-6);
        assert_eq!(fit.instances.len(), truths.len());
        for (instance, truth) in fit.instances.iter().zip(&truths) {
            assert_relative_eq!(instance.sigma_t_m, truth.sigma_t_m, max_relative = 3e-4);
            let apart = (instance.z_t_n_s_per_m - truth.z_t).norm();
            assert!(apart < 3e-4 * truth.z_t.norm(), "{apart}");
            let offset = instance.plate_offset_n_s_per_m;
            assert_relative_eq!(offset.im, truth.plate_offset, epsilon = 3e-4);
            assert_relative_eq!(offset.re, truth.plate_damping, epsilon = 3e-4);
            assert_relative_eq!(instance.mu0, truth.mu0, max_relative = 3e-4);
            assert!(instance.agreement.rms_mu < 1e-4, "{:?}", instance.agreement);
        }
    }
}

/// What another contact area does to the method that assumes one, it does not do to the trial's.
#[test]
fn an_instance_alone_is_biased_by_a_skin_that_is_not_the_assumed_one() {
    let [_, other, _] = SKINS;
    let record = other.record();
    let alone = dynamic::fit(&record.series(), &conditions(), &DynamicOptions::default()).unwrap();
    assert!((alone.sigma_t_m / other.sigma_t_m - 1.0).abs() > 0.1);
    let held = DynamicOptions {
        plate_offset: false,
        ..DynamicOptions::default()
    };
    let warmer = Truth {
        plate_offset: 0.1,
        ..TRUTH
    };
    let record = warmer.record();
    let bias = |options: &DynamicOptions| {
        let fit = dynamic::fit(&record.series(), &conditions(), options).unwrap();
        (fit.sigma_t_m / warmer.sigma_t_m - 1.0).abs()
    };
    // One hertz of the resonance.
    assert!(bias(&held) > 0.05, "{}", bias(&held));
    assert!(bias(&DynamicOptions::default()) < 1e-5);
}

#[test]
fn a_lag_of_the_lateral_force_is_found_and_does_not_touch_the_contact() {
    for lag_s in [0.5e-3, 2e-3] {
        let truths = instances(SKINS[1], 4);
        let records: Vec<Record> = truths.iter().map(Truth::record).collect();
        let lagging: Vec<Record> = records
            .iter()
            .map(|record| record.with_lateral_lag(lag_s))
            .collect();
        let (prompt, late) = (fitted(&records), fitted(&lagging));
        assert_eq!(prompt.shared.contact_area_m2, late.shared.contact_area_m2);
        // The record's lag holds the force over a sample, which is half of one late.
        let found_s = late.shared.lateral_lag_s.unwrap().value;
        assert!((found_s - lag_s).abs() < 0.3e-3, "{found_s}");
        for (instance, truth) in late.instances.iter().zip(&truths) {
            assert!(instance.agreement.rms_mu < 3e-3, "{:?}", instance.agreement);
            assert_relative_eq!(instance.mu0, truth.mu0, max_relative = 0.01);
        }
    }
}

/// With noise as a sound card adds it, the errors that are stated are those that are made.
#[test]
fn standard_errors_of_a_trial_are_the_scatter() {
    let truths = instances(SKINS[1], 5);
    let records: Vec<Record> = truths.iter().map(Truth::record).collect();
    let runs = 20;
    let mut scores = [0.0; 7];
    for run in 0..runs {
        let noisy: Vec<Record> = records
            .iter()
            .enumerate()
            .map(|(i, record)| record.with_noise(1000 * run + i as u64, 2e-4))
            .collect();
        let fit = fitted(&noisy);
        let (instance, truth) = (&fit.instances[2], &truths[2]);
        let (z_t, z_t_std) = (
            instance.z_t_n_s_per_m - truth.z_t,
            instance.z_t_std_n_s_per_m,
        );
        let ln = |value: f64, truth: f64| (value / truth).ln();
        for (score, (error, std)) in scores.iter_mut().zip([
            (
                ln(fit.shared.contact_area_m2.value, SKINS[1].area_m2),
                fit.shared.contact_area_m2.ln_std,
            ),
            (
                ln(fit.shared.q0_rad_per_m.value, SKINS[1].q0_rad_per_m),
                fit.shared.q0_rad_per_m.ln_std,
            ),
            (
                ln(fit.shared.loss_factor.value, SKINS[1].loss_factor),
                fit.shared.loss_factor.ln_std,
            ),
            (
                ln(fit.shared.tau_s.value, SKINS[1].tau_s),
                fit.shared.tau_s.ln_std,
            ),
            (instance.sigma_t_m - truth.sigma_t_m, instance.sigma_t_std_m),
            (z_t.re, z_t_std.re),
            (z_t.im, z_t_std.im),
        ]) {
            *score += (error / std).powi(2) / runs as f64;
        }
    }
    for score in scores {
        assert!((0.3..2.0).contains(&score), "{scores:?}");
    }
}

/// A single instance that hardly tells S from τ is kept sane by the priors; one without a lift is not identified.
#[test]
fn one_instance_is_held_by_the_priors() {
    let fit = fitted(&[TRUTH.record().with_noise(3, 1e-4)]);
    assert_eq!(fit.shared.verdict, FitVerdict::Converged);
    let found = fit.shared.contact_area_m2;
    assert!(
        (found.value / TRUTH.area_m2).ln().abs() < 4.0 * found.ln_std + 0.02,
        "{found:?}"
    );
    let still = Truth {
        modulation_index: 0.0,
        mean_amplitude_m: 0.05e-6,
        ..TRUTH
    };
    let fit = fitted(&[still.record().with_noise(3, 1e-4)]);
    let verdict = fit.shared.verdict;
    let weak = matches!(
        verdict,
        FitVerdict::NotIdentifiable {
            parameter: FitParameter::ContactArea,
            ..
        }
    );
    assert!(weak, "{verdict:?}");
}

#[test]
fn a_trial_without_instances_or_lead_in_is_refused_by_name() {
    let error = trial::fit(&[], &conditions(), &TrialOptions::default()).unwrap_err();
    assert_eq!(error, FitError::NoStart);
    let record = TRUTH.record();
    let no_lead = InstanceSeries::new(record.samples(), LEAD / 2).unwrap();
    let error = trial::fit(&[no_lead], &conditions(), &TrialOptions::default()).unwrap_err();
    assert!(
        matches!(error, FitError::LeadInTooShort { .. }),
        "{error:?}"
    );
}
