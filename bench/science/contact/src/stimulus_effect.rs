//! Contrast and lag of the friction under a stimulus.
//!
//! The friction is fitted by least squares as a straight line of the stimulus s(t), delayed by the lag d at which the fit is best, and
//! of the time t from the middle of the samples, since friction grows or falls along a stroke:
//!
//! ```text
//! μ(t) = a + b s(t − d) + c t
//! ```
//!
//! With m and s about their means, and about their own straight lines over the time (Frisch & Waugh 1933, Econometrica 1):
//!
//! ```text
//! ss = Σs² − (Σst)²/Σt²,    sm = Σsm − Σst Σmt/Σt²,    mm = Σm² − (Σmt)²/Σt²,    b = sm/ss,    r² = sm²/(ss mm)
//! ```
//!
//! Friction that saturates is no straight line of the stimulus, which would pass below the friction, even below zero, at the greatest
//! one. μ₀ and μ₁ are therefore the values, at s_least and s_greatest, of straight lines through the samples whose stimulus is within
//! a third of its range from there, without their trend:
//!
//! ```text
//! μ(t) − c t = a₀ + b₀ s(t − d),    μ₀ = a₀ + b₀ s_least,    and so μ₁,    with c = (Σmt − b Σst)/Σt²
//! ```
//!
//! A periodic stimulus fits as well half a period later with the opposite sign: the least lag of nearly equal ones is taken.
//!
//! The contrast, 1 − μ₁/μ₀, is that of Messaoud, Bueno & Lemaire-Semail (2016), Tribology International 101: positive where the stimulus lowers
//! the friction, as ultrasonic levitation does, and negative where it raises it, as electroadhesion does.

use serde::{Deserialize, Serialize};

/// Largest lag, s.
const LARGEST_LAG_S: f64 = 0.2;
/// Fewest samples of a fit.
const FEWEST: usize = 10;
/// Share of the greatest explained share from which on a lag is nearly as good.
const NEARLY: f64 = 0.8;

/// Effect of a stimulus on the friction of a stroke.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StimulusEffect {
    /// Friction at the least stimulus.
    pub mu_at_least: f64,
    /// Friction at the greatest stimulus.
    pub mu_at_greatest: f64,
    /// 1 − μ at the greatest over μ at the least stimulus.
    pub contrast: f64,
    /// Lag of the friction behind the stimulus, s.
    pub lag_s: f64,
    /// Share of the variance of μ about its trend that the stimulus explains.
    pub r2: f64,
}

/// Share of the range of the stimulus next to an end of it, and of the samples, in which the friction of that end is read.
const END_RANGE: f64 = 1.0 / 3.0;
const END_SAMPLES: f64 = 0.1;

/// Friction at the stimulus of the moment that it follows.
#[derive(Clone, Copy)]
struct Sample {
    time_s: f64,
    stimulus: f64,
    mu: f64,
}

/// Fit of the friction to the delayed stimulus and to the time.
#[derive(Clone, Copy)]
struct Fit {
    /// Share of the variance of μ about its trend that the stimulus explains.
    r2: f64,
    /// Mean time, s, and trend of μ, 1/s.
    middle_s: f64,
    trend_per_s: f64,
}

/// Returns the effect at the lag with which the stimulus explains most of the friction.
///
/// Times are in s; μ and stimulus have a value for each, NaN where they are not known. `None` without a stimulus that changes, and with
/// too few samples.
#[must_use]
pub fn stimulus_effect(time_s: &[f64], mu: &[f64], stimulus: &[f64]) -> Option<StimulusEffect> {
    let finite = || stimulus.iter().copied().filter(|value| value.is_finite());
    let (least, greatest) = (finite().reduce(f64::min)?, finite().reduce(f64::max)?);
    let (first_s, last_s) = (time_s.first()?, time_s.last()?);
    let step_s = (last_s - first_s) / (time_s.len() - 1) as f64;
    if !(greatest > least && step_s > 0.0) {
        return None;
    }
    let lags = ((LARGEST_LAG_S / step_s) as usize).min(time_s.len() / 2);
    let fits: Vec<Option<Fit>> = (0..=lags)
        .map(|lag| fit(&samples((time_s, mu), stimulus, lag)))
        .collect();
    let r2 = |lag: usize| fits.get(lag).copied().flatten().map(|fit| fit.r2);
    let best = (0..fits.len()).filter_map(r2).fold(f64::NAN, f64::max);
    // The first stretch of lags that is nearly as good as the best one, and the best of them.
    let is_good = |lag: usize| r2(lag).is_some_and(|value| value >= NEARLY * best);
    let first = (0..fits.len()).find(|lag| is_good(*lag))?;
    let stretch = (first..fits.len()).take_while(|lag| is_good(*lag));
    let lag = stretch.reduce(|a, b| if r2(b) > r2(a) { b } else { a })?;
    let fit = fits[lag]?;
    // The maximum between the samples, by the parabola through three.
    let before = lag.checked_sub(1).and_then(r2);
    let shift = before.zip(r2(lag + 1)).map_or(0.0, |(before, after)| {
        let curvature = before - 2.0 * fit.r2 + after;
        if curvature < 0.0 {
            0.5 * (before - after) / curvature
        } else {
            0.0
        }
    });
    let mut level = samples((time_s, mu), stimulus, lag);
    for sample in &mut level {
        sample.mu -= fit.trend_per_s * (sample.time_s - fit.middle_s);
    }
    let range = greatest - least;
    let mu_at_least = mu_at_end(&mut level, least, range);
    let mu_at_greatest = mu_at_end(&mut level, greatest, range);
    Some(StimulusEffect {
        mu_at_least,
        mu_at_greatest,
        contrast: 1.0 - mu_at_greatest / mu_at_least,
        lag_s: (lag as f64 + shift) * step_s,
        r2: fit.r2,
    })
}

