//! Contrast and lag of the friction under a stimulus.
//!
//! The friction is fitted by least squares as a straight line of the stimulus s(t), delayed by the lag d at which the fit is best, and
//! of the time t from the middle of the samples, since friction grows or falls along a stroke:
//!
//! ```text
//! μ(t) = a + b s(t − d) + c t,    μ₀ = a + b s_least,    μ₁ = a + b s_greatest,    contrast = 1 − μ₁/μ₀
//! ```
//!
//! With m and s about their means, and about their own straight lines over the time (Frisch & Waugh 1933, Econometrica 1):
//!
//! ```text
//! ss = Σs² − (Σst)²/Σt²,    sm = Σsm − Σst Σmt/Σt²,    mm = Σm² − (Σmt)²/Σt²,    b = sm/ss,    r² = sm²/(ss mm)
//! ```
//!
//! A periodic stimulus fits as well half a period later with the opposite sign: the least lag of nearly equal ones is taken.
//!
//! The contrast is that of Messaoud, Bueno & Lemaire-Semail (2016), Tribology International 101: positive where the stimulus lowers
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

/// Straight line of the friction over the delayed stimulus.
#[derive(Clone, Copy)]
struct Line {
    offset: f64,
    slope: f64,
    r2: f64,
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
    let lines: Vec<Option<Line>> = (0..=lags)
        .map(|lag| line((time_s, mu), stimulus, lag))
        .collect();
    let r2 = |lag: usize| lines.get(lag).copied().flatten().map(|line| line.r2);
    let best = (0..lines.len()).filter_map(r2).fold(f64::NAN, f64::max);
    // The first stretch of lags that is nearly as good as the best one, and the best of them.
    let is_good = |lag: usize| r2(lag).is_some_and(|value| value >= NEARLY * best);
    let first = (0..lines.len()).find(|lag| is_good(*lag))?;
    let stretch = (first..lines.len()).take_while(|lag| is_good(*lag));
    let lag = stretch.reduce(|a, b| if r2(b) > r2(a) { b } else { a })?;
    let line = lines[lag]?;
    // The maximum between the samples, by the parabola through three.
    let before = lag.checked_sub(1).and_then(r2);
    let shift = before.zip(r2(lag + 1)).map_or(0.0, |(before, after)| {
        let curvature = before - 2.0 * line.r2 + after;
        if curvature < 0.0 {
            0.5 * (before - after) / curvature
        } else {
            0.0
        }
    });
    let mu_at = |value: f64| line.offset + line.slope * value;
    Some(StimulusEffect {
        mu_at_least: mu_at(least),
        mu_at_greatest: mu_at(greatest),
        contrast: 1.0 - mu_at(greatest) / mu_at(least),
        lag_s: (lag as f64 + shift) * step_s,
        r2: line.r2,
    })
}

/// Fits the friction from sample `lag` on to the stimulus before; `None` without enough samples, or without a change of both.
fn line((time_s, mu): (&[f64], &[f64]), stimulus: &[f64], lag: usize) -> Option<Line> {
    let samples = (lag..mu.len()).map(|index| [time_s[index], stimulus[index - lag], mu[index]]);
    let is_known = |sample: &[f64; 3]| sample.iter().all(|value| value.is_finite());
    let samples: Vec<[f64; 3]> = samples.filter(is_known).collect();
    if samples.len() < FEWEST {
        return None;
    }
    let mean = |column: usize| {
        let sum: f64 = samples.iter().map(|sample| sample[column]).sum();
        sum / samples.len() as f64
    };
    let means = [mean(0), mean(1), mean(2)];
    let mut sums = [0.0; 6];
    for sample in &samples {
        let [t, s, m] = std::array::from_fn(|column| sample[column] - means[column]);
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
    let slope = s_mu / s_s;
    let r2 = s_mu * s_mu / (s_s * mu_mu);
    r2.is_finite().then_some(Line {
        offset: means[2] - slope * means[1],
        slope,
        r2,
    })
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

    #[test]
    fn a_stimulus_that_stays_has_no_effect() {
        assert_eq!(effect(0.3, |_| 50.0), None);
    }
}
