#![doc = include_str!("README.md")]

use nalgebra::{Matrix3, Vector2, Vector3};

/// Smallest fraction of a deviation assumed to remain at the next stretch: the rate of a faster decay cannot be determined.
const MIN_REMAINDER: f64 = 1.0 / std::f64::consts::E;

/// Mean over a stretch.
#[derive(Debug, Clone, Copy)]
pub struct Mean {
    /// Value, in the quantity's unit.
    pub value: f64,
    /// Variance of its measurement error, in the square of that unit.
    pub variance: f64,
}

/// Means over stretches of a positive quantity; its logarithm performs a random walk.
#[derive(Debug, Clone, Copy)]
pub struct Means<'a> {
    /// Time of the middle of each stretch, s.
    pub times_s: &'a [f64],
    /// Length of a stretch, s.
    pub stretch_s: f64,
    /// Largest distance between successive stretches of one walk, s.
    pub max_gap_s: f64,
    /// Each mean.
    pub values: &'a [Mean],
    /// Relative rate of the steady trend about each stretch, 1/s; the walk is the deviation from it.
    pub per_s: &'a [f64],
}

impl Means<'_> {
    /// Returns the variance of the logarithm that the walk adds per second within a stretch, 1/s.
    ///
    /// A quantity that returns to its mean moves faster within a stretch than between stretches: the variance over two steps is
    /// then less than twice that over one (Uhlenbeck & Ornstein 1930). If a fraction ρ of a deviation of variance s² remains
    /// after a step Δ, k steps have the variance 2 s² (1 − ρ^k): the ratio of two steps to one is 1 + ρ. Within a stretch the
    /// variance grows by 2 s² (−ln ρ)/Δ per second, −ln ρ/(1 − ρ) times the 2 s² (1 − ρ)/Δ of one step.
    #[must_use]
    pub fn diffusivity_per_s(&self) -> f64 {
        let (single_steps, double_steps) = (self.steps(1), self.steps(2));
        // The trend uses one of the steps.
        if single_steps.count < 2.0 || single_steps.squares <= 0.0 {
            return 0.0;
        }
        let mean = |sums: &Steps| sums.squares / sums.count;
        let remainder = if double_steps.count > 0.0 {
            (mean(&double_steps) / mean(&single_steps) - 1.0).clamp(MIN_REMAINDER, 1.0)
        } else {
            1.0
        };
        let speedup = if remainder < 1.0 {
            -remainder.ln() / (1.0 - remainder)
        } else {
            1.0
        };
        // Means over two stretches of a walk differ less than the points at their middles. For stretches of length L with
        // middles Δ ≥ L apart, a mean differs from the walk at an end of its stretch by ∫₀ᴸ (s/L) dw, of variance D L/3, and
        // the walk between the stretches adds D (Δ − L): in all D (Δ − L/3).
        let duration_s = single_steps.time_s
            - single_steps.count * self.stretch_s.min(single_steps.time_s / single_steps.count)
                / 3.0;
        single_steps.squares / duration_s * single_steps.count / (single_steps.count - 1.0)
            * speedup
    }

    /// Returns sums over all increments of `steps` samples.
    fn steps(&self, steps: usize) -> Steps {
        let mut sums = Steps::default();
        for (index, window) in self.times_s.windows(steps + 1).enumerate() {
            if window
                .windows(2)
                .any(|pair| pair[1] - pair[0] > self.max_gap_s)
            {
                continue;
            }
            let (last, duration_s) = (index + steps, window[steps] - window[0]);
            let (first, last_mean) = (self.values[index], self.values[last]);
            let (a, b) = (first.value, last_mean.value);
            let drift = 0.5 * (self.per_s[index] + self.per_s[last]) * duration_s;
            // Var ln a ≈ Var a/a²; independent errors of both ends add to the squared increment.
            let noise = first.variance / (a * a) + last_mean.variance / (b * b);
            sums.squares += ((b / a).ln() - drift).powi(2) - noise;
            sums.time_s += duration_s;
            sums.count += 1.0;
        }
        sums
    }
}

/// Sums over increments of the logarithm relative to the trend.
#[derive(Default)]
struct Steps {
    count: f64,
    time_s: f64,
    /// Sum of the squared increments minus the variance of the measurement.
    squares: f64,
}