/// Returns the known friction from sample `lag` on with the stimulus before.
fn samples((time_s, mu): (&[f64], &[f64]), stimulus: &[f64], lag: usize) -> Vec<Sample> {
    let samples = (lag..mu.len()).map(|index| Sample {
        time_s: time_s[index],
        stimulus: stimulus[index - lag],
        mu: mu[index],
    });
    let is_known = |sample: &Sample| {
        sample.mu.is_finite() && sample.stimulus.is_finite() && sample.time_s.is_finite()
    };
    samples.filter(is_known).collect()
}

/// Fits the friction to stimulus and time; `None` without enough samples, or without a change of both.
fn fit(samples: &[Sample]) -> Option<Fit> {
    if samples.len() < FEWEST {
        return None;
    }
    let mean =
        |value: fn(&Sample) -> f64| samples.iter().map(value).sum::<f64>() / samples.len() as f64;
    let middle_s = mean(|sample| sample.time_s);
    let means = [mean(|sample| sample.stimulus), mean(|sample| sample.mu)];
    let mut sums = [0.0; 6];
    for sample in samples {
        let (t, s, m) = (
            sample.time_s - middle_s,
            sample.stimulus - means[0],
            sample.mu - means[1],
        );
        let products = [t * t, s * t, m * t, s * s, s * m, m * m];
        for (sum, product) in sums.iter_mut().zip(products) {
            *sum += product;
        }
    }
    let [t_t, s_t, m_t, s_s, s_m, m_m] = sums;
    let (s_s, s_mu, mu_mu) = (
        s_s - s_t * s_t / t_t,
        s_m - s_t * m_t / t_t,
        m_m - m_t * m_t / t_t,
    );
    let r2 = s_mu * s_mu / (s_s * mu_mu);
    r2.is_finite().then_some(Fit {
        r2,
        middle_s,
        trend_per_s: (m_t - s_mu / s_s * s_t) / t_t,
    })
}

