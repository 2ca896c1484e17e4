//! Linear least squares with complex coefficients.

use num_complex::Complex64;

/// Smallest part of a column that is not a combination of the columns before it, of its length.
const INDEPENDENT: f64 = 1e-10;

/// Coefficients of a linear least-squares fit, and the sum of the squared residuals.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearFit {
    /// Coefficients, in order of the columns.
    pub coefficients: Vec<Complex64>,
    /// Σ|residual|².
    pub squares: f64,
}

impl LinearFit {
    /// Fits `data` by a combination of `columns`, by Gram and Schmidt's modified method; `None` if a column depends on those
    /// before it.
    #[must_use]
    pub fn new(mut columns: Vec<Vec<Complex64>>, data: &[Complex64]) -> Option<Self> {
        let count = columns.len();
        let mut residual = data.to_vec();
        // Shares of the columns before each one, and the length of the rest.
        let mut shares: Vec<(Vec<Complex64>, f64)> = Vec::with_capacity(count);
        let mut projections = Vec::with_capacity(count);
        for k in 0..count {
            let (done, rest) = columns.split_at_mut(k);
            let column = rest.first_mut()?;
            let length = norm(column);
            let mut before = Vec::with_capacity(k);
            for unit in done.iter() {
                let share = product(unit, column);
                subtract(column, share, unit);
                before.push(share);
            }
            let rest = norm(column);
            if rest.is_nan() || rest <= INDEPENDENT * length {
                return None;
            }
            for value in column.iter_mut() {
                *value /= rest;
            }
            shares.push((before, rest));
            let projection = product(column, &residual);
            subtract(&mut residual, projection, column);
            projections.push(projection);
        }
        let mut coefficients = vec![Complex64::ZERO; count];
        for k in (0..count).rev() {
            let known: Complex64 = (k + 1..count)
                .map(|j| shares[j].0[k] * coefficients[j])
                .sum();
            coefficients[k] = (projections[k] - known) / shares[k].1;
        }
        Some(Self {
            coefficients,
            squares: norm(&residual).powi(2),
        })
    }
}

fn norm(values: &[Complex64]) -> f64 {
    values.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
}

fn product(a: &[Complex64], b: &[Complex64]) -> Complex64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

fn subtract(values: &mut [Complex64], times: Complex64, other: &[Complex64]) {
    for (value, other) in values.iter_mut().zip(other) {
        *value -= times * other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_combination_is_recovered_and_dependent_columns_are_refused() {
        let x: Vec<f64> = (0..9).map(f64::from).collect();
        let column = |f: &dyn Fn(f64) -> Complex64| x.iter().map(|x| f(*x)).collect::<Vec<_>>();
        let one = column(&|_| Complex64::ONE);
        let line = column(&|x| x.into());
        let turn = column(&|x| Complex64::cis(0.4 * x));
        let data = column(&|x| {
            Complex64::new(2.0, -1.0) + Complex64::I * x + 0.5 * Complex64::cis(0.4 * x)
        });
        let fit = LinearFit::new(vec![one.clone(), line.clone(), turn], &data).unwrap();
        let truth = [Complex64::new(2.0, -1.0), Complex64::I, 0.5.into()];
        for (fitted, true_value) in fit.coefficients.iter().zip(truth) {
            assert!((fitted - true_value).norm() < 1e-10, "{fit:?}");
        }
        assert!(fit.squares < 1e-18);
        let twice = line.iter().map(|x| 2.0 * x).collect();
        assert_eq!(LinearFit::new(vec![one, line, twice], &data), None);
    }
}
