//! Value with its standard error.

/// Estimate with a known standard error, part of which may be common to all estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    value: f64,
    /// Standard error of the estimate alone.
    own_std: f64,
    /// Standard error due to a cause that moves all estimates in the same direction.
    common_std: f64,
}

impl Estimate {
    /// Makes an estimate; `None` unless both are finite and the standard error is positive.
    #[must_use]
    pub fn new(value: f64, std: f64) -> Option<Self> {
        let is_valid = value.is_finite() && std.is_finite() && std > 0.0 && std * std > 0.0;
        is_valid.then_some(Self {
            value,
            own_std: std,
            common_std: 0.0,
        })
    }

    /// Returns the estimate with an error in addition that is common to all estimates: of a law that none of them determines.
    /// `common_std` is finite and not negative.
    #[must_use]
    pub fn with_common_error(self, common_std: f64) -> Self {
        Self { common_std, ..self }
    }

    /// Returns the value.
    #[must_use]
    pub fn value(self) -> f64 {
        self.value
    }

    /// Returns the standard error, with the common part.
    #[must_use]
    pub fn std(self) -> f64 {
        self.own_std.hypot(self.common_std)
    }

    /// Returns the standard error without the common part.
    pub(crate) fn own_std(self) -> f64 {
        self.own_std
    }

    pub(crate) fn common_std(self) -> f64 {
        self.common_std
    }

    /// Returns the variance of the error without the common part.
    pub(crate) fn variance(self) -> f64 {
        self.own_std * self.own_std
    }

    /// Returns the estimate from the data alone if this one was made with a normal `prior`; `None` if the data contain no
    /// information. For pooling: a prior that is used in every trial would otherwise be counted once for each.
    ///
    /// Exact for a normal posterior without a common error, also among other parameters: removing one parameter's prior from the
    /// joint precision subtracts its precision from that of the marginal. With precisions p = 1/σ²: p = p_post − p_prior and
    /// p y = p_post y_post − p_prior y_prior.
    #[must_use]
    pub fn without_prior(self, prior: Self) -> Option<Self> {
        let (posterior_precision, prior_precision) =
            (self.variance().recip(), prior.variance().recip());
        let precision = posterior_precision - prior_precision;
        let value = (self.value * posterior_precision - prior.value * prior_precision) / precision;
        // A difference within rounding error carries no information.
        let is_informative = precision > 1e-6 * prior_precision;
        Self::new(value, precision.sqrt().recip()).filter(|_| is_informative)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use approx::assert_relative_eq;

    pub(crate) fn estimates(values: &[f64], std: f64) -> Vec<Estimate> {
        let estimates = values.iter().map(|&value| Estimate::new(value, std));
        estimates.map(Option::unwrap).collect()
    }

    #[test]
    fn only_finite_values_with_an_error_are_estimates() {
        assert!(Estimate::new(0.0, 1.0).is_some());
        for (value, std) in [
            (f64::NAN, 1.0),
            (0.0, 0.0),
            (0.0, 1e-200),
            (0.0, f64::INFINITY),
            (0.0, f64::NAN),
            (0.0, -1.0),
        ] {
            assert_eq!(Estimate::new(value, std), None);
        }
    }

    #[test]
    fn a_prior_is_removed() {
        // Data 2 ± 0.5 under a prior 0 ± 1: precision 4 + 1, value 8/5.
        let posterior = Estimate::new(1.6, 0.2_f64.sqrt()).unwrap();
        let prior = Estimate::new(0.0, 1.0).unwrap();
        let data = posterior.without_prior(prior).unwrap();
        assert_relative_eq!(data.value(), 2.0, max_relative = 1e-12);
        assert_relative_eq!(data.std(), 0.5, max_relative = 1e-12);
        // The prior alone, and a fit that is less certain than its prior.
        assert_eq!(prior.without_prior(prior), None);
        assert_eq!(Estimate::new(0.3, 1.1).unwrap().without_prior(prior), None);
    }
}
