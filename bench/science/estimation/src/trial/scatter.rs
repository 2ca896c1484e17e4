//! Scatter and correlation of the residuals of an instance.
//!
//! Three sources contribute: noise of force and velocity, which grows as 1/|ṽ_p| in their ratio; the model's own error, equal
//! for all samples; and the error of the force sensor's filter, which leaves some noise and removes some of the finger's force.
//! The last one moves the gap for as long as it lasts plus the lag, so that many samples share it. Least squares without this
//! correlation would attribute it to the skin.
//!
//! ```text
//! V = v_f G K_f Gᵀ + D K_n D (real parts) + D K_n D (imaginary parts)
//! K(t, t′) = e^(−|t − t′|/c),  c = 0.8 ms for K_f and 1.5 ms for K_n
//! D² = v_c + v_n/|x̃_p|²
//! ```
//!
//! with G = ∂Z_m/∂ ln f_n of all samples of the force, lead-in included. The diagonal of V is
//! v_c + v_n/|x̃_p|² + v_f (G K_f Gᵀ)_jj; its three variances follow from the squared residuals of the last minimum, for the
//! whole trial.

use arrowhead::{Whitening, exponential_correlation, variance_components};
use nalgebra::DMatrix;
use num_complex::Complex64;

use super::members::Member;
use crate::least_squares::ImpedanceModel;

/// Correlation time of force errors, s. The force's filter has errors about 80 Hz and none far below. A correlation time of
/// 1/(2π 80 Hz) = 2 ms would give all lower frequencies full error power too, and underweight their information about the skin
/// (decision 21).
const FORCE_CORRELATION_S: f64 = 8e-4;
/// Correlation time of impedance errors, s: between the demodulator's window and the milliseconds of effects that the model
/// leaves out.
const NOISE_CORRELATION_S: f64 = 1.5e-3;
/// Smallest relative error of the force that is assumed: no sensor is better.
const MIN_FORCE_ERROR: f64 = 1e-4;
/// Largest number of samples of an instance, lead-in included, that are weighted with their correlation. The time grows with
/// the third power of the number; an instance of the published length has 160.
const MAX_CORRELATED_SAMPLES: usize = 600;
/// Smallest variance relative to the mean, so that no sample has all the weight.
const MIN_VARIANCE: f64 = 1e-6;

/// Covariance of an instance's residuals, real parts first, then imaginary ones.
#[derive(Clone)]
pub(super) enum Scatter {
    /// Independent, with this standard deviation for all.
    Uniform(f64),
    /// Independent, with a standard deviation for each.
    Independent(Vec<f64>),
    /// Correlated.
    Correlated(Whitening),
}

impl Scatter {
    /// Estimates the scatter of each instance's residuals after a fit of so many parameters, with variances common to all
    /// instances. `None` where the residuals are 0.
    pub(super) fn estimate(
        residuals: &[Vec<Complex64>],
        kinds: &[Kinds],
        parameters: usize,
    ) -> Option<Vec<Self>> {
        let squares: Vec<f64> = residuals
            .iter()
            .flat_map(|residuals| {
                (0..2 * residuals.len()).map(|index| component(residuals, index).powi(2))
            })
            .collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        if mean <= 0.0 {
            return None;
        }
        let rows: Vec<[f64; 3]> = kinds.iter().flat_map(Kinds::rows).collect();
        // A fit of P parameters to N residuals leaves (N − P)/N of their variance.
        let freedom = squares.len().saturating_sub(parameters).max(1);
        let correction = squares.len() as f64 / freedom as f64;
        let components = variance_components(&squares, &rows, MIN_VARIANCE * mean)
            .map(|variance| variance * correction);
        kinds
            .iter()
            .map(|kinds| kinds.scatter(components, MIN_VARIANCE * mean))
            .collect()
    }

    /// Multiplies columns by the inverse factor of the covariance, which makes the residuals independent with unit variance.
    pub(super) fn whiten(&self, columns: &mut DMatrix<f64>) {
        match self {
            Self::Uniform(std) => *columns /= *std,
            Self::Independent(stds) => {
                for (mut row, std) in columns.row_iter_mut().zip(stds) {
                    row /= *std;
                }
            }
            Self::Correlated(whitening) => whitening.apply(columns),
        }
    }
}

/// Contributions of each kind of error to an instance's residuals.
pub(super) struct Kinds {
    interval_s: f64,
    /// Squared shape of the noise.
    shapes2: Vec<f64>,
    /// Covariance of the residuals for a unit error of the force; `None` for an instance of too many samples.
    by_force: Option<DMatrix<f64>>,
}

