//! Friction of a stroke: its mean, and its contrast and lag under a stimulus.
//!
//! Under a stimulus s(t) the friction of a stroke is fitted by least squares as a straight line of the stimulus, delayed by the lag at
//! which the fit is best:
//!
//! ```text
//! μ(t) = a + b s(t − d),    μ₀ = a + b s_least,    μ₁ = a + b s_greatest,    contrast = 1 − μ₁/μ₀
//! ```
//!
//! The contrast is that of Messaoud, Bueno & Lemaire-Semail (2016), Tribology International 101: positive where the stimulus lowers
//! the friction, as ultrasonic levitation does, and negative where it raises it, as electroadhesion does.

use protocols::Direction;
use serde::{Deserialize, Serialize};

use crate::exploration_series::ExplorationSeries;

/// Largest lag, s.
const LARGEST_LAG_S: f64 = 0.2;
/// Fewest samples of a fit.
const FEWEST: usize = 10;

/// Friction of a stroke.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stroke {
    /// Direction.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Number of samples with a friction.
    pub n: usize,
    /// Mean of μ over these samples; NaN without any.
    pub mu: f64,
    /// Standard deviation of μ over them.
    pub mu_std: f64,
    /// Mean normal force of these samples, N.
    pub normal_n: f64,
    /// Mean speed |v| where it was measured, m/s.
    pub speed_m_per_s: f64,
    /// Mean amplitude at the pickup where it was measured, m.
    pub amplitude_m: f64,
    /// Effect of the stimulus; `None` without a stimulus that changes.
    pub effect: Option<StimulusEffect>,
}

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
    /// Share of the variance of μ that the stimulus explains.
    pub r2: f64,
}

impl Stroke {
    /// Returns the friction of an exploration.
    #[must_use]
    pub fn new(
        exploration: &ExplorationSeries,
        direction: Direction,
        (start_s, end_s): (f64, f64),
    ) -> Self {
        let is_known = |index: &usize| exploration.mu[*index].is_finite();
        let known: Vec<usize> = (0..exploration.mu.len()).filter(is_known).collect();
        let mean_of = |values: &[f64]| mean(known.iter().map(|index| values[*index]));
        let mu = mean_of(&exploration.mu);
        let squares = known
            .iter()
            .map(|index| (exploration.mu[*index] - mu).powi(2));
        let measured = |values: &[f64]| -> f64 {
            mean(
                values
                    .iter()
                    .map(|value| value.abs())
                    .filter(|value| value.is_finite()),
            )
        };
        Self {
            direction,
            start_s,
            end_s,
            n: known.len(),
            mu,
            mu_std: mean(squares).sqrt(),
            normal_n: mean_of(&exploration.normal_n),
            speed_m_per_s: measured(&exploration.velocity_m_per_s),
            amplitude_m: measured(&exploration.amplitude_m),
            effect: effect(&exploration.time_s, &exploration.mu, &exploration.stimulus),
        }
    }
}

/// Returns the mean; NaN without values.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    sum / n
}

/// Straight line of the friction over the delayed stimulus.
#[derive(Clone, Copy)]
struct Line {
    offset: f64,
    slope: f64,
    r2: f64,
}

