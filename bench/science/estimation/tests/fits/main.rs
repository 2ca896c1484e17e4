//! Fits of synthetic instances with a gap integrated by independent code.
#![expect(clippy::unwrap_used, reason = "helpers of tests may panic as tests do")]

mod calibration;
mod record;
mod trial;

use approx::assert_relative_eq;
use contact::live_estimator::{LiveEstimator, LiveFrame};
use contact::{AssumedConstants, CalibrationErrors, ModelError, self_sensed};
use estimation::{
    FitConditions, FitError, FitParameter, FitVerdict, InstanceSeries, dynamic, paper,
};
use num_complex::Complex64;
use record::{CARRIER_HZ, LEAD, OMEGA, RATE_HZ, Record, TRUTH, Truth, Z_P};

fn conditions() -> FitConditions {
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

fn fit_dynamic(record: &Record) -> estimation::InstanceFit {
    dynamic::fit(
        &record.series(),
        &conditions(),
        &dynamic::DynamicOptions::default(),
    )
    .unwrap()
}

fn fit_paper(record: &Record) -> paper::PaperFit {
    paper::fit(
        &record.series(),
        &conditions(),
        &paper::PaperOptions::default(),
    )
    .unwrap()
}

/// Accurate to 2e-6: the fit interpolates the equilibrium gap by cubics between samples 0.5 ms apart.
#[test]
fn dynamic_recovers_the_truth() {
    let truths = [
        TRUTH,
        Truth {
            sigma_t_m: 1.3e-6,
            z_t: Complex64::new(0.3, 2.6),
            tau_s: 0.7e-3,
            mu0: 0.6,
            plate_offset: 0.4,
            ..TRUTH
        },
        Truth {
            sigma_t_m: 2.6e-6,
            z_t: Complex64::new(0.9, 4.2),
            tau_s: 1.6e-3,
            normal_n: 0.5,
            ..TRUTH
        },
        Truth {
            sigma_t_m: 0.9e-6,
            z_t: Complex64::new(0.2, 2.2),
            tau_s: 0.4e-3,
            normal_n: 0.8,
            plate_offset: -0.9,
            ..TRUTH
        },
    ];
    for truth in truths {
        let record = truth.record();
        let fit = fit_dynamic(&record);
        assert_eq!(fit.verdict, FitVerdict::Converged);
        assert_relative_eq!(fit.sigma_t_m, truth.sigma_t_m, max_relative = 2e-6);
        assert_relative_eq!(
            (fit.z_t_n_s_per_m - truth.z_t).norm(),
            0.0,
            epsilon = 2e-6 * truth.z_t.norm()
        );
        assert_relative_eq!(fit.tau_s, truth.tau_s, epsilon = 1e-8);
        assert_relative_eq!(
            fit.plate_offset_n_s_per_m.im,
            truth.plate_offset,
            epsilon = 1e-5
        );
        assert_relative_eq!(fit.mu0, truth.mu0, max_relative = 4e-6);
        assert!(
            fit.agreement.rms_mu < 2e-6 && fit.agreement.r2_impedance > 1.0 - 1e-9,
            "{:?}",
            fit.agreement
        );
        for (i, (gap, k_c)) in record.gap_m.iter().zip(&record.k_c).skip(LEAD).enumerate() {
            assert_relative_eq!(fit.series.gap_m[i], *gap, max_relative = 1e-5);
            assert_relative_eq!(fit.series.k_c_n_per_m[i], *k_c, max_relative = 1e-5);
        }
    }
}

/// Standard errors agree with the scatter of repeated measurements.
#[test]
fn standard_errors_are_the_scatter() {
    let record = TRUTH.record();
    let runs = 60;
    let mut scores = [0.0; 6];
    for seed in 0..runs {
        let fit = fit_dynamic(&record.with_noise(seed, 1e-4));
        let z_t_error = fit.z_t_n_s_per_m - TRUTH.z_t;
        let gap_error = fit.series.gap_m[10] - record.gap_m[LEAD + 10];
        for (score, (error, std)) in scores.iter_mut().zip([
            (fit.sigma_t_m - TRUTH.sigma_t_m, fit.sigma_t_std_m),
            (z_t_error.re, fit.z_t_std_n_s_per_m.re),
            (z_t_error.im, fit.z_t_std_n_s_per_m.im),
            (fit.tau_s - TRUTH.tau_s, fit.tau_std_s),
            (
                fit.plate_offset_n_s_per_m.im,
                fit.plate_offset_std_n_s_per_m.im,
            ),
            (gap_error, fit.series.gap_std_m[10]),
        ]) {
            *score += (error / std).powi(2) / runs as f64;
        }
    }
    // χ² of 60 runs, with a margin for the estimated autocorrelation.
    for score in scores {
        assert!((0.5..1.7).contains(&score), "{scores:?}");
    }
}

/// In a steady world with true rest at low amplitude, the published method is unbiased.
#[test]
fn paper_is_unbiased_in_a_steady_world_with_rest() {
    let truth = Truth {
        tau_s: 0.0,
        modulation_index: 0.9999,
        normal_n: 0.65,
        ..TRUTH
    };
    let mut record = truth.record();
    record.plain.clone_from(&record.corrected);
    let options = paper::PaperOptions {
        rest_amplitude_m: 2e-8,
        lowest_s: 5e-4,
    };
    // The force must be steady as well: the method takes its mean.
    let lowest = record
        .time_s
        .iter()
        .position(|&t| t >= -1.0 / 24.0)
        .unwrap();
    for i in 0..record.time_s.len() {
        let t = record.time_s[i];
        let (a, n) = (truth.amplitude_m(t), truth.normal_n);
        let assumed = contact::Contact::new(&AssumedConstants::default(), truth.sigma_t_m).unwrap();
        let gap = assumed.equilibrium_gap_m(a, n).unwrap();
        let z_c = assumed.impedance_n_s_per_m(assumed.stiffness_n_per_m(gap, a), OMEGA);
        record.plain[i] = Z_P + truth.z_t * z_c / (truth.z_t + z_c);
        record.normal_n[i] = n;
        record.mu[i] = truth.mu0 * assumed.friction_ratio(gap, n);
    }
    let series = InstanceSeries::new(record.samples(), lowest).unwrap();
    let fit = paper::fit(&series, &conditions(), &options).unwrap();
    assert_eq!(fit.verdict, FitVerdict::Converged);
    assert!(fit.rest.below_threshold, "{:?}", fit.rest);
    assert_relative_eq!(fit.sigma_t_m, truth.sigma_t_m, max_relative = 2e-3);
    assert_relative_eq!((fit.z_t_n_s_per_m - truth.z_t).norm(), 0.0, epsilon = 1e-2);
    assert!(fit.agreement.rms_mu < 1e-3, "{:?}", fit.agreement);
}

/// Lag and envelope bias the published fit as in time-domain simulations: σ_t up, |Z_t| down, Re Z_t below zero.
#[test]
fn paper_is_biased_by_envelope_and_lag() {
    let record = TRUTH.record();
    let fit = fit_paper(&record);
    assert!(
        !fit.rest.below_threshold && fit.rest.samples == 10 && fit.rest.up_to_amplitude_m > 2e-7
    );
    assert!(
        (2.6e-6..3.2e-6).contains(&fit.sigma_t_m),
        "{}",
        fit.sigma_t_m
    );
    assert!(
        fit.z_t_n_s_per_m.re < 0.0 && (1.0..1.6).contains(&fit.z_t_n_s_per_m.im),
        "{}",
        fit.z_t_n_s_per_m
    );
    assert!(
        (0.1..0.2).contains(&fit.agreement.rms_mu),
        "{:?}",
        fit.agreement
    );

    // μ0 is read at the start of the rise, before the instance, where friction exceeds that of every sample of the instance.
    let max_mu = record.mu[LEAD..].iter().copied().fold(0.0, f64::max);
    assert!(max_mu < fit.mu0, "{max_mu} {}", fit.mu0);
    assert_relative_eq!(fit.mu0, TRUTH.mu0, max_relative = 0.02);

    let mut corrected = record.clone();
    corrected.plain.clone_from(&record.corrected);
    let corrected_fit = fit_paper(&corrected);
    assert!(
        (1.9e-6..2.3e-6).contains(&corrected_fit.sigma_t_m),
        "{}",
        corrected_fit.sigma_t_m
    );
    assert!(
        corrected_fit.agreement.rms_mu < 0.08,
        "{:?}",
        corrected_fit.agreement
    );
}

#[test]
fn a_lag_at_its_bound_is_reported() {
    // Impedance that leads its amplitude by one sample.
    let steady = Truth {
        tau_s: 0.0,
        ..TRUTH
    };
    let mut record = steady.record();
    let original = steady.record();
    record.corrected.rotate_left(1);
    let last = record.corrected.len() - 1;
    record.corrected[last] = original.corrected[last];
    let fit = fit_dynamic(&record);
    assert!(fit.verdict.to_string().contains("tau held at its bound"));
    let FitVerdict::LagAtBound { unbounded_tau_s } = fit.verdict else {
        panic!("{:?}", fit.verdict)
    };
    assert!(
        (-1e-3..-5e-5).contains(&unbounded_tau_s),
        "{unbounded_tau_s}"
    );
    assert_eq!((fit.tau_s, fit.tau_std_s), (0.0, 0.0));
    assert!(fit.verdict.is_usable() && fit.sigma_t_std_m.is_finite());
}

#[test]
fn no_lag_is_estimated_without_one() {
    let fit = fit_dynamic(
        &Truth {
            tau_s: 0.0,
            ..TRUTH
        }
        .record(),
    );
    assert!(
        fit.tau_s < 1e-8 && fit.verdict.is_usable(),
        "{} {:?}",
        fit.tau_s,
        fit.verdict
    );
    assert_relative_eq!(fit.sigma_t_m, TRUTH.sigma_t_m, max_relative = 1e-6);
}

/// Without modulation the data neither separate σ_t from Z_t nor show a lag.
#[test]
fn constant_amplitude_identifies_nothing() {
    let mut record = Truth {
        modulation_index: 0.0,
        ..TRUTH
    }
    .record();
    record.normal_n.fill(0.65);
    let mid = record.corrected[100];
    record.corrected.fill(mid);
    record.plain.fill(mid);
    let fit = fit_dynamic(&record.with_noise(1, 1e-4));
    assert!(
        matches!(
            fit.verdict,
            FitVerdict::NotIdentifiable { .. } | FitVerdict::NotConverged { .. }
        ),
        "{:?}",
        fit.verdict
    );
    assert!(!fit.verdict.is_usable());
}

/// At a hundredth of the amplitude the finger hardly lifts, and noise hides its motion.
#[test]
fn a_finger_that_hardly_lifts_is_not_identified() {
    let record = Truth {
        mean_amplitude_m: 2e-8,
        ..TRUTH
    }
    .record()
    .with_noise(2, 1e-4);
    let fit = fit_dynamic(&record);
    let FitVerdict::NotIdentifiable { parameter, std } = fit.verdict else {
        panic!("{:?}", fit.verdict)
    };
    assert!(
        std > 0.5 || parameter == FitParameter::Tau && std > 2e-3,
        "{parameter:?} {std}"
    );
}

/// σ_t depends on q0 and S, friction hardly does. Compared with refits at ±20 %.
#[test]
fn sensitivities_are_those_of_wider_refits() {
    let record = TRUTH.record();
    let options = dynamic::DynamicOptions::default();
    let sensitivities = dynamic::sensitivities(&record.series(), &conditions(), &options).unwrap();
    let refit = |factor: f64| {
        let mut conditions = conditions();
        conditions.assumed.q0_rad_per_m *= factor;
        dynamic::fit(&record.series(), &conditions, &options).unwrap()
    };
    let (above, below) = (refit(1.2), refit(1.0 / 1.2));
    let wide_slope = (above.sigma_t_m / below.sigma_t_m).ln() / (2.0 * 1.2f64.ln());
    assert_relative_eq!(sensitivities.q0.ln_sigma_t, wide_slope, max_relative = 0.05);
    assert!(
        (-0.25..-0.1).contains(&sensitivities.q0.ln_sigma_t),
        "{sensitivities:?}"
    );
    assert!(
        sensitivities.q0.ln_abs_z_t > 0.0 && sensitivities.contact_area.tau_s > 0.0,
        "{sensitivities:?}"
    );
    assert_eq!(sensitivities.q0, sensitivities.young_modulus);
    assert_relative_eq!(
        sensitivities.poisson_ratio.ln_sigma_t,
        sensitivities.q0.ln_sigma_t * 2.0 / 3.0,
        max_relative = 1e-12
    );
    assert!(above.agreement.rms_mu < 0.005 && below.agreement.rms_mu < 0.005);

    let paper_sensitivities = paper::sensitivities(
        &record.series(),
        &conditions(),
        &paper::PaperOptions::default(),
    )
    .unwrap();
    assert!(
        paper_sensitivities.q0.ln_sigma_t < 0.0 && paper_sensitivities.q0.tau_s == 0.0,
        "{paper_sensitivities:?}"
    );
}

#[test]
fn the_normal_force_is_sensed_and_friction_is_live() {
    let record = TRUTH.record();
    let finger = fit_dynamic(&record).finger;
    assert_relative_eq!(
        finger.covariance().unwrap()[0][0].sqrt(),
        fit_dynamic(&record).sigma_t_std_m,
        max_relative = 1e-9
    );
    let interval_s = 1.0 / RATE_HZ;
    let sensed =
        self_sensed::normal_force(&finger, interval_s, &record.corrected, &record.amplitude_m)
            .unwrap();
    let n = record.normal_n.len();
    assert!(sensed.normal_n[1].is_nan() && sensed.normal_n[n - 2].is_nan());
    let mut live = LiveEstimator::new(finger, interval_s).unwrap();
    for i in 0..n {
        let frame = LiveFrame {
            z_m_corrected_n_s_per_m: record.corrected[i],
            amplitude_m: record.amplitude_m[i],
            normal_n: Some(record.normal_n[i]),
        };
        let estimate = live.update(&frame).unwrap();
        let ratio = estimate.mu_ratio.unwrap();
        assert_relative_eq!(ratio.value, record.mu[i] / TRUTH.mu0, epsilon = 1e-5);
        assert!(ratio.std.is_finite());
        assert_relative_eq!(estimate.gap_m.value, record.gap_m[i], max_relative = 1e-5);
        assert_eq!(estimate.self_sensed_normal_n.is_some(), i >= 4);
        // The two slopes over five frames are exact for parabolas.
        if let Some(force) = estimate.self_sensed_normal_n {
            assert_relative_eq!(force.value, record.normal_n[i], max_relative = 5e-3);
        }
        if (2..n - 2).contains(&i) {
            assert_relative_eq!(sensed.normal_n[i], record.normal_n[i], max_relative = 3e-3);
            assert_relative_eq!(sensed.mu_ratio[i], record.mu[i] / TRUTH.mu0, epsilon = 2e-3);
        }
    }
    let without_gap = LiveFrame {
        z_m_corrected_n_s_per_m: Z_P,
        amplitude_m: 1e-6,
        normal_n: None,
    };
    assert!(matches!(
        live.update(&without_gap),
        Err(ModelError::NoGapForStiffness { .. })
    ));
    let frame = LiveFrame {
        z_m_corrected_n_s_per_m: record.corrected[0],
        amplitude_m: record.amplitude_m[0],
        normal_n: None,
    };
    assert_eq!(live.update(&frame).unwrap().mu_ratio, None);
}

#[test]
fn records_that_cannot_be_fitted_are_refused_by_name() {
    let record = TRUTH.record();
    let error_after = |change: fn(&mut Record)| {
        let mut record = record.clone();
        change(&mut record);
        InstanceSeries::new(record.samples(), LEAD).unwrap_err()
    };
    let is_at = |index: usize| move |error: FitError| matches!(error, FitError::Model(ModelError::AtSample { index: i, .. }) if i == index);
    assert!(is_at(47)(error_after(|r| r.corrected[47].im = f64::NAN)));
    assert!(is_at(8)(error_after(|r| r.normal_n[8] = 0.0)));
    assert!(is_at(9)(error_after(|r| r.amplitude_m[9] = -1e-6)));
    assert!(is_at(49)(error_after(|r| r.mu[49] = f64::NAN)));
    assert!(matches!(
        error_after(|r| r.time_s[50] += 1e-4),
        FitError::UnevenTime { index: 50, .. }
    ));
    assert!(matches!(
        error_after(|r| r.time_s.reverse()),
        FitError::Model(ModelError::OutOfRange { .. })
    ));
    assert!(matches!(
        error_after(|r| r.mu.truncate(3)),
        FitError::Model(ModelError::LengthMismatch { name: "mu", .. })
    ));
    let short = InstanceSeries::new(record.samples(), record.time_s.len() - 3).unwrap_err();
    assert!(
        matches!(short, FitError::TooFewSamples { got: 3, .. }),
        "{short}"
    );
    let no_lead = InstanceSeries::new(record.samples(), 39).unwrap();
    let error =
        dynamic::fit(&no_lead, &conditions(), &dynamic::DynamicOptions::default()).unwrap_err();
    assert!(matches!(error, FitError::LeadInTooShort { .. }), "{error}");

    let mut heavy = record.clone();
    heavy.normal_n.fill(5000.0);
    let error = dynamic::fit(
        &heavy.series(),
        &conditions(),
        &dynamic::DynamicOptions::default(),
    )
    .unwrap_err();
    assert_eq!(error, FitError::NoStart);
    assert_eq!(
        paper::fit(
            &heavy.series(),
            &conditions(),
            &paper::PaperOptions::default()
        )
        .unwrap_err(),
        FitError::NoStart
    );
}
