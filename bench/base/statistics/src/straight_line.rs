//! Least squares of a straight line.

/// Straight line through points of equal weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightLine {
    /// Mean of the points, on the line.
    pub middle: (f64, f64),
    /// Slope.
    pub slope: f64,
    /// Standard error of the slope by independent residuals: s/√Σ(x − x̄)², with the root mean square residual s.
    pub slope_std: f64,
    /// Root mean square residual.
    pub residual: f64,
}

impl StraightLine {
    /// Returns the line of least squares through points (x, y); `None` with fewer than two values of x.
    ///
    /// ```
    /// let line = statistics::StraightLine::fit(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]).unwrap();
    /// assert_eq!((line.slope, line.at(3.0), line.residual), (2.0, 7.0, 0.0));
    /// ```
    #[must_use]
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        let mean = |value: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / n;
        let middle = (mean(&|point| point.0), mean(&|point| point.1));
        let square = mean(&|point| (point.0 - middle.0).powi(2));
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        let slope = mean(&|point| (point.0 - middle.0) * (point.1 - middle.1)) / square;
        let rest = |point: &(f64, f64)| point.1 - middle.1 - slope * (point.0 - middle.0);
        let residual = mean(&|point| rest(point).powi(2)).sqrt();
        Some(Self {
            middle,
            slope,
            slope_std: residual / (square * n).sqrt(),
            residual,
        })
    }

    /// Returns the line's value at x.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        self.middle.1 + self.slope * (x - self.middle.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_that_of_least_squares_with_its_error() {
        let points: Vec<(f64, f64)> = (0..10)
            .map(|n| {
                let x = f64::from(n);
                (x, 2.0 - 0.5 * x + if n % 2 == 0 { 0.1 } else { -0.1 })
            })
            .collect();
        let line = StraightLine::fit(&points).unwrap();
        // Σ(x − x̄)² = 82.5, and the alternating part has Σ(x − x̄) e = −0.5.
        assert!((line.slope - (-0.5 - 0.5 / 82.5)).abs() < 1e-12, "{line:?}");
        assert!((line.slope_std - line.residual / 82.5_f64.sqrt()).abs() < 1e-15);
        let residual = (0.01 - 8.25 * (0.5_f64 / 82.5).powi(2)).sqrt();
        assert!((line.residual - residual).abs() < 1e-12);
        assert!((line.at(4.5) - (2.0 - 0.5 * 4.5)).abs() < 1e-12, "{line:?}");
        for points in [
            &[][..],
            &[(1.0, 2.0)],
            &[(1.0, 2.0), (1.0, 3.0)],
            &[(f64::NAN, 1.0), (1.0, 1.0)],
        ] {
            assert_eq!(StraightLine::fit(points), None, "{points:?}");
        }
    }
}
