//! How far friction wanders while an instance lasts, by how it does from instance to instance: a random walk, as a skin that slides
//! into and out of moisture makes it.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::fit::trend::NEIGHBOURS_S;

/// Returns the variance of ln μ0 that a second of wandering adds, 1/s, from μ0 of instances beside a steady change at relative rates
/// `per_s`, each a mean over `each_s` with the variance that its measurement has by itself.
pub(super) fn diffusivity_per_s(
    times_s: &[f64],
    each_s: f64,
    mu0: &[(f64, f64)],
    per_s: &[f64],
) -> f64 {
    let (mut squares, mut time_s, mut steps) = (0.0, 0.0, 0.0);
    for (index, pair) in times_s.windows(2).enumerate() {
        let lasted_s = pair[1] - pair[0];
        if lasted_s <= NEIGHBOURS_S {
            let ((a, of_a), (b, of_b)) = (mu0[index], mu0[index + 1]);
            let steady = 0.5 * (per_s[index] + per_s[index + 1]) * lasted_s;
            let measured = of_a / (a * a) + of_b / (b * b);
            squares += ((b / a).ln() - steady).powi(2) - measured;
            // Two means over a walk are nearer to each other than two of its points.
            time_s += lasted_s - each_s.min(lasted_s) / 3.0;
            steps += 1.0;
        }
    }
    // A rate took one of the steps.
    if steps < 2.0 {
        return 0.0;
    }
    (squares / time_s * steps / (steps - 1.0)).max(0.0)
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
