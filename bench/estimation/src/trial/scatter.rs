//! How the residuals of an instance scatter, and with each other.
//!
//! Three things make them: noise of force and velocity, which on their ratio grows as 1/|ṽ_p|; the model's
//! own error, alike for all; and what the force sensor's filter left of its noise and took of the finger's force. The last one
//! moves the gap for as long as it lasts and its lag, so that many samples share it: least squares that knew nothing of it would
//! take it for a property of the skin.

use arrowhead::{Whitening, lasting, variance_components};
use nalgebra::DMatrix;
use num_complex::Complex64;

use super::members::{Member, OWN, SHARED};
use crate::least_squares::ImpedanceModel;

/// Time for which an error of the force lasts, s. The force's filter is wrong about 80 Hz and right far below. An error that decays
/// in 1/(2π 80 Hz) = 2 ms has full power at all lower frequencies too, and what the force tells of the skin there would count too
/// little (decision 21).
const FORCE_ERROR_LASTS_S: f64 = 8e-4;
/// Time for which an error of the impedance lasts, s: between the demodulator's window and the milliseconds of what the model leaves
/// out.
const NOISE_LASTS_S: f64 = 1.5e-3;
/// Error of the force that is always reckoned with, as a part of it: no sensor is better.
const LEAST_FORCE_ERROR: f64 = 1e-4;
/// Most samples of an instance, with its lead-in, that are weighed together: time goes with their third power, and an instance of
/// the published length has 160.
const MOST_TOGETHER: usize = 600;
/// A variance below this part of the mean is taken for it, so that no sample has all the weight.
const LEAST_VARIANCE: f64 = 1e-6;

/// Covariance of an instance's residuals, real parts first, then imaginary ones.
#[derive(Clone)]
pub(super) enum Scatter {
    /// Independent and alike, with this standard deviation.
    Alike(f64),
    /// Independent, each of its own standard deviation.
    Apart(Vec<f64>),
    /// Together.
    Together(Whitening),
}

impl Scatter {
    /// Estimates the scatter of each instance's residuals, of one kind for all. `None` where the residuals are 0.
    pub(super) fn of_all(residuals: &[Vec<Complex64>], kinds: &[Kinds]) -> Option<Vec<Self>> {
        let squares: Vec<f64> = residuals
            .iter()
            .flat_map(|of| (0..2 * of.len()).map(|at| part(of, at).powi(2)))
            .collect();
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        if mean <= 0.0 {
            return None;
        }
        let of_rows: Vec<[f64; 3]> = kinds.iter().flat_map(Kinds::rows).collect();
        let freedom = squares
            .len()
            .saturating_sub(SHARED + OWN * kinds.len())
            .max(1);
        let of_freedom = squares.len() as f64 / freedom as f64;
        let components = variance_components(&squares, &of_rows, LEAST_VARIANCE * mean)
            .map(|of| of * of_freedom);
        kinds
            .iter()
            .map(|kinds| kinds.scatter(components, LEAST_VARIANCE * mean))
            .collect()
    }

    /// Multiplies columns by the inverse of the factor: what had this scatter is then independent and of variance 1.
    pub(super) fn whiten(&self, columns: &mut DMatrix<f64>) {
        match self {
            Self::Alike(std) => *columns /= *std,
            Self::Apart(stds) => {
                for (mut row, std) in columns.row_iter_mut().zip(stds) {
                    row /= *std;
                }
            }
            Self::Together(whitening) => whitening.apply(columns),
        }
    }
}

/// What each kind of error would make of an instance's residuals.
pub(super) struct Kinds {
    interval_s: f64,
    /// Squares of the shape of noise.
    shapes2: Vec<f64>,
    /// Covariance of the residuals for an error of the force of its own size; `None` of an instance of too many samples.
    by_force: Option<DMatrix<f64>>,
}

impl Kinds {
    /// Takes them at the parameters at which the model was evaluated last.
    pub(super) fn of(member: &Member<'_>) -> Self {
        let model = &member.model;
        let all = model.gap.len();
        let by_force = if all > MOST_TOGETHER {
            None
        } else {
            let mut by_force = model.response_to_force();
            by_errors_that_last(&mut by_force, FORCE_ERROR_LASTS_S / model.interval_s);
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

    /// Returns the variance of each residual for each kind of its own size: alike for all, noise, force.
    fn rows(&self) -> impl Iterator<Item = [f64; 3]> {
        let n = self.shapes2.len();
        let of_force = move |at: usize| self.by_force.as_ref().map_or(0.0, |of| of[(at, at)]);
        (0..2 * n).map(move |at| [1.0, self.shapes2[at % n], of_force(at)])
    }

    fn scatter(&self, [alike, noise, of_force]: [f64; 3], least: f64) -> Option<Scatter> {
        let n = self.shapes2.len();
        let stds: Vec<f64> = self
            .shapes2
            .iter()
            .map(|shape2| (alike + noise * shape2).max(least).sqrt())
            .collect();
        let samples_alike = NOISE_LASTS_S / self.interval_s;
        let Some(by_force) = &self.by_force else {
            // As many samples as share a noise tell no more than one.
            let widened = (1.0 + 2.0 * samples_alike).sqrt();
            let both = stds.iter().chain(&stds);
            return Some(Scatter::Apart(both.map(|std| std * widened).collect()));
        };
        let together = lasting(n, samples_alike);
        let mut covariance = by_force * of_force.max(LEAST_FORCE_ERROR * LEAST_FORCE_ERROR);
        for row in 0..n {
            for column in 0..n {
                let of_noise = stds[row] * stds[column] * together[(row, column)];
                covariance[(row, column)] += of_noise;
                covariance[(n + row, n + column)] += of_noise;
            }
        }
        Whitening::of(&covariance).map(Scatter::Together)
    }
}

/// Multiplies a response to each sample by the lower factor of [`lasting`]: an error is what is left of the last one, and news,
/// so that news of a sample acts on all after it.
fn by_errors_that_last(response: &mut DMatrix<f64>, intervals: f64) {
    let left = (-intervals.recip()).exp();
    for sample in (1..response.ncols()).rev() {
        let later = response.column(sample) * left;
        let mut earlier = response.column_mut(sample - 1);
        earlier += later;
    }
    let news = (1.0 - left * left).sqrt();
    let mut after_first = response.columns_range_mut(1..);
    after_first *= news;
}

/// Returns the real part of a sample's residual, or the imaginary one of the second half.
fn part(residuals: &[Complex64], at: usize) -> f64 {
    match residuals.get(at) {
        Some(residual) => residual.re,
        None => residuals[at - residuals.len()].im,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_that_last_have_their_covariance() {
        let mut factor = DMatrix::identity(30, 30);
        by_errors_that_last(&mut factor, 4.0);
        let apart = &factor * factor.transpose() - lasting(30, 4.0);
        assert!(apart.amax() < 1e-12);
    }
}
