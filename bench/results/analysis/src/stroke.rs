//! Friction of a stroke: its mean, and its contrast and lag under a stimulus.

pub use contact::stimulus_effect::StimulusEffect;
use contact::stimulus_effect::stimulus_effect;
use protocols::Direction;
use serde::{Deserialize, Serialize};

use crate::exploration_series::ExplorationSeries;

/// Friction of a stroke.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stroke {
    /// Direction.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Number of samples at which the finger presses.
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

impl Stroke {
    /// Returns the friction of an exploration where the finger presses with `least_n` or more, N: below, a zero of the force sensor
    /// that is a little off makes any friction.
    #[must_use]
    pub fn new(
        exploration: &ExplorationSeries,
        direction: Direction,
        (start_s, end_s): (f64, f64),
        least_n: f64,
    ) -> Self {
        let is_pressed = |index: usize| exploration.normal_n[index] >= least_n;
        let mu = exploration.mu.iter().enumerate();
        let mu_at = |(index, mu): (usize, &f64)| if is_pressed(index) { *mu } else { f64::NAN };
        let pressed_mu: Vec<f64> = mu.map(mu_at).collect();
        let is_known = |index: &usize| pressed_mu[*index].is_finite();
        let known: Vec<usize> = (0..pressed_mu.len()).filter(is_known).collect();
        let mean_of = |values: &[f64]| mean(known.iter().map(|index| values[*index]));
        let mu = mean_of(&pressed_mu);
        let squares = known.iter().map(|index| (pressed_mu[*index] - mu).powi(2));
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
            effect: stimulus_effect(&exploration.time_s, &pressed_mu, &exploration.stimulus),
        }
    }
}

/// Returns the mean; NaN without values.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
    sum / n
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::measurements::ForceSeries;

    /// Returns a stroke of 4 s at 500 Hz with a friction of 0.8, in which the finger lifts off for the last second.
    fn stroke(least_n: f64) -> Stroke {
        let time_s: Vec<f64> = (0..2000).map(|n| f64::from(n) / 500.0).collect();
        let normal_n = time_s.iter().map(|t| if *t < 3.0 { 0.5 } else { 1e-3 });
        let normal_n: Vec<f64> = normal_n.collect();
        // A zero that is 2 mN off.
        let lateral_n = normal_n.iter().map(|normal_n| -0.8 * normal_n - 2e-3);
        let series = ForceSeries {
            lateral_n: lateral_n.collect(),
            normal_n,
            position_m: vec![f64::NAN; 2000],
            velocity_m_per_s: vec![-0.04; 2000],
            stimulus: vec![f64::NAN; 2000],
            time_s,
        };
        let exploration = ExplorationSeries::from_forces(series);
        Stroke::new(&exploration, Direction::RightToLeft, (0.0, 4.0), least_n)
    }

    #[test]
    fn the_friction_of_a_stroke_is_that_of_a_finger_that_presses() {
        let pressed = stroke(0.05);
        assert_eq!((pressed.n, pressed.effect), (1500, None));
        assert_relative_eq!(pressed.mu, 0.804, epsilon = 1e-12);
        assert_relative_eq!(pressed.mu_std, 0.0, epsilon = 1e-12);
        assert_relative_eq!(pressed.normal_n, 0.5, epsilon = 1e-12);
        assert_relative_eq!(pressed.speed_m_per_s, 0.04, epsilon = 1e-12);
        assert!(pressed.amplitude_m.is_nan());
        assert_eq!(stroke(0.0).n, 2000);
    }
}
