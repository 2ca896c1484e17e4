//! A straight line through weighted points, such as known amplitudes against a pickup's readings or known forces against a
//! sensor's.

use statistics::significant;

/// One point: y was known with standard deviation `sigma`, x without error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePoint {
    /// Reading of the sensor.
    pub x: f64,
    /// True value.
    pub y: f64,
    /// Standard deviation of `y`, in its unit; only ratios between points matter where all are scaled by the residuals.
    pub sigma: f64,
}

/// y = offset + slope · x, by weighted least squares (Bevington & Robinson 2003, chapter 6).
///
/// ```
/// use metrology::regression::{FittedLine, LinePoint};
///
/// let points = [(0.0, 1.0), (1.0, 3.1), (2.0, 4.9)].map(|(x, y)| LinePoint { x, y, sigma: 0.1 });
/// let line = FittedLine::fit(&points)?;
/// assert!((line.slope - 1.95).abs() < 1e-12);
/// # Ok::<(), metrology::regression::LineFitError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FittedLine {
    /// Slope, unit of y per unit of x.
    pub slope: f64,
    /// Standard error of the slope.
    pub slope_error: f64,
    /// y at x = 0.
    pub offset: f64,
    /// Standard error of the offset.
    pub offset_error: f64,
    /// y − (offset + slope · x) of each point.
    pub residuals: Vec<f64>,
    /// Largest |residual| over the largest |y|.
    pub nonlinearity: f64,
    /// √(χ²/(n − 2)): the ratio of the points' scatter to their `sigma`. Errors are scaled by it where it is
    /// above 1.
    pub birge_ratio: f64,
    /// Degrees of freedom: number of points minus two.
    pub degrees_of_freedom: usize,
}

/// Reasons why points determine no line.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LineFitError {
    /// Fewer than three points.
    #[error("{count} points determine no line with an error: at least 3 are needed")]
    TooFew {
        /// Number of points.
        count: usize,
    },
    /// All points have the same x.
    #[error("all points lie at one reading of {}: use levels that differ", significant(*.x))]
    NoSpread {
        /// Mean x of the points.
        x: f64,
    },
    /// A value is not finite, or a deviation not positive.
    #[error(
        "point {index} is ({}, {}) with deviation {}: all must be finite, the deviation positive",
        significant(*.x), significant(*.y), significant(*.sigma)
    )]
    NotFinite {
        /// Index of the point.
        index: usize,
        /// x of the point.
        x: f64,
        /// y of the point.
        y: f64,
        /// Standard deviation of the point.
        sigma: f64,
    },
}

