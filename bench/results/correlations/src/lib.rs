//! Correlations and goodness of fit, as in the published figures.

mod rank_orders;

use num_complex::Complex64;
use rank_orders::{p_of_all_orders, p_of_perfect_orders};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::statistics::{Data, OrderStatistics, RankTieBreaker, Statistics};

/// A correlation coefficient with its two-sided p-value under the null hypothesis of no correlation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Correlation {
    /// Coefficient, −1 to 1.
    pub rho: f64,
    /// Two-sided p-value by Student's t with n − 2 degrees of freedom. For Spearman's coefficient it is exact, over all orders
    /// of the ranks, with up to [`EXACT_PAIRS`] pairs; with more, it is an approximation, as scipy's, but never below that of
    /// a perfect order.
    pub p: f64,
    /// Number of pairs.
    pub n: usize,
}

/// Coefficient of correlation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coefficient {
    /// Pearson's coefficient of the values.
    Pearson,
    /// Spearman's coefficient of the ranks, with ties at their mean rank.
    Spearman,
}

impl Coefficient {
    /// Correlates the pairs in which both values are finite. `None` with fewer than three of them, or if either side is
    /// constant.
    #[must_use]
    pub fn correlate(self, x: &[f64], y: &[f64]) -> Option<Correlation> {
        let (x, y) = finite_pairs(x, y);
        let (x, y) = (self.scores(x), self.scores(y));
        let correlation = correlate(&x, &y)?;
        let p = match self {
            Self::Pearson => correlation.p,
            Self::Spearman if correlation.n <= EXACT_PAIRS => p_of_all_orders(&x, &y),
            Self::Spearman => correlation.p.max(p_of_perfect_orders(&x, &y)),
        };
        Some(Correlation { p, ..correlation })
    }

    /// Returns the quantity that is correlated, for finite values.
    #[must_use]
    pub fn scores(self, values: Vec<f64>) -> Vec<f64> {
        match self {
            Self::Pearson => values,
            Self::Spearman => Data::new(values).ranks(RankTieBreaker::Average),
        }
    }
}

/// Largest number of pairs for which all orders are tried: 8 have 40 320.
pub const EXACT_PAIRS: usize = 8;

/// Mean and sample standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Sample standard deviation (n − 1); `None` for a single value.
    pub std: Option<f64>,
    /// Number of values.
    pub n: usize,
}

/// Slope of a straight line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slope {
    /// Slope.
    pub slope: f64,
    /// Standard error of the slope; `None` for two points.
    pub std: Option<f64>,
    /// Number of points.
    pub n: usize,
}

/// Returns the slope of the least-squares line in y, with intercept, through the pairs in which both are finite; `None` with
/// fewer than two, or if x is constant.
#[must_use]
pub fn slope(x: &[f64], y: &[f64]) -> Option<Slope> {
    let (x, y) = finite_pairs(x, y);
    let n = x.len();
    let variance = x.iter().variance();
    // b = s_xy/s_x². The sum of squared residuals is (n − 1)(s_y² − b² s_x²), and var b is it/(n − 2)/((n − 1) s_x²).
    let slope = x.iter().covariance(y.iter()) / variance;
    let residual_variance = (y.iter().variance() - slope * slope * variance).max(0.0);
    slope.is_finite().then(|| Slope {
        slope,
        std: (n > 2).then(|| (residual_variance / variance / (n - 2) as f64).sqrt()),
        n,
    })
}

/// Returns 1 − Σ|y − ŷ|²/Σ|y − ȳ|² of complex values.
#[must_use]
pub fn r_squared_complex(y: &[Complex64], modelled: &[Complex64]) -> f64 {
    let mean = y.iter().sum::<Complex64>() / y.len() as f64;
    let residual_squares: f64 = y
        .iter()
        .zip(modelled)
        .map(|(value, model)| (value - model).norm_sqr())
        .sum();
    let total_squares: f64 = y.iter().map(|value| (value - mean).norm_sqr()).sum();
    1.0 - residual_squares / total_squares
}

/// Returns mean and spread of the finite values; `None` without any.
#[must_use]
pub fn spread(values: impl IntoIterator<Item = f64>) -> Option<Spread> {
    let values: Vec<f64> = values
        .into_iter()
        .filter(|value| value.is_finite())
        .collect();
    let n = values.len();
    (n > 0).then(|| Spread {
        mean: values.iter().mean(),
        std: (n > 1).then(|| values.iter().std_dev()),
        n,
    })
}

fn finite_pairs(x: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    x.iter()
        .zip(y)
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .unzip()
}