/// Fits the friction at the lag, in samples, with which the stimulus explains most of it.
fn effect(time_s: &[f64], mu: &[f64], stimulus: &[f64]) -> Option<StimulusEffect> {
    let finite = || stimulus.iter().copied().filter(|value| value.is_finite());
    let (least, greatest) = (finite().reduce(f64::min)?, finite().reduce(f64::max)?);
    let (first_s, last_s) = (time_s.first()?, time_s.last()?);
    let step_s = (last_s - first_s) / (time_s.len() - 1) as f64;
    if !(greatest > least && step_s > 0.0) {
        return None;
    }
    let lags = ((LARGEST_LAG_S / step_s) as usize).min(time_s.len() / 2);
    let lines: Vec<Option<Line>> = (0..=lags).map(|lag| line(mu, stimulus, lag)).collect();
    let r2 = |lag: usize| lines.get(lag).copied().flatten().map(|line| line.r2);
    // The first of equal maxima: a periodic stimulus fits again a period later.
    let mut best: Option<usize> = None;
    for lag in 0..lines.len() {
        if r2(lag).is_some_and(|value| best.and_then(r2).is_none_or(|most| value > most + 1e-9)) {
            best = Some(lag);
        }
    }
    let lag = best?;
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
fn line(mu: &[f64], stimulus: &[f64], lag: usize) -> Option<Line> {
    let pairs: Vec<(f64, f64)> = (lag..mu.len())
        .map(|index| (stimulus[index - lag], mu[index]))
        .filter(|(s, mu)| s.is_finite() && mu.is_finite())
        .collect();
    if pairs.len() < FEWEST {
        return None;
    }
    let (mean_s, mean_mu) = (
        mean(pairs.iter().map(|p| p.0)),
        mean(pairs.iter().map(|p| p.1)),
    );
    let (mut s_s, mut s_mu, mut mu_mu) = (0.0, 0.0, 0.0);
    for (s, mu) in &pairs {
        s_s += (s - mean_s).powi(2);
        s_mu += (s - mean_s) * (mu - mean_mu);
        mu_mu += (mu - mean_mu).powi(2);
    }
    let slope = s_mu / s_s;
    let r2 = s_mu * s_mu / (s_s * mu_mu);
    r2.is_finite().then_some(Line {
        offset: mean_mu - slope * mean_s,
        slope,
        r2,
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use approx::assert_relative_eq;

    use super::*;
    use crate::measurements::ForceSeries;

    /// A stroke at 500 Hz under a square stimulus of 0 and 100 V, or a sine of 2 Hz, that changes the friction from 0.8 by `change`,
    /// 30 ms late.
    fn stroke(change: f64, stimulus: impl Fn(f64) -> f64) -> Stroke {
        let time_s: Vec<f64> = (0..2000).map(|n| f64::from(n) / 500.0).collect();
        let normal_n: Vec<f64> = time_s
            .iter()
            .map(|t| 0.5 + 0.1 * (TAU * 0.3 * t).sin())
            .collect();
        let mu = |t: f64| 0.8 + change * stimulus(t - 0.03) / 100.0;
        let lateral_n = time_s
            .iter()
            .zip(&normal_n)
            .map(|(t, normal_n)| -mu(*t) * normal_n);
        let series = ForceSeries {
            lateral_n: lateral_n.collect(),
            normal_n,
            position_m: vec![f64::NAN; 2000],
            velocity_m_per_s: vec![-0.04; 2000],
            stimulus: time_s.iter().map(|t| stimulus(*t)).collect(),
            time_s,
        };
        let exploration = ExplorationSeries::from_forces(series);
        Stroke::new(&exploration, Direction::RightToLeft, (0.0, 4.0))
    }

    #[test]
    fn contrast_and_lag_are_those_of_the_stimulus() {
        let square = |t: f64| if t.rem_euclid(0.5) < 0.25 { 100.0 } else { 0.0 };
        let sine = |t: f64| 50.0 - 50.0 * (TAU * 2.0 * t).cos();
        for change in [-0.4, 0.3] {
            for effect in [stroke(change, square).effect, stroke(change, sine).effect] {
                let effect = effect.unwrap();
                assert_relative_eq!(effect.mu_at_least, 0.8, epsilon = 1e-3);
                assert_relative_eq!(effect.contrast, -change / 0.8, epsilon = 2e-3);
                assert_relative_eq!(effect.lag_s, 0.03, epsilon = 1e-3);
                assert!(effect.r2 > 0.99, "{effect:?}");
            }
        }
    }

    #[test]
    fn a_stroke_without_a_stimulus_has_its_mean_alone() {
        let stroke = stroke(0.0, |_| 0.0);
        assert_eq!((stroke.n, stroke.effect), (2000, None));
        assert_relative_eq!(stroke.mu, 0.8, epsilon = 1e-12);
        assert_relative_eq!(stroke.mu_std, 0.0, epsilon = 1e-12);
        assert_relative_eq!(stroke.speed_m_per_s, 0.04, epsilon = 1e-12);
        assert!(stroke.amplitude_m.is_nan());
    }
}
