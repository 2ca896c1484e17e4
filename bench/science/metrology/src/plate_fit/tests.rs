//! Tests of the fit against plates that follow from the equation of motion.

use super::*;
use crate::fitted_value::FittedValue;
use approx::assert_relative_eq;
use num_complex::Complex64;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const TRUTH: TruePlate = TruePlate {
    f0: 35_123.4,
    quality: 250.0,
    a: 0.004,
    phase: -0.8,
};

#[derive(Clone, Copy)]
struct TruePlate {
    f0: f64,
    quality: f64,
    a: f64,
    phase: f64,
}

impl TruePlate {
    /// Follows from the equation of motion, not the fit's own model: one mode, a further one, a delay and crosstalk.
    fn ratio(self, f: f64) -> Complex64 {
        let i = Complex64::I;
        let mode = |f0: f64, q: f64| (f0 * f0 - f * f + i * f * f0 / q).inv() * f0 * f0;
        let delay = Complex64::cis(-self.phase * f / self.f0);
        let further = 0.42 * (8.0 / 20.0) * (self.f0 / 41_200.0).powi(2);
        let plate = mode(self.f0, self.quality) + further * mode(41_200.0, 180.0);
        self.a * delay * plate + Complex64::from_polar(1e-4, 0.3)
    }

    fn responses(self, count: u32, span_hz: f64) -> Vec<Response> {
        (0..count)
            .map(|n| {
                let share = f64::from(n) / f64::from(count - 1) - 0.5;
                let frequency_hz = self.f0 + 7.0 + span_hz * share;
                Response {
                    frequency_hz,
                    ratio: self.ratio(frequency_hz),
                }
            })
            .collect()
    }
}

fn covers(estimate: FittedValue, truth: f64, times: f64) -> bool {
    (estimate.value - truth).abs() <= times * estimate.standard_error
}

#[test]
fn a_plate_with_a_further_mode_and_crosstalk_is_recovered() {
    let fit = PlateFit::fit(&TRUTH.responses(31, 560.0), CHANNEL_MATCH).unwrap();
    assert!((fit.resonance_hz.value - TRUTH.f0).abs() < 0.01, "{fit:?}");
    assert_relative_eq!(fit.quality.value, TRUTH.quality, max_relative = 1e-4);
    assert_relative_eq!(fit.static_ratio.value, TRUTH.a, max_relative = 1e-4);
    assert!((fit.pickup_phase_rad.value - TRUTH.phase).abs() < 1e-4);
    assert!(fit.residual < 1e-5, "{}", fit.residual);
}

#[test]
fn noisy_responses_are_covered() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
    let mut covered = [0u32; 4];
    for _ in 0..300 {
        let mut responses = TRUTH.responses(31, 560.0);
        for r in &mut responses {
            let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
            r.ratio += Complex64::new(white(), white()) * 1e-4 * TRUTH.a * TRUTH.quality;
        }
        let fit = PlateFit::fit(&responses, CHANNEL_MATCH).unwrap();
        assert!(fit.resonance_hz.standard_error < 0.05);
        assert!(fit.quality.standard_error < 1e-3 * TRUTH.quality);
        let checks = [
            covers(fit.resonance_hz, TRUTH.f0, 2.0),
            covers(fit.quality, TRUTH.quality, 2.0),
            covers(fit.static_ratio, TRUTH.a, 2.0),
            covers(fit.pickup_phase_rad, TRUTH.phase, 2.0),
        ];
        for (count, is_covered) in covered.iter_mut().zip(checks) {
            *count += u32::from(is_covered);
        }
    }
    assert!(covered.iter().all(|&n| n >= 278), "{covered:?} of 300");
}

#[test]
fn the_coarse_look_finds_any_plate_from_quality_50_to_500() {
    for quality in [50.0, 150.0, 250.0, 500.0] {
        let truth = TruePlate { quality, ..TRUTH };
        let coarse = find_resonance(&truth.responses(41, 1600.0)).unwrap();
        let (f0, q) = (coarse.resonance_hz, coarse.quality);
        assert!((f0 - truth.f0).abs() < 0.2 * truth.f0 / quality, "{f0}");
        assert_relative_eq!(q, quality, max_relative = 0.1);
    }
}

#[test]
fn data_without_a_resonance_are_refused() {
    let responses = TRUTH.responses(31, 560.0);
    assert_eq!(
        PlateFit::fit(&responses[..5], CHANNEL_MATCH),
        Err(PlateFitError::TooFew { count: 5 })
    );
    assert!(matches!(
        PlateFit::fit(&responses[20..], CHANNEL_MATCH),
        Err(PlateFitError::OutOfBand { .. })
    ));
    let mut lost = responses;
    lost[3].ratio.im = f64::NAN;
    assert!(matches!(
        PlateFit::fit(&lost, CHANNEL_MATCH),
        Err(PlateFitError::NotFinite { .. })
    ));
}

#[test]
fn a_second_mode_in_the_band_is_named_and_leaves_the_constants_right() {
    let i = Complex64::I;
    let responses: Vec<Response> = (0..41)
        .map(|n| {
            let frequency_hz = TRUTH.f0 - 280.0 + 14.0 * f64::from(n);
            let f = frequency_hz;
            let mode = |f0: f64, q: f64| (f0 * f0 - f * f + i * f * f0 / q).inv() * f0 * f0;
            let second = 0.08 * Complex64::cis(0.5) * mode(TRUTH.f0 + 190.0, 400.0);
            Response {
                frequency_hz,
                ratio: TRUTH.ratio(f) + TRUTH.a * second,
            }
        })
        .collect();
    let fit = PlateFit::fit(&responses, CHANNEL_MATCH).unwrap();
    let neighbour = fit.neighbour.unwrap();
    assert!(
        (neighbour.resonance_hz - TRUTH.f0 - 190.0).abs() < 5.0,
        "{neighbour:?}"
    );
    assert_relative_eq!(neighbour.share, 0.08 * 400.0 / 250.0, max_relative = 0.1);
    assert!((fit.resonance_hz.value - TRUTH.f0).abs() < 0.5, "{fit:?}");
    assert_relative_eq!(fit.quality.value, TRUTH.quality, max_relative = 5e-3);
    assert_relative_eq!(fit.static_ratio.value, TRUTH.a, max_relative = 5e-3);
}

/// Responses of a plate that stiffens with its amplitude, as no sum of modes does.
fn stiffening(shift: f64) -> Vec<Response> {
    let responses = TRUTH.responses(31, 560.0).into_iter();
    responses
        .map(|response| {
            let share = response.ratio.norm() / (TRUTH.a * TRUTH.quality);
            let moved = TruePlate {
                f0: TRUTH.f0 * (1.0 + shift * share.powi(2) / TRUTH.quality),
                ..TRUTH
            };
            Response {
                ratio: moved.ratio(response.frequency_hz),
                ..response
            }
        })
        .collect()
}

#[test]
fn the_errors_of_a_fit_grow_with_the_misfit_and_cover_its_effect() {
    let mut last = 0.0;
    for shift in [0.01, 0.05, 0.2] {
        let fit = PlateFit::fit(&stiffening(shift), CHANNEL_MATCH).unwrap();
        let errors = fit.constant_errors();
        assert!(errors.largest() > 2.0 * last, "{shift}: {errors:?}");
        last = errors.largest();
        assert!(covers(fit.quality, TRUTH.quality, 2.0), "{shift}: {fit:?}");
    }
}
