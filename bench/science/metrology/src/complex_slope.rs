//! Complex factor between two tones at several levels, such as known displacements and a pickup's readings.

use num_complex::Complex64;

/// y = slope · x by least squares, x without error and y with the same error at every point.
///
/// slope = Σ x* y/Σ|x|². Each part of y has the variance s² = Σ|y − slope · x|²/(2n − 2), so each part of the slope has
/// s²/Σ|x|². Relative to |slope|, the part along the slope is the error of its amplitude, the part across it that of its phase.
///
/// ```
/// use metrology::complex_slope::ComplexSlope;
/// use num_complex::Complex64;
///
/// let factor = Complex64::from_polar(2.0, 0.3);
/// let points: Vec<_> = [0.1, 0.2, 0.3].map(|x| (Complex64::new(0.0, x), factor * Complex64::new(0.0, x))).into();
/// let fit = ComplexSlope::fit(&points).unwrap();
/// assert!((fit.slope - factor).norm() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplexSlope {
    /// The factor.
    pub slope: Complex64,
    /// Standard error of its phase, rad, and of its amplitude, relative.
    pub relative_error: f64,
}

impl ComplexSlope {
    /// Fits points (x, y); `None` for fewer than two, or if they do not determine the slope.
    ///
    /// The error follows from the residuals (`the_phase_is_covered`).
    #[must_use]
    pub fn fit(points: &[(Complex64, Complex64)]) -> Option<Self> {
        let power: f64 = points.iter().map(|(x, _)| x.norm_sqr()).sum();
        let product: Complex64 = points.iter().map(|(x, y)| x.conj() * y).sum();
        let slope = product / power;
        let squares: f64 = points.iter().map(|(x, y)| (y - slope * x).norm_sqr()).sum();
        let freedom = 2 * points.len().checked_sub(1).filter(|n| *n > 0)?;
        let error = (squares / freedom as f64 / power).sqrt();
        let relative_error = error / slope.norm();
        relative_error.is_finite().then_some(Self {
            slope,
            relative_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn the_phase_is_covered() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let (factor, mut covered) = (Complex64::from_polar(3.0, 2.9), 0);
        for _ in 0..1_000 {
            let points: Vec<_> = (1..=7)
                .map(|n| {
                    let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
                    let x = Complex64::from_polar(0.1 * f64::from(n), 0.7);
                    (x, factor * x + 1e-3 * Complex64::new(white(), white()))
                })
                .collect();
            let fit = ComplexSlope::fit(&points).unwrap();
            let error_rad = (fit.slope / factor).arg().abs();
            // Student's factor for 12 degrees of freedom.
            covered += u32::from(error_rad < 2.18 * fit.relative_error);
        }
        assert!((930..=970).contains(&covered), "{covered} of 1000");
    }

    #[test]
    fn what_determines_nothing_is_no_fit() {
        let unit = (Complex64::ONE, Complex64::ONE);
        assert_eq!(ComplexSlope::fit(&[]), None);
        assert_eq!(ComplexSlope::fit(&[unit]), None);
        assert_eq!(ComplexSlope::fit(&[(Complex64::ZERO, unit.1); 3]), None);
        assert_eq!(ComplexSlope::fit(&[(unit.0, Complex64::ZERO); 3]), None);
        let nan = Complex64::new(f64::NAN, 0.0);
        assert_eq!(ComplexSlope::fit(&[unit, (unit.0, nan)]), None);
    }
}
