//! Fit of a whole trial, on instances from [`record`](crate::record).

use approx::assert_relative_eq;
use contact::uncertain::Uncertain;
use estimation::dynamic::{self, DynamicOptions};
use estimation::trial::{
    self, Misfit, PlacedInstance, PlateReadings, PlateReference, TrialFit, TrialOptions,
};
use estimation::{FitConditions, FitError, FitParameter, FitVerdict, InstanceSeries, ModeAcross};
use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::conditions;
use crate::record::{LEAD, Record, TRUTH, Truth};

pub const SKINS: [Truth; 3] = [
    TRUTH,
    Truth {
        area_m2: 130e-6,
        area_exponent: 0.5,
        film_mean_s: 0.2e-3,
        lag_exponent: 0.4,
        q0_rad_per_m: 2.6e4,
        loss_factor: 0.45,
        tau_s: 0.6e-3,
        friction_floor: 0.12,
        ..TRUTH
    },
    Truth {
        area_m2: 390e-6,
        area_exponent: 0.25,
        film_mean_s: 0.1e-3,
        lag_exponent: 0.2,
        q0_rad_per_m: 0.8e4,
        loss_factor: 0.2,
        tau_s: 1.7e-3,
        friction_floor: 0.05,
        ..TRUTH
    },
];