/// Returns the friction at one `end` of the stimulus' `range`, from the samples next to it; `samples` may come back in another order.
fn mu_at_end(samples: &mut [Sample], end: f64, range: f64) -> f64 {
    let distance = |sample: &Sample| (sample.stimulus - end).abs();
    samples.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let inside = samples.partition_point(|sample| distance(sample) <= END_RANGE * range);
    let least = FEWEST.max((END_SAMPLES * samples.len() as f64) as usize);
    let nearest = &samples[..inside.max(least).min(samples.len())];
    let n = nearest.len() as f64;
    let mean_s = nearest.iter().map(|sample| sample.stimulus).sum::<f64>() / n;
    let mean_mu = nearest.iter().map(|sample| sample.mu).sum::<f64>() / n;
    let (s_s, s_mu) = nearest.iter().fold((0.0, 0.0), |(s_s, s_mu), sample| {
        let s = sample.stimulus - mean_s;
        (s_s + s * s, s_mu + s * (sample.mu - mean_mu))
    });
    let value = mean_mu + s_mu / s_s * (end - mean_s);
    // The stimulus may have one value there; and no friction is negative.
    let is_friction = value.is_finite() && value >= 0.0;
    if is_friction { value } else { mean_mu }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use approx::assert_relative_eq;

    use super::*;

    /// Effect at 500 Hz of a stimulus of 0 to 100 V that changes the friction from 0.8 by `change`, 30 ms late.
    fn effect(change: f64, stimulus: impl Fn(f64) -> f64) -> Option<StimulusEffect> {
        let time_s: Vec<f64> = (0..2000).map(|n| f64::from(n) / 500.0).collect();
        let mu = time_s
            .iter()
            .map(|t| 0.8 + change * stimulus(t - 0.03) / 100.0);
        let mu: Vec<f64> = mu.collect();
        let stimulus: Vec<f64> = time_s.iter().map(|t| stimulus(*t)).collect();
        stimulus_effect(&time_s, &mu, &stimulus)
    }

    #[test]
    fn contrast_and_lag_are_those_of_the_stimulus() {
        let square = |t: f64| if t.rem_euclid(0.5) < 0.25 { 100.0 } else { 0.0 };
        let sine = |t: f64| 50.0 - 50.0 * (TAU * 2.0 * t).cos();
        for change in [-0.4, 0.3] {
            for effect in [effect(change, square), effect(change, sine)] {
                let effect = effect.unwrap();
                assert_relative_eq!(effect.mu_at_least, 0.8, epsilon = 1e-3);
                assert_relative_eq!(effect.contrast, -change / 0.8, epsilon = 2e-3);
                assert_relative_eq!(effect.lag_s, 0.03, epsilon = 1e-3);
                assert!(effect.r2 > 0.99, "{effect:?}");
            }
        }
    }

    /// Half a period later, 90 ms here, the fit has the opposite sign.
    #[test]
    fn of_a_periodic_stimulus_the_least_lag_is_taken() {
        let sine = |t: f64| 50.0 - 50.0 * (TAU * 8.3 * t).cos();
        let noisy = |t: f64| sine(t) + 10.0 * (1e4 * t).sin();
        for change in [-0.4, 0.3] {
            let effect = effect(change, noisy).unwrap();
            assert_relative_eq!(effect.lag_s, 0.03, epsilon = 2e-3);
            assert!((effect.contrast + change / 0.8).abs() < 0.1, "{effect:?}");
        }
    }

    /// Along a stroke the friction grows by more than the stimulus changes it.
    #[test]
    fn a_trend_of_the_friction_is_not_the_stimulus() {
        let time_s: Vec<f64> = (0..290).map(|n| f64::from(n) * 5e-3).collect();
        let stimulus = |t: f64| {
            if (5.0 * t).rem_euclid(1.0) < 0.5 {
                0.0
            } else {
                120.0
            }
        };
        let mu = time_s
            .iter()
            .map(|t| 0.3 + 0.2 * (t - 0.7) - 0.06 * stimulus(t - 0.02) / 120.0);
        let mu: Vec<f64> = mu.collect();
        let stimulus: Vec<f64> = time_s.iter().map(|t| stimulus(*t)).collect();
        let effect = stimulus_effect(&time_s, &mu, &stimulus).unwrap();
        assert_relative_eq!(effect.lag_s, 0.02, epsilon = 1e-3);
        assert_relative_eq!(effect.contrast, 0.2, epsilon = 0.01);
    }

    /// Regression test: a straight line through all samples was at −0.17 where friction vanished.
    #[test]
    fn friction_that_saturates_keeps_its_ends() {
        let time_s: Vec<f64> = (0..4000).map(|n| f64::from(n) / 500.0).collect();
        let stimulus = |t: f64| 50.0 - 50.0 * (TAU * 2.0 * t).cos();
        for scale in [10.0, 25.0] {
            let friction = |s: f64| 0.9 * (-s / scale).exp();
            let mu: Vec<f64> = time_s
                .iter()
                .map(|t| friction(stimulus(t - 0.03)))
                .collect();
            let stimulus: Vec<f64> = time_s.iter().map(|t| stimulus(*t)).collect();
            let effect = stimulus_effect(&time_s, &mu, &stimulus).unwrap();
            assert!((effect.mu_at_least - 0.9).abs() < 0.25, "{effect:?}");
            assert!(
                (effect.mu_at_greatest - friction(100.0)).abs() < 0.01,
                "{effect:?}"
            );
            assert!((0.9..=1.0).contains(&effect.contrast), "{effect:?}");
        }
    }

    /// A few stray values of the stimulus are its ends; the friction there is still a friction.
    #[test]
    fn friction_at_an_end_is_never_negative() {
        let time_s: Vec<f64> = (0..2000).map(|n| f64::from(n) / 500.0).collect();
        let stimulus: Vec<f64> = (0..2000)
            .map(|n| {
                if n % 400 == 7 {
                    300.0
                } else {
                    50.0 - 50.0 * (TAU * f64::from(n) / 250.0).cos()
                }
            })
            .collect();
        let mu: Vec<f64> = stimulus
            .iter()
            .map(|s| (0.8 - 0.008 * s).max(0.0))
            .collect();
        let effect = stimulus_effect(&time_s, &mu, &stimulus).unwrap();
        assert!((0.0..0.1).contains(&effect.mu_at_greatest), "{effect:?}");
        assert!(effect.contrast <= 1.0, "{effect:?}");
    }

    #[test]
    fn a_stimulus_that_stays_has_no_effect() {
        assert_eq!(effect(0.3, |_| 50.0), None);
    }
}
