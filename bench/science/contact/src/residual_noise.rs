//! Noise and model error in the residuals of an impedance.
//!
//! Real and imaginary part of residual i are independent and normal with variance v_i = a + b q_i, where q_i = s_i²/⟨s²⟩ is the
//! squared shape and a = floor², b = scale² ⟨s²⟩ are unknown. With y_i = |r_i|²/2 the likelihood and its score are
//! ```text
//!  −ln L = Σ (ln v_i + y_i/v_i),    −∂ln L/∂a = Σ (v_i − y_i)/v_i²,    −∂ln L/∂b = Σ q_i (v_i − y_i)/v_i²
//! ```
//! so the maximum is the weighted least-squares line of y on q with the weights 1/v_i² at the maximum. Iterating the
//! weights is Fisher scoring, because ⟨y_i⟩ = v_i. A fit of p real parameters takes up p of the 2n degrees of freedom;
//! y_i = |r_i|² n/(2n − p) corrects for it. Neither a nor b may be negative: one that would be is 0, and the other is fitted
//! alone.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Standard deviation of one component of a residual: √(floor² + (scale·shape)²). The shape describes the noise of each
/// sample (white noise of force and velocity varies as 1/|ṽ_p|); the floor is the model's own error, equal for all samples.
/// Without the floor, a model error of 0.1 % of Z_m would be taken for noise that hides the smallest amplitudes, on which σ_t
/// and Z_t depend.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualNoise {
    /// Model error, equal for all samples, N·s/m.
    pub floor: f64,
    /// Noise, N·s/m per unit of the shape.
    pub scale: f64,
}

const ITERATIONS: usize = 50;
/// Smallest variance relative to the mean, so that no sample has all the weight.
const LEAST_VARIANCE: f64 = 1e-9;
/// Relative spread of the shapes below which floor and scale cannot be separated.
const LEAST_SPREAD: f64 = 1e-6;

impl ResidualNoise {
    /// Returns the standard deviation of one component of a residual with the given shape.
    pub fn std(&self, shape: f64) -> f64 {
        self.floor.hypot(self.scale * shape)
    }

    /// Estimates both by maximum likelihood of normal residuals (Fisher scoring: weighted least squares of the squares
    /// on 1 and shape²), after a fit of the given number of real `parameters`.
    pub fn from_residuals(residuals: &[Complex64], shapes: &[f64], parameters: usize) -> Self {
        let n = residuals.len() as f64;
        let freedom = (2.0 * n - parameters as f64).max(1.0);
        let squares: Vec<f64> = residuals
            .iter()
            .map(|r| r.norm_sqr() * n / freedom)
            .collect();
        let mean_square = squares.iter().sum::<f64>() / n;
        let mean_shape2 = shapes.iter().map(|s| s * s).sum::<f64>() / n;
        if !(mean_square > 0.0 && mean_shape2 > 0.0) {
            return Self::default();
        }
        let shapes2: Vec<f64> = shapes.iter().map(|s| s * s / mean_shape2).collect();
        let (mut floor2, mut scale2) = (mean_square / 2.0, mean_square / 2.0);
        for _ in 0..ITERATIONS {
            let [mut w, mut wq, mut wqq, mut wy, mut wqy] = [0.0; 5];
            for (&y, &q) in squares.iter().zip(&shapes2) {
                let variance = (floor2 + scale2 * q).max(LEAST_VARIANCE * mean_square);
                let weight = variance.powi(-2);
                w += weight;
                wq += weight * q;
                wqq += weight * q * q;
                wy += weight * y;
                wqy += weight * q * y;
            }
            // Normal equations with weights w = 1/v²: a Σw + b Σwq = Σwy, a Σwq + b Σwq² = Σwqy.
            let determinant = w * wqq - wq * wq;
            (floor2, scale2) = if determinant < LEAST_SPREAD * w * wqq {
                (wy / w, 0.0)
            } else {
                let floor2 = (wqq * wy - wq * wqy) / determinant;
                let scale2 = (w * wqy - wq * wy) / determinant;
                if floor2 < 0.0 {
                    (0.0, wqy / wqq)
                } else if scale2 < 0.0 {
                    (wy / w, 0.0)
                } else {
                    (floor2, scale2)
                }
            };
        }
        Self {
            floor: floor2.sqrt(),
            scale: (scale2 / mean_shape2).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Shapes over the amplitudes of a rising stretch, 50 nm to 3 µm.
    fn shapes(n: usize) -> Vec<f64> {
        let last = (n - 1) as f64;
        (0..n)
            .map(|i| (50e-9 * 60f64.powf(i as f64 / last)).recip())
            .collect()
    }

    fn residuals(truth: ResidualNoise, shapes: &[f64], seed: u64) -> Vec<Complex64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        shapes
            .iter()
            .map(|&shape| truth.std(shape) * Complex64::new(normal(), normal()))
            .collect()
    }

    #[test]
    fn both_parts_are_found() {
        let shapes = shapes(4000);
        for (floor, scale) in [(0.02, 3e-9), (0.1, 2e-8), (0.001, 2e-9)] {
            let truth = ResidualNoise { floor, scale };
            let estimate = ResidualNoise::from_residuals(&residuals(truth, &shapes, 7), &shapes, 0);
            assert_relative_eq!(estimate.floor, floor, max_relative = 0.1);
            assert_relative_eq!(estimate.scale, scale, max_relative = 0.1);
        }
    }

    #[test]
    fn a_part_that_is_not_there_is_near_nothing() {
        let shapes = shapes(120);
        for seed in 0..20 {
            let noise = ResidualNoise {
                floor: 0.0,
                scale: 1e-9,
            };
            let estimate =
                ResidualNoise::from_residuals(&residuals(noise, &shapes, seed), &shapes, 4);
            assert_relative_eq!(estimate.std(1e7), noise.std(1e7), max_relative = 0.25);
            let error = ResidualNoise {
                floor: 0.02,
                scale: 0.0,
            };
            let estimate =
                ResidualNoise::from_residuals(&residuals(error, &shapes, seed), &shapes, 4);
            assert_relative_eq!(estimate.std(1e6), error.std(1e6), max_relative = 0.25);
        }
    }

    #[test]
    fn of_samples_that_are_alike_it_is_their_deviation() {
        let residuals = [Complex64::new(0.3, -0.1), Complex64::new(-0.2, 0.4)];
        let estimate = ResidualNoise::from_residuals(&residuals, &[1.0; 2], 0);
        assert_relative_eq!(estimate.floor, (0.3f64 / 4.0).sqrt(), max_relative = 1e-12);
        assert_eq!(estimate.scale, 0.0);
        let zeros = [Complex64::ZERO; 9];
        assert_eq!(
            ResidualNoise::from_residuals(&zeros, &[1.0; 9], 4),
            ResidualNoise::default()
        );
    }
}
