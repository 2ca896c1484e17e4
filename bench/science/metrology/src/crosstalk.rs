//! Two crossed axes: the response of a two-axis sensor to known forces, by weighted least squares, and the matrix that turns
//! its readings back into forces.
//!
//! reading = response · force, each axis fitted separately: reading_k = A_k0 force_0 + A_k1 force_1 (Bevington &
//! Robinson 2003, chapter 7). The matrix is M = A⁻¹; to first order δM = −M δA M, so that each entry's error has one
//! part from each axis' scatter.

use nalgebra::{Matrix2, Vector2};

/// One known load and the change of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Known force on either axis, N.
    pub force_n: [f64; 2],
    /// Change of either reading, in the sensor's unit.
    pub reading: [f64; 2],
    /// Standard deviation of either change; only ratios matter where the scatter is larger.
    pub sigma: [f64; 2],
}

/// An entry of the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatrixEntry {
    /// Value of the entry, N per unit of reading.
    pub value: f64,
    /// Standard errors from the scatter of either axis' readings, N per unit of reading.
    pub errors: [f64; 2],
}

impl MatrixEntry {
    /// Returns the standard error from the scatter of both axes, N per unit of reading.
    #[must_use]
    pub fn standard_error(&self) -> f64 {
        self.errors[0].hypot(self.errors[1])
    }
}

/// The response of a two-axis force sensor, and its inverse.
///
/// ```
/// use metrology::crosstalk::{Crosstalk, Loading};
///
/// // A sensor of 2 units per newton on either axis, 1 % of either force read on the other.
/// let loadings = [[1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [0.0, 2.0]].map(|force_n: [f64; 2]| Loading {
///     force_n,
///     reading: [2.0 * force_n[0] + 0.02 * force_n[1], 0.02 * force_n[0] + 2.0 * force_n[1]],
///     sigma: [1e-3; 2],
/// });
/// let crosstalk = Crosstalk::fit(&loadings)?;
/// assert!((crosstalk.response[0][1] - 0.02).abs() < 1e-12);
/// assert!((crosstalk.matrix[0][0].value - 2.0 / (4.0 - 0.0004)).abs() < 1e-12);
/// # Ok::<(), metrology::crosstalk::CrosstalkError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Crosstalk {
    /// A: reading = A · force, in rows.
    pub response: [[f64; 2]; 2],
    /// M = A⁻¹: force = M · reading, in rows.
    pub matrix: [[MatrixEntry; 2]; 2],
    /// Known force minus M · reading of each loading, N.
    pub residuals_n: Vec<[f64; 2]>,
    /// Largest |residual| of either axis over its largest known force.
    pub nonlinearity: [f64; 2],
    /// √(χ²/(n − 2)) of either reading: the ratio of its scatter to its `sigma`. Errors are scaled by it where it is above
    /// 1.
    pub birge_ratio: [f64; 2],
    /// Degrees of freedom: number of loadings minus two.
    pub degrees_of_freedom: usize,
}

/// Reasons why loadings determine no matrix.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CrosstalkError {
    /// Fewer than three loadings.
    #[error("{count} loads determine no matrix with an error: at least 3 are needed")]
    TooFew {
        /// Number of loadings.
        count: usize,
    },
    /// All loads act along one direction.
    #[error("all loads act in one direction: load both axes")]
    OneDirection,
    /// The readings of both axes are the same up to a factor.
    #[error(
        "both axes read the same up to a factor: one of them is not connected, or both read one sensor"
    )]
    Singular,
    /// A value is not finite, or a deviation not positive.
    #[error("load {index} has a value that is not finite or a deviation that is not positive")]
    NotFinite {
        /// Index of the loading.
        index: usize,
    },
}

/// Determinant below which loadings along one direction, or readings along one line, determine no matrix.
const LEAST_DETERMINANT: f64 = 1e-6;