/// Returns the covariance, for a walk of diffusivity 1 per sample, of three weighted sums over it: one with the weights
/// `single`, and two with the weights `pair`.
#[must_use]
pub fn spread(single: &[f64], pair: &[Vector2<f64>]) -> Matrix3<f64> {
    // A walk w_n = Σ_(m≤n) e_m with Var e_m = 1 has Σ_n c_n w_n = Σ_m e_m Σ_(n≥m) c_n: an increment persists in all later
    // samples. With the tail sums t_m = Σ_(n≥m) c_n of all three weights, the covariance is Σ_m t_m t_mᵀ.
    let (mut tail, mut sum) = (Vector3::zeros(), Matrix3::zeros());
    for (weight, pair) in single.iter().zip(pair).rev() {
        tail += Vector3::new(*weight, pair[0], pair[1]);
        sum += tail * tail.transpose();
    }
    sum
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    fn diffusivity_per_s(times_s: &[f64], stretch_s: f64, values: &[(f64, f64)], rate: f64) -> f64 {
        let mean = |&(value, variance): &(f64, f64)| Mean { value, variance };
        let means = Means {
            times_s,
            stretch_s,
            max_gap_s: 0.7,
            values: &values.iter().map(mean).collect::<Vec<_>>(),
            per_s: &vec![rate; times_s.len()],
        };
        means.diffusivity_per_s()
    }

    #[test]
    fn the_diffusivity_of_a_walk_is_found_with_its_rate_and_noise() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let times_s: Vec<f64> = (0..4000).map(|n| 0.2 * f64::from(n)).collect();
        let (rate, noise) = (1e-5, 2e-3);
        for diffusivity in [0.0_f64, 1e-4] {
            let mut ln_mu0 = 0.0;
            let mu0: Vec<(f64, f64)> = times_s
                .iter()
                .map(|_| {
                    ln_mu0 += 0.2 * rate + (0.2 * diffusivity).sqrt() * normal();
                    let reading = (ln_mu0 + noise * normal()).exp();
                    (reading, (noise * reading).powi(2))
                })
                .collect();
            let estimate = diffusivity_per_s(&times_s, 0.0, &mu0, rate);
            assert!(
                (estimate - diffusivity).abs() < 1e-5,
                "{estimate} {diffusivity}"
            );
        }
    }

    #[test]
    fn means_over_a_walk_show_its_diffusivity() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let (diffusivity, step_s) = (1e-4_f64, 1e-3);
        let mut ln_mu0 = 0.0_f64;
        let (mut times_s, mut mu0) = (Vec::new(), Vec::new());
        for instance in 0..6000 {
            let mut sum = 0.0;
            for sample in 0..150 {
                let innovation: f64 = StandardNormal.sample(&mut random);
                ln_mu0 += (diffusivity * step_s).sqrt() * innovation;
                sum += if sample < 100 { ln_mu0 } else { 0.0 };
            }
            times_s.push(0.15 * f64::from(instance));
            mu0.push(((sum / 100.0).exp(), 0.0));
        }
        let estimate = diffusivity_per_s(&times_s, 0.1, &mu0, 0.0);
        assert_relative_eq!(estimate, diffusivity, max_relative = 0.06);
    }

    /// The steps of a deviation that keeps a fraction `remainder` after each step have 2 (1 − remainder) times its variance.
    #[test]
    fn a_walk_that_returns_to_its_mean_is_faster() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (remainder, std, step_s) = (0.6_f64, 3e-3, 0.17);
        let mut deviation = 0.0;
        let (mut times_s, mut mu0) = (Vec::new(), Vec::new());
        for instance in 0..20_000 {
            let innovation: f64 = StandardNormal.sample(&mut random);
            deviation =
                remainder * deviation + std * (1.0 - remainder * remainder).sqrt() * innovation;
            times_s.push(step_s * f64::from(instance));
            mu0.push((f64::exp(deviation), 0.0));
        }
        let estimate = diffusivity_per_s(&times_s, 0.0, &mu0, 0.0);
        let expected = 2.0 * std * std * -remainder.ln() / step_s;
        assert_relative_eq!(estimate, expected, max_relative = 0.05);
    }

    #[test]
    fn two_instances_show_no_walk() {
        let pair = diffusivity_per_s(&[0.0, 0.2], 0.0, &[(0.5, 0.0), (0.6, 0.0)], 0.0);
        assert_eq!(pair, 0.0);
        let sparse = diffusivity_per_s(
            &[0.0, 2.0, 4.0],
            0.0,
            &[(0.5, 0.0), (0.6, 0.0), (0.7, 0.0)],
            0.0,
        );
        assert_eq!(sparse, 0.0);
    }

    /// Compares with the covariance of a walk, which for two samples equals the time until the first.
    #[test]
    fn the_spread_is_that_of_weighted_sums_over_a_walk() {
        let mu0_weights: Vec<f64> = (0..30).map(|n| (0.4 * f64::from(n)).sin()).collect();
        let trial_weights: Vec<Vector2<f64>> = (0..30)
            .map(|n| Vector2::new(0.1 * f64::from(n) - 1.0, (0.2 * f64::from(n)).cos()))
            .collect();
        let covariance = spread(&mu0_weights, &trial_weights);
        let weights = |n: usize| [mu0_weights[n], trial_weights[n][0], trial_weights[n][1]];
        for row in 0..3 {
            for column in 0..3 {
                let mut sum = 0.0;
                for a in 0..30 {
                    for b in 0..30 {
                        sum += weights(a)[row] * weights(b)[column] * (a.min(b) + 1) as f64;
                    }
                }
                assert_relative_eq!(covariance[(row, column)], sum, max_relative = 1e-9);
            }
        }
    }
}