impl Kinds {
    /// Computes the contributions at the parameters of the model's last evaluation.
    pub(super) fn new(member: &Member<'_>) -> Self {
        let model = &member.model;
        let total = model.gap.len();
        let by_force = if total > MAX_CORRELATED_SAMPLES {
            None
        } else {
            let mut by_force = model.response_to_force();
            accumulate_errors(&mut by_force, FORCE_CORRELATION_S / model.interval_s);
            Some(&by_force * by_force.transpose())
        };
        Self {
            interval_s: model.interval_s,
            shapes2: (0..model.z_m.len())
                .map(|index| model.noise_shape(index).powi(2))
                .collect(),
            by_force,
        }
    }

    /// Returns the variance of each residual for a unit of each kind: constant, noise, force.
    fn rows(&self) -> impl Iterator<Item = [f64; 3]> {
        let n = self.shapes2.len();
        let force_variance = move |index: usize| {
            self.by_force
                .as_ref()
                .map_or(0.0, |covariance| covariance[(index, index)])
        };
        (0..2 * n).map(move |index| [1.0, self.shapes2[index % n], force_variance(index)])
    }

    fn scatter(&self, [constant, noise, force]: [f64; 3], min_variance: f64) -> Option<Scatter> {
        let n = self.shapes2.len();
        let stds: Vec<f64> = self
            .shapes2
            .iter()
            .map(|shape2| (constant + noise * shape2).max(min_variance).sqrt())
            .collect();
        let correlation_samples = NOISE_CORRELATION_S / self.interval_s;
        let Some(by_force) = &self.by_force else {
            // Samples that share a noise carry the information of only one. Slopes that change little within the correlation
            // time of c samples have 1 + 2 Σ_k e^(−k/c) = coth(1/(2c)) times the variance of independent noise.
            let widening = (0.5 / correlation_samples).tanh().recip().sqrt();
            let components = stds.iter().chain(&stds);
            return Some(Scatter::Independent(
                components.map(|std| std * widening).collect(),
            ));
        };
        let correlation = exponential_correlation(n, correlation_samples);
        let mut covariance = by_force * force.max(MIN_FORCE_ERROR * MIN_FORCE_ERROR);
        for row in 0..n {
            for column in 0..n {
                let noise_covariance = stds[row] * stds[column] * correlation[(row, column)];
                covariance[(row, column)] += noise_covariance;
                covariance[(n + row, n + column)] += noise_covariance;
            }
        }
        Whitening::from_covariance(&covariance).map(Scatter::Correlated)
    }
}

/// Multiplies a response to each sample by the lower factor of [`exponential_correlation`]: an error is the decayed
/// previous error plus an innovation, so the innovation of a sample acts on all later ones. For
/// e_n = ρ e_(n−1) + √(1 − ρ²) ε_n, e_0 = ε_0 and ρ = e^(−1/c), Cov e has the factor L_nm = ρ^(n−m) √(1 − ρ²) for
/// n ≥ m > 0, and L_n0 = ρ^n. Column m of G L is √(1 − ρ²) Σ_(n≥m) ρ^(n−m) G_n, summed from the last column backwards.
fn accumulate_errors(response: &mut DMatrix<f64>, intervals: f64) {
    let decay = (-intervals.recip()).exp();
    for sample in (1..response.ncols()).rev() {
        let carry = response.column(sample) * decay;
        let mut previous = response.column_mut(sample - 1);
        previous += carry;
    }
    let innovation = (1.0 - decay * decay).sqrt();
    let mut later_columns = response.columns_range_mut(1..);
    later_columns *= innovation;
}

/// Returns the real part of a sample's residual, or the imaginary part for an index in the second half.
fn component(residuals: &[Complex64], index: usize) -> f64 {
    match residuals.get(index) {
        Some(residual) => residual.re,
        None => residuals[index - residuals.len()].im,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression test: standard deviations of instances of more than 600 samples were up to 7 % too large.
    #[test]
    fn independent_samples_are_widened_by_the_sum_of_their_correlations() {
        for interval_s in [5e-4, 1e-4] {
            let kinds = Kinds {
                interval_s,
                shapes2: vec![1.0; 3],
                by_force: None,
            };
            let Some(Scatter::Independent(stds)) = kinds.scatter([1.0, 0.0, 0.0], 1e-9) else {
                panic!("correlated without a response to the force");
            };
            let correlation = exponential_correlation(801, NOISE_CORRELATION_S / interval_s);
            let variance = correlation.row(400).sum();
            assert!(
                stds.iter()
                    .all(|std| (std.powi(2) / variance - 1.0).abs() < 1e-9)
            );
        }
    }

    #[test]
    fn accumulated_errors_have_the_covariance_of_their_decay() {
        let mut factor = DMatrix::identity(30, 30);
        accumulate_errors(&mut factor, 4.0);
        let difference = &factor * factor.transpose() - exponential_correlation(30, 4.0);
        assert!(difference.amax() < 1e-12);
    }
}