impl Crosstalk {
    /// Fits the response and inverts it. Errors come from the loadings' deviations, or from their scatter where that is
    /// larger.
    ///
    /// The interval by Student's t includes each true entry in 95 % of noisy draws (`intervals_hold_the_truth`).
    ///
    /// # Errors
    /// When the loadings determine no matrix.
    pub fn fit(loadings: &[Loading]) -> Result<Self, CrosstalkError> {
        let is_invalid = |l: &Loading| {
            let values = l.force_n.iter().chain(&l.reading).chain(&l.sigma);
            !values.copied().all(f64::is_finite) || l.sigma.iter().any(|sigma| *sigma <= 0.0)
        };
        if let Some(index) = loadings.iter().position(is_invalid) {
            return Err(CrosstalkError::NotFinite { index });
        }
        let count = loadings.len();
        if count < 3 {
            return Err(CrosstalkError::TooFew { count });
        }
        let degrees_of_freedom = count - 2;
        let rows = [0, 1].map(|axis| AxisResponse::fit(loadings, axis));
        let [first, second] = rows;
        let (first, second) = (first?, second?);
        let response =
            Matrix2::from_rows(&[first.response.transpose(), second.response.transpose()]);
        let size = response.row(0).norm() * response.row(1).norm();
        if response.determinant().abs() <= LEAST_DETERMINANT * size {
            return Err(CrosstalkError::Singular);
        }
        let inverse = response.try_inverse().ok_or(CrosstalkError::Singular)?;
        let birge_ratio =
            [&first, &second].map(|row| (row.chi_squared / degrees_of_freedom as f64).sqrt());
        let covariances = [&first, &second].map(|row| row.covariance);
        let entry = |i: usize, j: usize| {
            // δM = −M δA M: δM_ij = −Σ_k M_ik (δa_k · m_j) with a_k row k of A and m_j column j of M. Row k contributes the
            // variance M_ik² m_jᵀ C_k m_j with C_k the covariance of a_k.
            let column: Vector2<f64> = inverse.column(j).into_owned();
            let part = |row: usize| {
                let variance = (column.transpose() * covariances[row] * column).x;
                birge_ratio[row].max(1.0) * inverse[(i, row)].abs() * variance.sqrt()
            };
            MatrixEntry {
                value: inverse[(i, j)],
                errors: [part(0), part(1)],
            }
        };
        let residuals_n: Vec<[f64; 2]> = loadings
            .iter()
            .map(|l| (Vector2::from(l.force_n) - inverse * Vector2::from(l.reading)).into())
            .collect();
        let largest = |axis: usize, values: &mut dyn Iterator<Item = [f64; 2]>| {
            values.map(|value| value[axis].abs()).fold(0.0, f64::max)
        };
        let nonlinearity = [0, 1].map(|axis| {
            largest(axis, &mut residuals_n.iter().copied())
                / largest(axis, &mut loadings.iter().map(|l| l.force_n))
        });
        Ok(Self {
            response: [0, 1].map(|i| [0, 1].map(|j| response[(i, j)])),
            matrix: [0, 1].map(|i| [0, 1].map(|j| entry(i, j))),
            residuals_n,
            nonlinearity,
            birge_ratio,
            degrees_of_freedom,
        })
    }
}

/// Response of one axis to both forces.
struct AxisResponse {
    response: Vector2<f64>,
    covariance: Matrix2<f64>,
    chi_squared: f64,
}