fn correlate(x: &[f64], y: &[f64]) -> Option<Correlation> {
    let n = x.len();
    if n < 3 {
        return None;
    }
    let rho = x.iter().covariance(y.iter()) / (x.iter().std_dev() * y.iter().std_dev());
    if !rho.is_finite() {
        return None;
    }
    let rho = rho.clamp(-1.0, 1.0);
    let freedom = (n - 2) as f64;
    // t = |ρ| √(ν/(1 − ρ²)) has Student's distribution with ν = n − 2 if there is no correlation (exactly for normal values).
    let t = rho.abs() * (freedom / (1.0 - rho * rho)).sqrt();
    let p = if t.is_finite() {
        2.0 * StudentsT::new(0.0, 1.0, freedom).ok()?.sf(t)
    } else {
        0.0
    };
    Some(Correlation { rho, p, n })
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const X: [f64; 8] = [0.1, 0.9, 2.2, 2.9, 4.4, 4.6, 6.3, 7.1];
    const Y: [f64; 8] = [1.0, 0.4, 2.0, 2.0, 1.7, 3.9, 3.1, 5.2];

    // (statistic, pvalue) of scipy 1.17.1's pearsonr and spearmanr; for the latter only the statistic, because its p-value
    // (0.0045) is that of t.
    const PEARSON: (f64, f64) = (0.868_818_716_575_736_4, 0.005_102_909_763_564_278);
    const SPEARMAN: (f64, f64) = (0.874_267_171_196_679_1, 0.004_512_385_603_651_025);

    #[test]
    fn coefficients_and_p_values_are_scipys() {
        let pearson = Coefficient::Pearson.correlate(&X, &Y).unwrap();
        assert_relative_eq!(pearson.rho, PEARSON.0, max_relative = 1e-12);
        assert_relative_eq!(pearson.p, PEARSON.1, max_relative = 1e-9);
        let spearman = Coefficient::Spearman.correlate(&X, &Y).unwrap();
        assert_relative_eq!(spearman.rho, SPEARMAN.0, max_relative = 1e-12);
        assert!(spearman.p > SPEARMAN.1 && spearman.p < 0.01, "{spearman:?}");
        let (x, y): (Vec<f64>, Vec<f64>) = X.iter().zip(Y).map(|(x, y)| (x - 8.0, y - 8.0)).unzip();
        let (x, y) = ([&X[..], &x].concat(), [&Y[..], &y].concat());
        let correlation = Coefficient::Spearman.correlate(&x, &y).unwrap();
        let t = correlate(
            &Coefficient::Spearman.scores(x.clone()),
            &Coefficient::Spearman.scores(y.clone()),
        );
        assert_eq!(correlation.p, t.unwrap().p, "beyond {EXACT_PAIRS} pairs");
    }

    /// Regression test: a coefficient of 1 from four pairs had p = 0.
    #[test]
    fn p_of_few_ranks_is_exact_over_all_orders() {
        let p = |y: &[f64]| {
            let x: Vec<f64> = (0..y.len()).map(|k| k as f64).collect();
            Coefficient::Spearman.correlate(&x, y).unwrap().p
        };
        for (y, exact) in [
            // Calculated by hand: 2 of 3!, 4! and 5! orders.
            (&[1.0, 2.0, 3.0][..], 2.0 / 6.0),
            (&[1.0, 2.0, 3.0, 4.0], 2.0 / 24.0),
            (&[5.0, 4.0, 3.0, 2.0, 1.0], 2.0 / 120.0),
            // For Σd² of 2 and 4, 5 and 12 orders are as close to rising, and as many to falling; tables give 0.083 and 0.033
            // (Zar 1972).
            (&[2.0, 1.0, 3.0, 4.0, 5.0], 10.0 / 120.0),
            (&[2.0, 1.0, 4.0, 3.0, 5.0, 6.0], 24.0 / 720.0),
        ] {
            assert_relative_eq!(p(y), exact, max_relative = 1e-12);
        }
        let ranks: Vec<f64> = (0..12).map(f64::from).collect();
        assert_relative_eq!(p(&ranks), 2.0 / 479_001_600.0, max_relative = 1e-9);
    }

    /// Regression test: with the ties of one side, p was below the fraction of perfect orders, here 0.0026 by Student's t.
    #[test]
    fn p_of_ties_is_no_smaller_than_the_fraction_of_perfect_orders() {
        let groups = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        let x: Vec<f64> = (0..9).map(f64::from).collect();
        let p = Coefficient::Spearman.correlate(&x, &groups).unwrap().p;
        // 4! 5! of 9! orders rise, and as many fall.
        assert_relative_eq!(p, 2.0 / 126.0, max_relative = 1e-9);
        let falling: Vec<f64> = groups.iter().map(|y| -y).collect();
        let p_of_falling = Coefficient::Spearman.correlate(&x, &falling).unwrap().p;
        assert_relative_eq!(p_of_falling, p, max_relative = 1e-9);
    }

    // (slope, stderr) of scipy's linregress.
    const LINE: (f64, f64) = (0.550_844_266_805_688_4, 0.128_157_363_854_863_2);

    #[test]
    fn a_slope_and_its_error_are_scipys() {
        let line = slope(&X, &Y).unwrap();
        assert_relative_eq!(line.slope, LINE.0, max_relative = 1e-12);
        assert_relative_eq!(line.std.unwrap(), LINE.1, max_relative = 1e-9);
        assert_eq!(slope(&[1.0], &[2.0]), None);
        assert_eq!(slope(&[1.0, 1.0], &[2.0, 3.0]), None);
    }

    #[test]
    fn constant_or_missing_values_have_no_statistics() {
        let [pearson, spearman] = [Coefficient::Pearson, Coefficient::Spearman];
        assert_eq!(pearson.correlate(&[1.0, 1.0, 1.0], &[1.0, 2.0, 3.0]), None);
        assert_eq!(
            spearman.correlate(&[1.0, f64::NAN, 3.0], &[1.0, 2.0, 3.0]),
            None
        );
        assert_eq!(spread([f64::NAN]), None);
        assert_eq!(spread([2.0]).unwrap().std, None);
    }

    #[test]
    fn r_squared_is_one_for_a_perfect_model_and_zero_for_the_mean() {
        let measured: Vec<Complex64> = X
            .iter()
            .zip(Y)
            .map(|(x, y)| Complex64::new(*x, y))
            .collect();
        assert_relative_eq!(r_squared_complex(&measured, &measured), 1.0);
        let mean = measured.iter().sum::<Complex64>() / 8.0;
        assert_relative_eq!(r_squared_complex(&measured, &[mean; 8]), 0.0);
    }
}