impl FittedLine {
    /// Fits the line. Errors come from the points' deviations, or from their scatter where that is larger.
    ///
    /// The 95 % interval includes the true slope in 95 % of noisy draws (`intervals_hold_the_truth`).
    ///
    /// # Errors
    /// When there are fewer than three points, no spread, or a value that is not finite.
    pub fn fit(points: &[LinePoint]) -> Result<Self, LineFitError> {
        let is_invalid = |p: &LinePoint| {
            !(p.x.is_finite() && p.y.is_finite() && p.sigma.is_finite() && p.sigma > 0.0)
        };
        if let Some(index) = points.iter().position(is_invalid) {
            let LinePoint { x, y, sigma } = points[index];
            return Err(LineFitError::NotFinite { index, x, y, sigma });
        }
        let count = points.len();
        if count < 3 {
            return Err(LineFitError::TooFew { count });
        }
        let weight = |p: &LinePoint| p.sigma.powi(-2);
        let total: f64 = points.iter().map(weight).sum();
        let mean = |value: &dyn Fn(&LinePoint) -> f64| {
            points.iter().map(|p| weight(p) * value(p)).sum::<f64>() / total
        };
        // With w = 1/σ², x̄ = Σwx/Σw and S = Σw (x − x̄)²:  b = Σw (x − x̄)(y − ȳ)/S,  a = ȳ − b x̄,  var b = 1/S,
        // var a = 1/Σw + x̄²/S (ȳ and b are uncorrelated), all times χ²/(n − 2) where that is above 1.
        let (x_mean, y_mean) = (mean(&|p| p.x), mean(&|p| p.y));
        let spread: f64 = points
            .iter()
            .map(|p| weight(p) * (p.x - x_mean).powi(2))
            .sum();
        let largest_x = points.iter().map(|p| p.x.abs()).fold(0.0, f64::max);
        if spread <= total * (1e-9 * largest_x).powi(2) {
            return Err(LineFitError::NoSpread { x: x_mean });
        }
        let slope = points
            .iter()
            .map(|p| weight(p) * (p.x - x_mean) * (p.y - y_mean))
            .sum::<f64>()
            / spread;
        let offset = y_mean - slope * x_mean;
        let residuals: Vec<f64> = points.iter().map(|p| p.y - offset - slope * p.x).collect();
        let degrees_of_freedom = count - 2;
        let chi2: f64 = points
            .iter()
            .zip(&residuals)
            .map(|(p, r)| (r / p.sigma).powi(2))
            .sum();
        let birge_ratio = (chi2 / degrees_of_freedom as f64).sqrt();
        let scale = birge_ratio.max(1.0);
        let largest_y = points.iter().map(|p| p.y.abs()).fold(0.0, f64::max);
        let worst = residuals.iter().map(|r| r.abs()).fold(0.0, f64::max);
        Ok(Self {
            slope,
            slope_error: scale * spread.sqrt().recip(),
            offset,
            offset_error: scale * (total.recip() + x_mean.powi(2) / spread).sqrt(),
            residuals,
            nonlinearity: worst / largest_y,
            birge_ratio,
            degrees_of_freedom,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn agrees_with_the_normal_equations() {
        // (AᵀWA)⁻¹ AᵀWy in exact rational arithmetic (Python's fractions).
        let points: Vec<LinePoint> = [
            (1.0, 1.1, 0.1),
            (2.0, 1.9, 0.1),
            (3.0, 3.2, 0.2),
            (4.0, 3.9, 0.2),
            (5.0, 5.3, 0.3),
        ]
        .map(|(x, y, sigma)| LinePoint { x, y, sigma })
        .into();
        let line = FittedLine::fit(&points).unwrap();
        assert_relative_eq!(line.slope, 0.999_426_699_426_7, max_relative = 1e-12);
        assert_relative_eq!(line.offset, 0.023_505_323_505_3, max_relative = 1e-9);
        let scale = line.birge_ratio.max(1.0);
        assert_relative_eq!(
            line.slope_error,
            scale * 0.055_492_729_969_3,
            max_relative = 1e-11
        );
        assert_relative_eq!(
            line.offset_error,
            scale * 0.128_622_768_372_5,
            max_relative = 1e-11
        );
        let chi_squared = 4.119_574_119_574_1;
        assert_relative_eq!(
            line.birge_ratio.powi(2) * 3.0,
            chi_squared,
            max_relative = 1e-10
        );
    }

    #[test]
    fn intervals_hold_the_truth() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut covered = 0;
        for _ in 0..2000 {
            let points: Vec<LinePoint> = (1..=10)
                .map(|i| {
                    let (x, sigma) = (0.1 * f64::from(i), 0.01 * f64::from(i));
                    let white: f64 = StandardNormal.sample(&mut rng);
                    LinePoint {
                        x,
                        y: 0.3 + 5.0 * x + sigma * white,
                        sigma,
                    }
                })
                .collect();
            let line = FittedLine::fit(&points).unwrap();
            covered += u32::from((line.slope - 5.0).abs() < 1.96 * line.slope_error);
        }
        assert!((1880..=1990).contains(&covered), "{covered}");
    }

    #[test]
    fn data_without_a_line_are_refused() {
        let p = |x, y| LinePoint { x, y, sigma: 1.0 };
        assert_eq!(
            FittedLine::fit(&[p(0.0, 0.0), p(1.0, 1.0)]),
            Err(LineFitError::TooFew { count: 2 })
        );
        assert_eq!(
            FittedLine::fit(&[p(2.0, 0.0), p(2.0, 1.0), p(2.0, 3.0)]),
            Err(LineFitError::NoSpread { x: 2.0 })
        );
        assert!(matches!(
            FittedLine::fit(&[p(1.0, 0.0), p(2.0, f64::NAN), p(3.0, 1.0)]),
            Err(LineFitError::NotFinite { index: 1, .. })
        ));
    }
}