impl AxisResponse {
    fn fit(loadings: &[Loading], axis: usize) -> Result<Self, CrosstalkError> {
        // a = (Σ w F Fᵀ)⁻¹ Σ w y F with w = 1/σ², and the inverse is the covariance of a.
        let (mut normal, mut moment) = (Matrix2::zeros(), Vector2::zeros());
        for loading in loadings {
            let force = Vector2::from(loading.force_n);
            let weight = loading.sigma[axis].powi(-2);
            normal += weight * force * force.transpose();
            moment += weight * loading.reading[axis] * force;
        }
        let size = normal[(0, 0)] * normal[(1, 1)];
        if normal.determinant() <= LEAST_DETERMINANT * size {
            return Err(CrosstalkError::OneDirection);
        }
        let covariance = normal.try_inverse().ok_or(CrosstalkError::OneDirection)?;
        let response = covariance * moment;
        let chi_squared = loadings
            .iter()
            .map(|l| {
                let missed = l.reading[axis] - response.dot(&Vector2::from(l.force_n));
                (missed / l.sigma[axis]).powi(2)
            })
            .sum();
        Ok(Self {
            response,
            covariance,
            chi_squared,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const LOADS_N: [[f64; 2]; 7] = [
        [0.2, 0.0],
        [0.5, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [0.0, 0.2],
        [0.0, 0.5],
        [0.0, 1.0],
    ];
    const RESPONSE: [[f64; 2]; 2] = [[1.2, 0.03], [-0.05, 0.85]];

    fn loadings(sigma: f64, mut white: impl FnMut() -> f64) -> Vec<Loading> {
        LOADS_N
            .iter()
            .map(|&force_n| Loading {
                force_n,
                reading: RESPONSE
                    .map(|row| row[0] * force_n[0] + row[1] * force_n[1] + sigma * white()),
                sigma: [sigma; 2],
            })
            .collect()
    }

    #[test]
    fn an_exact_sensor_is_inverted_exactly() {
        let fit = Crosstalk::fit(&loadings(1e-3, || 0.0)).unwrap();
        // Inverse in closed form: det = 1.2·0.85 + 0.05·0.03.
        let det = 1.021_5;
        let expected = [[0.85 / det, -0.03 / det], [0.05 / det, 1.2 / det]];
        for (row, expected) in fit.matrix.iter().zip(expected) {
            for (entry, expected) in row.iter().zip(expected) {
                assert_relative_eq!(entry.value, expected, max_relative = 1e-12);
            }
        }
        assert!(fit.nonlinearity.iter().all(|departure| *departure < 1e-12));
    }

    #[test]
    fn errors_are_those_of_two_lines_where_the_axes_are_not_crossed() {
        // Without crosstalk A_00 = Σxy/Σx², σ_A = σ/√Σx², M_00 = 1/A_00 and σ_M = σ_A/A².
        let sigma = 2e-3;
        let straight: Vec<Loading> = LOADS_N
            .iter()
            .map(|&force_n| Loading {
                force_n,
                reading: [1.2 * force_n[0], 0.8 * force_n[1]],
                sigma: [sigma; 2],
            })
            .collect();
        let fit = Crosstalk::fit(&straight).unwrap();
        let squares: f64 = LOADS_N.iter().map(|f| f[0] * f[0]).sum();
        assert_relative_eq!(
            fit.matrix[0][0].standard_error(),
            sigma / squares.sqrt() / 1.44,
            max_relative = 1e-12
        );
        assert_eq!(fit.degrees_of_freedom, 5);
    }

    #[test]
    fn intervals_hold_the_truth() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        let det = 1.021_5;
        let truth = [[0.85 / det, -0.03 / det], [0.05 / det, 1.2 / det]];
        let mut covered = [[0; 2]; 2];
        for _ in 0..1000 {
            let fit = Crosstalk::fit(&loadings(2e-3, || StandardNormal.sample(&mut rng))).unwrap();
            for i in 0..2 {
                for j in 0..2 {
                    let entry = fit.matrix[i][j];
                    let error = (entry.value - truth[i][j]).abs();
                    covered[i][j] += u32::from(error < 1.96 * entry.standard_error());
                }
            }
        }
        for count in covered.as_flattened() {
            assert!((935..=995).contains(count), "{covered:?}");
        }
    }

    #[test]
    fn data_without_a_determined_matrix_are_refused() {
        let loads = loadings(1e-3, || 0.0);
        assert_eq!(
            Crosstalk::fit(&loads[..2]),
            Err(CrosstalkError::TooFew { count: 2 })
        );
        assert_eq!(
            Crosstalk::fit(&loads[..4]),
            Err(CrosstalkError::OneDirection)
        );
        let mut one_sensor = loads.clone();
        for loading in &mut one_sensor {
            loading.reading[1] = 0.5 * loading.reading[0];
        }
        assert_eq!(Crosstalk::fit(&one_sensor), Err(CrosstalkError::Singular));
        let mut nan = loads;
        nan[3].reading[0] = f64::NAN;
        assert_eq!(
            Crosstalk::fit(&nan),
            Err(CrosstalkError::NotFinite { index: 3 })
        );
    }
}
