//! A mean with its interval by Student's t.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::statistics::Statistics;

/// Mean of finite values with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mean {
    /// Mean; NaN without values.
    pub value: f64,
    /// Interval by Student's t, with n − 1 degrees of freedom; `None` for fewer than two values, which have no scatter.
    pub interval95: Option<[f64; 2]>,
    /// Number of values.
    pub n: usize,
}

impl Mean {
    /// Returns the mean of the finite values.
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values
            .into_iter()
            .filter(|value| value.is_finite())
            .collect();
        let n = values.len();
        let value = values.iter().sum::<f64>() / n as f64;
        let half_width = || {
            let quantile = StudentsT::new(0.0, 1.0, (n - 1) as f64).ok()?;
            let error = values.iter().std_dev() / (n as f64).sqrt();
            Some(quantile.inverse_cdf(0.975) * error)
        };
        let half_width = if n > 1 { half_width() } else { None };
        Self {
            value,
            interval95: half_width.map(|width| [value - width, value + width]),
            n,
        }
    }

    /// Returns the lower and upper end of the interval; NaN without one.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        self.interval95.unwrap_or([f64::NAN; 2])
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    /// Interval of scipy 1.17.1: `stats.t.interval(0.95, 4, x.mean(), stats.sem(x))`.
    #[test]
    fn the_interval_is_scipys() {
        let mean = Mean::new([0.91, 0.94, 0.9, f64::NAN, 0.965, 0.93]);
        let [low, high] = mean.interval95.unwrap();
        assert_eq!(mean.n, 5);
        assert_relative_eq!(mean.value, 0.929, max_relative = 1e-12);
        assert_relative_eq!(low, LOW, max_relative = 1e-9);
        assert_relative_eq!(high, HIGH, max_relative = 1e-9);
    }

    const LOW: f64 = 0.897_222_133_295_245_2;
    const HIGH: f64 = 0.960_777_866_704_754_6;

    #[test]
    fn a_single_value_has_no_interval_and_no_value_no_mean() {
        assert_eq!(Mean::new([0.5]).interval95, None);
        assert_eq!(Mean::new([0.5]).value, 0.5);
        let empty = Mean::new([f64::NAN]);
        assert!(empty.value.is_nan() && empty.n == 0 && empty.ends()[0].is_nan());
    }
}
