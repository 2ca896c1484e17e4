//! How far friction wanders while an instance lasts, by how it does from instance to instance: a random walk, as a skin that slides
//! into and out of moisture makes it.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::fit::trend::NEIGHBOURS_S;

/// Least part of a departure that is taken to be left at the next instance: what forgets sooner does not show how fast it was.
const LEAST_LEFT: f64 = 1.0 / std::f64::consts::E;

/// Returns the variance of ln μ0 that a second of wandering adds within an instance, 1/s, from μ0 of instances beside a steady change
/// at relative rates `per_s`, each a mean over `each_s` with the variance that its measurement has by itself.
///
/// Friction that returns to its mean wanders faster within an instance than from one to the next: two steps are then less than twice one
/// (Uhlenbeck & Ornstein 1930).
pub(super) fn diffusivity_per_s(
    times_s: &[f64],
    each_s: f64,
    mu0: &[(f64, f64)],
    per_s: &[f64],
) -> f64 {
    let of = |steps: usize| Steps::over(steps, times_s, mu0, per_s);
    let (one, two) = (of(1), of(2));
    // A rate took one of the steps.
    if one.count < 2.0 || one.squares <= 0.0 {
        return 0.0;
    }
    let mean = |of: &Steps| of.squares / of.count;
    let left = if two.count > 0.0 {
        (mean(&two) / mean(&one) - 1.0).clamp(LEAST_LEFT, 1.0)
    } else {
        1.0
    };
    let faster = if left < 1.0 {
        -left.ln() / (1.0 - left)
    } else {
        1.0
    };
    // Two means over a walk are nearer to each other than two of its points.
    let lasted_s = one.time_s - one.count * each_s.min(one.time_s / one.count) / 3.0;
    one.squares / lasted_s * one.count / (one.count - 1.0) * faster
}

/// Steps of ln μ0 between instances of one exploration, beside a steady change.
struct Steps {
    count: f64,
    time_s: f64,
    /// Of the steps, less what measurement makes of them.
    squares: f64,
}

impl Steps {
    fn over(steps: usize, times_s: &[f64], mu0: &[(f64, f64)], per_s: &[f64]) -> Self {
        let (mut count, mut time_s, mut squares) = (0.0, 0.0, 0.0);
        for (index, near) in times_s.windows(steps + 1).enumerate() {
            if near.windows(2).any(|pair| pair[1] - pair[0] > NEIGHBOURS_S) {
                continue;
            }
            let (last, lasted_s) = (index + steps, near[steps] - near[0]);
            let ((a, of_a), (b, of_b)) = (mu0[index], mu0[last]);
            let steady = 0.5 * (per_s[index] + per_s[last]) * lasted_s;
            let measured = of_a / (a * a) + of_b / (b * b);
            squares += ((b / a).ln() - steady).powi(2) - measured;
            time_s += lasted_s;
            count += 1.0;
        }
        Self {
            count,
            time_s,
            squares,
        }
    }
}

/// Returns the covariance, for a walk of diffusivity 1 per sample, of the weighted sums over it: of μ0 that a fit with the weights
/// `of_mu0` finds beside the mean, and of φ and the lag.
pub(super) fn spread(of_mu0: &[f64], of_trial: &[Vector2<f64>]) -> Matrix3<f64> {
    // What comes at a sample stays for all after it.
    let (mut after, mut sum) = (Vector3::zeros(), Matrix3::zeros());
    for (mu0, trial) in of_mu0.iter().zip(of_trial).rev() {
        after += Vector3::new(*mu0, trial[0], trial[1]);
        sum += after * after.transpose();
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

    #[test]
    fn the_diffusivity_of_a_walk_is_found_beside_its_rate_and_noise() {
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
                    let measured = (ln_mu0 + noise * normal()).exp();
                    (measured, (noise * measured).powi(2))
                })
                .collect();
            let per_s = vec![rate; times_s.len()];
            let found = diffusivity_per_s(&times_s, 0.0, &mu0, &per_s);
            assert!((found - diffusivity).abs() < 1e-5, "{found} {diffusivity}");
        }
    }

    #[test]
    fn means_over_a_walk_show_all_of_it() {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let (diffusivity, step_s) = (1e-4_f64, 1e-3);
        let mut ln_mu0 = 0.0_f64;
        let (mut times_s, mut mu0) = (Vec::new(), Vec::new());
        for instance in 0..6000 {
            let mut sum = 0.0;
            for sample in 0..150 {
                let news: f64 = StandardNormal.sample(&mut random);
                ln_mu0 += (diffusivity * step_s).sqrt() * news;
                sum += if sample < 100 { ln_mu0 } else { 0.0 };
            }
            times_s.push(0.15 * f64::from(instance));
            mu0.push(((sum / 100.0).exp(), 0.0));
        }
        let per_s = vec![0.0; times_s.len()];
        let found = diffusivity_per_s(&times_s, 0.1, &mu0, &per_s);
        assert_relative_eq!(found, diffusivity, max_relative = 0.06);
    }

    /// A departure of which a part of `left` is left after each step has 2 (1 − left) of its variance in a step.
    #[test]
    fn what_returns_to_its_mean_wandered_faster() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let (left, std, step_s) = (0.6_f64, 3e-3, 0.17);
        let mut departure = 0.0;
        let (mut times_s, mut mu0) = (Vec::new(), Vec::new());
        for instance in 0..20_000 {
            let news: f64 = StandardNormal.sample(&mut random);
            departure = left * departure + std * (1.0 - left * left).sqrt() * news;
            times_s.push(step_s * f64::from(instance));
            mu0.push((f64::exp(departure), 0.0));
        }
        let found = diffusivity_per_s(&times_s, 0.0, &mu0, &vec![0.0; times_s.len()]);
        let at_once = 2.0 * std * std * -left.ln() / step_s;
        assert_relative_eq!(found, at_once, max_relative = 0.05);
    }

    #[test]
    fn two_instances_show_no_walk() {
        let found = diffusivity_per_s(&[0.0, 0.2], 0.0, &[(0.5, 0.0), (0.6, 0.0)], &[0.0; 2]);
        assert_eq!(found, 0.0);
        let apart = diffusivity_per_s(
            &[0.0, 2.0, 4.0],
            0.0,
            &[(0.5, 0.0), (0.6, 0.0), (0.7, 0.0)],
            &[0.0; 3],
        );
        assert_eq!(apart, 0.0);
    }

    /// Against the covariance of a walk: that of two samples is the time until the first.
    #[test]
    fn the_spread_is_that_of_weighted_sums_over_a_walk() {
        let of_mu0: Vec<f64> = (0..30).map(|n| (0.4 * f64::from(n)).sin()).collect();
        let of_trial: Vec<Vector2<f64>> = (0..30)
            .map(|n| Vector2::new(0.1 * f64::from(n) - 1.0, (0.2 * f64::from(n)).cos()))
            .collect();
        let found = spread(&of_mu0, &of_trial);
        let weights = |n: usize| [of_mu0[n], of_trial[n][0], of_trial[n][1]];
        for row in 0..3 {
            for column in 0..3 {
                let mut sum = 0.0;
                for a in 0..30 {
                    for b in 0..30 {
                        sum += weights(a)[row] * weights(b)[column] * (a.min(b) + 1) as f64;
                    }
                }
                assert_relative_eq!(found[(row, column)], sum, max_relative = 1e-9);
            }
        }
    }
}