/// A trial in which moisture grows, the plate warms, and each instance has a different normal force.
pub fn instances(skin: Truth, n: usize) -> Vec<Truth> {
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

/// Plate of [`instances`] before the first and after the last.
pub fn references(n: usize) -> PlateReadings {
    let reference = |time_s: f64| {
        let part = time_s / n as f64;
        PlateReference {
            time_s,
            z_p_n_s_per_m: crate::record::Z_P + Complex64::new(0.25 * part, -0.2 + part),
            std_n_s_per_m: 1e-3,
        }
    };
    PlateReadings {
        references: [-1.0, n as f64].map(reference).to_vec(),
        touches_s: vec![(-0.5, n as f64 - 0.5)],
    }
}

fn fit_records(records: &[Record]) -> TrialFit {
    fit_with_readings(records, &PlateReadings::default())
}

fn fit_with_readings(records: &[Record], readings: &PlateReadings) -> TrialFit {
    let places: Vec<PlacedInstance<'_>> = records
        .iter()
        .map(|record| place(record.series()))
        .collect();
    trial::fit(&places, &conditions(), readings, &TrialOptions::default()).unwrap()
}

pub fn place(series: InstanceSeries<'_>) -> PlacedInstance<'_> {
    PlacedInstance {
        series,
        off_centre_m: 0.0,
    }
}

/// Records of instances too far apart to determine trends.
pub fn records(truths: &[Truth]) -> Vec<Record> {
    let pairs = (0..).map(f64::from).zip(truths);
    pairs
        .map(|(start_s, truth)| truth.record().with_inertia(truth).shift(start_s))
        .collect()
}

fn mean_force_n(record: &Record) -> f64 {
    let forces_n = &record.normal_n[LEAD..];
    forces_n.iter().sum::<f64>() / forces_n.len() as f64
}

/// Returns the mean of τ at the mean gap of each instance.
fn mean_lag_s(truths: &[Truth]) -> f64 {
    let lags_s = truths.iter().map(|truth| {
        let record = truth.record();
        let gaps_m = &record.gap_m[LEAD..];
        let gap_m = gaps_m.iter().sum::<f64>() / gaps_m.len() as f64;
        truth.tau_s * (gap_m / 10e-6).powf(truth.lag_exponent)
    });
    lags_s.sum::<f64>() / truths.len() as f64
}

/// The fit recovers all constants of the skin without assumptions, and the parameters of each instance separately.
#[test]
fn a_trial_recovers_the_skin_and_every_instance() {
    for skin in SKINS {
        let truths = instances(skin, 5);
        let noisy = (0..).zip(records(&truths));
        let noisy: Vec<Record> = noisy
            .map(|(seed, record)| record.with_noise(seed, 1e-5))
            .collect();
        let fit = fit_records(&noisy);
        assert_eq!(fit.shared.verdict, FitVerdict::Converged);
        // Where all residuals are rounding, the priors pull as if the force were known to 1e-4.
        let forces = truths.iter().map(|truth| mean_force_n(&truth.record()));
        let area_m2 = skin.area_m2(forces.sum::<f64>() / truths.len() as f64);
        let shared = &fit.shared;
        let assert_near = |value: f64, truth: f64, tolerance: f64| {
            assert!(
                (value / truth - 1.0).abs() < tolerance,
                "{value} {truth}: {shared:?}"
            );
        };
        assert_near(shared.contact_area_m2.value, area_m2, 0.025);
        assert_near(shared.q0_rad_per_m.value, skin.q0_rad_per_m, 0.03);
        // Only the priors separate η from the rotation angle of the finger's part.
        assert_near(shared.loss_factor.value, skin.loss_factor, 0.02);
        let tau_s = fit.instances.iter().map(|instance| instance.tau_s);
        assert_near(
            shared.tau_s.value,
            tau_s.sum::<f64>() / truths.len() as f64,
            0.02,
        );
        // A film that averages causes the same delay as a lag.
        let delay_s = shared.tau_s.value + shared.film_mean_s;
        assert_near(delay_s, mean_lag_s(&truths) + skin.film_mean_s, 0.1);
        let exponents = [
            (shared.area_exponent.value, skin.area_exponent),
            (shared.lag_exponent.value, skin.lag_exponent),
        ];
        for (value, truth) in exponents {
            assert!((value - truth).abs() < 0.1, "{value} {truth}: {shared:?}");
        }
        assert_eq!(shared.misfit, []);
        let floor = fit.shared.friction_floor.unwrap().value;
        assert_relative_eq!(floor, skin.friction_floor, epsilon = 2e-3);
        assert_relative_eq!(fit.shared.lateral_lag_s.unwrap().value, 0.0, epsilon = 1e-4);
        assert_eq!(fit.instances.len(), truths.len());
        for (instance, truth) in fit.instances.iter().zip(&truths) {
            assert_near(instance.sigma_t_m, truth.sigma_t_m, 0.01);
            let error = (instance.z_t_n_s_per_m - truth.z_t).norm();
            assert!(error < 0.02 * truth.z_t.norm(), "{error}");
            let offset = instance.plate_offset_n_s_per_m;
            assert_relative_eq!(offset.im, truth.plate_offset, epsilon = 5e-3);
            assert_relative_eq!(offset.re, truth.plate_damping, epsilon = 5e-3);
            assert_near(instance.mu0, truth.mu0, 2e-3);
            assert!(instance.agreement.rms_mu < 1e-3, "{:?}", instance.agreement);
        }
    }
}

/// A plate read before and after determines how its damping changed under the finger, which warmed it.
#[test]
fn references_determine_the_damping_between_them() {
    let (touch, time_constant_s) = ((-0.5, 4.5), 4.0);
    let warmth = |time_s: f64| {
        let (touch_s, release_s) = (
            (time_s.min(touch.1) - touch.0).max(0.0),
            (time_s - touch.1).max(0.0),
        );
        (1.0 - (-touch_s / time_constant_s).exp()) * (-release_s / time_constant_s).exp()
    };
    let offset = |time_s: f64| Complex64::new(0.3, -0.8) * warmth(time_s);
    let truths: Vec<Truth> = (0..5)
        .map(|i| offset(f64::from(i)))
        .map(|offset| Truth {
            plate_damping: offset.re,
            plate_offset: offset.im,
            ..TRUTH
        })
        .collect();
    let noisy = records(&truths)
        .into_iter()
        .enumerate()
        .map(|(seed, record)| record.with_noise(seed as u64, 1e-4));
    let noisy: Vec<Record> = noisy.collect();
    let reference = |time_s: f64| PlateReference {
        time_s,
        z_p_n_s_per_m: crate::record::Z_P + offset(time_s),
        std_n_s_per_m: 3e-4,
    };
    let readings = PlateReadings {
        references: [-1.0, -0.7, 4.7, 5.0, 5.3].map(reference).to_vec(),
        touches_s: vec![touch],
    };
    // Doubts about the laws outweigh those about the plate.
    let [reference_fit, plain_fit] = [fit_with_readings(&noisy, &readings), fit_records(&noisy)]
        .map(|fit| *fit.within_laws.unwrap());
    assert_eq!(reference_fit.shared.misfit, []);
    for ((reference_fit, plain_fit), truth) in reference_fit
        .instances
        .iter()
        .zip(&plain_fit.instances)
        .zip(&truths)
    {
        let error = reference_fit.plate_offset_n_s_per_m.re - truth.plate_damping;
        assert!(error.abs() < 0.005, "{error}");
        assert_relative_eq!(
            reference_fit.sigma_t_m,
            truth.sigma_t_m,
            max_relative = 0.02
        );
        assert!(reference_fit.sigma_t_std_m < plain_fit.sigma_t_std_m);
    }
}

/// A plate that differs under the finger from the one before and after indicates another law of the finger.
#[test]
fn a_plate_offset_under_the_finger_alone_is_a_misfit() {
    let truths = [Truth {
        plate_offset: 0.3,
        ..TRUTH
    }; 5];
    let readings = PlateReadings {
        references: [-1.0, -0.8, 4.7, 4.9]
            .map(|time_s| PlateReference {
                time_s,
                z_p_n_s_per_m: crate::record::Z_P,
                std_n_s_per_m: 3e-4,
            })
            .to_vec(),
        touches_s: vec![(-0.5, 4.5)],
    };
    let fit = fit_with_readings(&records(&truths), &readings);
    let is_plate = |sign: &Misfit| matches!(sign, Misfit::Plate { .. });
    assert!(fit.shared.misfit.iter().any(is_plate), "{:?}", fit.shared);
}

/// An implausible skin is rejected, as is a friction that the contact does not explain.
#[test]
fn another_law_than_the_model_is_a_misfit() {
    let lag_truth = Truth {
        lag_exponent: 1.3,
        ..TRUTH
    };
    let fit = fit_with_readings(&records(&instances(lag_truth, 5)), &references(5));
    let is_unlikely = |sign: &Misfit| matches!(sign, Misfit::Unlikely { .. });
    assert!(
        fit.shared.misfit.iter().any(is_unlikely),
        "{:?}",
        fit.shared
    );
    let slip_records: Vec<Record> = records(&instances(TRUTH, 5))
        .into_iter()
        .map(|mut record| {
            for (sample, mu) in record.mu.iter_mut().enumerate() {
                *mu += 0.1 * (0.2 * sample as f64).sin().abs();
            }
            record
        })
        .collect();
    let fit = fit_with_readings(&slip_records, &references(5));
    let is_friction = |sign: &Misfit| matches!(sign, Misfit::Friction { .. });
    assert!(
        fit.shared.misfit.iter().all(is_friction),
        "{:?}",
        fit.shared
    );
    assert_eq!(fit.shared.misfit.len(), 1);
}

/// The fit of a long instance does not take a time that grows with the third power of its samples.
#[test]
fn long_instances_are_weighed_sample_by_sample() {
    let factor = 6;
    let records: Vec<Record> = records(&instances(TRUTH, 3))
        .iter()
        .map(|record| record.resample(factor))
        .collect();
    let places: Vec<PlacedInstance<'_>> = records
        .iter()
        .map(|record| place(InstanceSeries::new(record.samples(), factor * LEAD).unwrap()))
        .collect();
    let options = TrialOptions::default();
    let fit = trial::fit(&places, &conditions(), &references(3), &options).unwrap();
    assert_eq!(fit.shared.verdict, FitVerdict::Converged);
    for (instance, truth) in fit.instances.iter().zip(&instances(TRUTH, 3)) {
        assert_relative_eq!(instance.sigma_t_m, truth.sigma_t_m, max_relative = 0.02);
    }
}

/// A wrong contact area biases the method that assumes one, but not the trial's fit.
#[test]
fn a_single_instance_is_biased_by_another_skin_than_the_assumed() {
    let [_, skin, _] = SKINS;
    let record = skin.record();
    let fit = dynamic::fit(&record.series(), &conditions(), &DynamicOptions::default()).unwrap();
    assert!((fit.sigma_t_m / skin.sigma_t_m - 1.0).abs() > 0.1);
    let fixed_plate = DynamicOptions {
        plate_offset: false,
        ..DynamicOptions::default()
    };
    let warm_truth = Truth {
        plate_offset: 0.1,
        ..TRUTH
    };
    let record = warm_truth.record();
    let bias = |options: &DynamicOptions| {
        let fit = dynamic::fit(&record.series(), &conditions(), options).unwrap();
        (fit.sigma_t_m / warm_truth.sigma_t_m - 1.0).abs()
    };
    // The resonance has shifted by one hertz.
    assert!(bias(&fixed_plate) > 0.05, "{}", bias(&fixed_plate));
    assert!(bias(&DynamicOptions::default()) < 1e-5);
}

#[test]
fn a_lag_of_the_lateral_force_is_estimated_without_effect_on_the_contact() {
    for lag_s in [0.5e-3, 2e-3] {
        let truths = instances(SKINS[1], 4);
        let records = records(&truths);
        let lag_records: Vec<Record> = records
            .iter()
            .map(|record| record.with_lateral_lag(lag_s))
            .collect();
        let [prompt_fit, late_fit] =
            [&records, &lag_records].map(|records| fit_with_readings(records, &references(4)));
        assert_eq!(
            prompt_fit.shared.contact_area_m2,
            late_fit.shared.contact_area_m2
        );
        // The record's lag keeps the force constant over a sample, which delays it by half a sample.
        let estimate_s = late_fit.shared.lateral_lag_s.unwrap().value;
        assert!((estimate_s - lag_s).abs() < 0.3e-3, "{estimate_s}");
        for (instance, truth) in late_fit.instances.iter().zip(&truths) {
            assert!(instance.agreement.rms_mu < 3e-3, "{:?}", instance.agreement);
            assert_relative_eq!(instance.mu0, truth.mu0, max_relative = 0.01);
        }
    }
}

/// Without the second fit the intervals lack the doubt about the laws: no number of the trial may be used, and those within the
/// published laws are kept apart.
#[test]
fn a_trial_of_which_the_laws_in_doubt_cannot_be_fitted_is_not_converged() {
    let truths = instances(SKINS[0], 2);
    let records = records(&truths);
    let places: Vec<PlacedInstance<'_>> = records
        .iter()
        .map(|record| place(record.series()))
        .collect();
    let fit = |film_loss_std: f64| {
        let mut options = TrialOptions::default();
        options.priors.laws.film_loss.std = film_loss_std;
        trial::fit(&places, &conditions(), &references(2), &options).unwrap()
    };
    // A prior that no loss of the film meets.
    let without_doubt = fit(f64::NAN);
    let verdict = FitVerdict::NotConverged {
        reason: "the laws in doubt cannot be fitted".to_owned(),
    };
    assert!(!verdict.is_usable());
    assert_eq!(without_doubt.shared.verdict, verdict);
    assert_eq!(without_doubt.instances.len(), 2);
    for instance in &without_doubt.instances {
        assert_eq!(instance.verdict, verdict);
    }
    let within_laws = without_doubt.within_laws.unwrap();
    assert_eq!(within_laws.shared.verdict, FitVerdict::Converged);
    let sound = fit(0.3);
    assert_eq!(sound.shared.verdict, FitVerdict::Converged);
    assert_eq!(within_laws, sound.within_laws.unwrap());
}

/// Regression test: with a known wavelength no start of a search had a skin, so that no instance could be fitted.
#[test]
fn a_wavelength_far_greater_than_the_finger_changes_no_estimate() {
    let truths = instances(SKINS[0], 3);
    let records = records(&truths);
    let places: Vec<PlacedInstance<'_>> = records
        .iter()
        .map(|record| place(record.series()))
        .collect();
    let wavelength_m = Uncertain {
        value: 10.0,
        std: 0.0,
    };
    let known = FitConditions {
        mode_across: Some(ModeAcross {
            wavelength_m,
            crest_m: Uncertain {
                value: 0.0,
                std: 0.0,
            },
        }),
        ..conditions()
    };
    for place in &places {
        let [with, without] = [&known, &conditions()].map(|conditions| {
            dynamic::fit(&place.series, conditions, &DynamicOptions::default()).unwrap()
        });
        assert_relative_eq!(with.sigma_t_m, without.sigma_t_m, max_relative = 1e-4);
    }
    let [with, without] = [&known, &conditions()].map(|conditions| {
        trial::fit(
            &places,
            conditions,
            &references(3),
            &TrialOptions::default(),
        )
        .unwrap()
    });
    for (with, without) in with.instances.iter().zip(&without.instances) {
        assert_relative_eq!(with.sigma_t_m, without.sigma_t_m, max_relative = 1e-3);
    }
}

/// With extensions of the published laws drawn from the priors, correlated noise of the impedance and unseen components of the
/// force, the stated errors agree with the actual ones.
#[test]
fn standard_errors_of_a_trial_are_the_scatter() {
    let runs = 16;
    let mut scores = [0.0; 7];
    for run in 0..runs {
        let mut rng = ChaCha8Rng::seed_from_u64(run);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let skin = Truth {
            area_exponent: 0.3 + 0.2 * normal(),
            film_mean_s: 1e-4 * (0.5 * normal()).exp(),
            lag_exponent: 0.25 + 0.15 * normal(),
            ..SKINS[1]
        };
        let mut truths = instances(skin, 5);
        for truth in &mut truths {
            // Components of a thousandth of the force that last for some 2 ms.
            truth.force_noise = [8.0, 13.0, 21.0, 34.0, 55.0, 89.0, 110.0, 144.0].map(|hz| {
                (
                    5e-4 * normal() / (1.0 + (hz / 80.0_f64).powi(2)).sqrt(),
                    hz,
                    6.0 * normal(),
                )
            });
        }
        let records = records(&truths);
        let forces = records.iter().map(mean_force_n);
        let area_m2 = skin.area_m2(forces.sum::<f64>() / records.len() as f64);
        let tau_s = mean_lag_s(&truths);
        let noisy: Vec<Record> = records
            .iter()
            .enumerate()
            .map(|(i, record)| record.with_correlated_noise(1000 * run + i as u64, 2e-4))
            .collect();
        let fit = *fit_with_readings(&noisy, &references(5))
            .within_laws
            .unwrap();
        let (instance, truth) = (&fit.instances[2], &truths[2]);
        let (z_t, z_t_std) = (
            instance.z_t_n_s_per_m - truth.z_t,
            instance.z_t_std_n_s_per_m,
        );
        let ln = |value: f64, truth: f64| (value / truth).ln();
        for (score, (error, std)) in scores.iter_mut().zip([
            (
                ln(fit.shared.contact_area_m2.value, area_m2),
                fit.shared.contact_area_m2.ln_std,
            ),
            (
                ln(fit.shared.q0_rad_per_m.value, skin.q0_rad_per_m),
                fit.shared.q0_rad_per_m.ln_std,
            ),
            (
                ln(fit.shared.loss_factor.value, skin.loss_factor),
                fit.shared.loss_factor.ln_std,
            ),
            (ln(fit.shared.tau_s.value, tau_s), fit.shared.tau_s.ln_std),
            (instance.sigma_t_m - truth.sigma_t_m, instance.sigma_t_std_m),
            (z_t.re, z_t_std.re),
            (z_t.im, z_t_std.im),
        ]) {
            *score += (error / std).powi(2) / runs as f64;
        }
    }
    let [area, q0, loss_factor, others @ ..] = scores;
    for score in [area, q0].into_iter().chain(others) {
        // Errors are assumed to last 2 ms, but these last 0.7 ms.
        assert!((0.1..1.6).contains(&score), "{scores:?}");
    }
    // The error of η includes the effect of a second mode, which this plate does not have.
    assert!(loss_factor < 1.6, "{scores:?}");
}

/// The priors keep a single instance that hardly separates S from τ plausible; one without lift-off is not identified.
#[test]
fn the_priors_keep_one_instance_plausible() {
    let fit = fit_records(&[TRUTH.record().with_inertia(&TRUTH).with_noise(3, 1e-4)]);
    assert_eq!(fit.shared.verdict, FitVerdict::Converged);
    let area = fit.shared.contact_area_m2;
    assert!(
        (area.value / TRUTH.area_m2).ln().abs() < 4.0 * area.ln_std + 0.02,
        "{area:?}"
    );
    let rest_truth = Truth {
        modulation_index: 0.0,
        mean_amplitude_m: 0.05e-6,
        ..TRUTH
    };
    let fit = fit_records(&[rest_truth
        .record()
        .with_inertia(&rest_truth)
        .with_noise(3, 1e-4)]);
    let verdict = fit.shared.verdict;
    let is_unidentified = matches!(
        verdict,
        FitVerdict::NotIdentifiable {
            parameter: FitParameter::ContactArea | FitParameter::ZT,
            ..
        }
    );
    assert!(is_unidentified, "{verdict:?}");
}

#[test]
fn a_trial_without_instances_or_lead_in_is_refused_by_name() {
    let error = trial::fit(
        &[],
        &conditions(),
        &PlateReadings::default(),
        &TrialOptions::default(),
    )
    .unwrap_err();
    assert_eq!(error, FitError::NoStart);
    let record = TRUTH.record();
    let no_lead = InstanceSeries::new(record.samples(), LEAD / 2).unwrap();
    let error = trial::fit(
        &[place(no_lead)],
        &conditions(),
        &PlateReadings::default(),
        &TrialOptions::default(),
    )
    .unwrap_err();
    assert!(
        matches!(error, FitError::LeadInTooShort { .. }),
        "{error:?}"
    );
}
