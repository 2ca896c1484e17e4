//! The mean of estimates at one level.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::estimate::Estimate;

/// Standard errors on either side of a value that hold 95 % of a normal distribution.
pub(crate) const WITHIN_95: f64 = 1.959_964;

/// A mean with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Standard error of the mean; what is between the estimates is in it.
    pub std: f64,
    /// 95 % interval of the mean.
    pub interval95: [f64; 2],
    /// Number of estimates.
    pub n: usize,
}

/// Estimates in groups, weighted within each group by precision.
pub(crate) struct Weighted {
    /// Weighted mean and sum of the weights of each group.
    pub(crate) groups: Vec<Option<(f64, f64)>>,
    /// Weighted squares about the means.
    apart: f64,
    /// What [`apart`](Self::apart) grows by with the variance between.
    growth: f64,
    /// Degrees of freedom.
    pub(crate) freedom: usize,
}

impl Weighted {
    /// Weighs estimates that scatter with the variance `between` besides their errors.
    pub(crate) fn new<G: AsRef<[Estimate]>>(groups: &[G], between: f64) -> Self {
        let mut weighted = Self {
            groups: Vec::with_capacity(groups.len()),
            apart: 0.0,
            growth: 0.0,
            freedom: 0,
        };
        for group in groups {
            let group = group.as_ref();
            let weight = |of: &Estimate| (of.variance() + between).recip();
            let sum: f64 = group.iter().map(weight).sum();
            let mean = group.iter().map(|of| weight(of) * of.value()).sum::<f64>() / sum;
            weighted
                .groups
                .push((!group.is_empty()).then_some((mean, sum)));
            if group.len() > 1 {
                let apart = |of: &Estimate| weight(of) * (of.value() - mean).powi(2);
                weighted.apart += group.iter().map(apart).sum::<f64>();
                weighted.growth +=
                    sum - group.iter().map(|of| weight(of).powi(2)).sum::<f64>() / sum;
                weighted.freedom += group.len() - 1;
            }
        }
        weighted
    }

    /// Returns the weighted squares about the means: as many as the degrees of freedom where the weights are right.
    pub(crate) fn apart(&self) -> f64 {
        self.apart
    }

    /// Returns the factor by which squared standard errors are too small for the scatter there is (Hartung and Knapp 2001),
    /// never less than 1, so that estimates that happen to agree claim no more than their errors allow.
    pub(crate) fn inflation(&self) -> f64 {
        if self.freedom == 0 {
            return 1.0;
        }
        (self.apart / self.freedom as f64).max(1.0)
    }

    /// Returns how many standard errors of a mean hold 95 %.
    pub(crate) fn deviations(&self) -> f64 {
        let student = StudentsT::new(0.0, 1.0, self.freedom as f64);
        student.map_or(WITHIN_95, |student| student.inverse_cdf(0.975))
    }
}

/// Returns the variance between estimates of a group beyond that of their errors, the same in all groups (DerSimonian and
/// Laird 1986, their moment summed over groups); `None` where no group has two.
pub(crate) fn between_variance<G: AsRef<[Estimate]>>(groups: &[G]) -> Option<f64> {
    let weighted = Weighted::new(groups, 0.0);
    let surplus = weighted.apart - weighted.freedom as f64;
    (weighted.freedom > 0).then(|| (surplus / weighted.growth).max(0.0))
}

/// Returns the mean of estimates that may differ by more than their errors: those that agree are weighted by their errors, those
/// that do not alike. The standard error is DerSimonian and Laird's, the interval Hartung and Knapp's. `None` without any.
#[must_use]
pub fn mean(estimates: &[Estimate]) -> Option<Mean> {
    let groups = [estimates];
    let weighted = Weighted::new(&groups, between_variance(&groups).unwrap_or(0.0));
    let (value, sum) = weighted.groups[0]?;
    let std = sum.sqrt().recip();
    let reach = weighted.deviations() * std * weighted.inflation().sqrt();
    Some(Mean {
        value,
        std,
        interval95: [value - reach, value + reach],
        n: estimates.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn of(values: &[(f64, f64)]) -> Vec<Estimate> {
        let each = values.iter().map(|&(value, std)| Estimate::new(value, std));
        each.map(Option::unwrap).collect()
    }

    #[test]
    fn estimates_that_agree_are_weighted_by_their_errors_and_those_that_do_not_alike() {
        assert_eq!(mean(&[]), None);
        let one = mean(&of(&[(3.0, 0.1)])).unwrap();
        assert_eq!((one.value, one.n), (3.0, 1));
        assert_relative_eq!(
            one.interval95[1],
            3.0 + 0.1 * WITHIN_95,
            max_relative = 1e-12
        );
        let agreeing = mean(&of(&[(1.0, 0.05), (1.05, 0.1)])).unwrap();
        assert_relative_eq!(agreeing.value, 1.01, max_relative = 1e-12);
        assert_relative_eq!(agreeing.std, 500_f64.sqrt().recip(), max_relative = 1e-12);
        let apart = mean(&of(&[(0.0, 0.03), (1.4, 0.06)])).unwrap();
        assert_relative_eq!(apart.value, 0.7, max_relative = 0.01);
        assert_relative_eq!(apart.std, 0.7, max_relative = 0.01);
        // With two estimates, Student's t with one degree of freedom: 12.7 errors.
        assert_relative_eq!(
            apart.interval95[1] - apart.value,
            12.706 * 0.7,
            max_relative = 0.01
        );
    }

    /// Log relative risks of 13 trials of a vaccine against tuberculosis, with their variances, and what metafor for R makes of
    /// them with `method = "DL"` (Viechtbauer 2010).
    #[test]
    fn the_mean_and_what_is_between_are_those_of_a_published_example() {
        let trials = [
            (-0.8893, 0.3256),
            (-1.5854, 0.1946),
            (-1.3481, 0.4154),
            (-1.4416, 0.0200),
            (-0.2175, 0.0512),
            (-0.7861, 0.0069),
            (-1.6209, 0.2230),
            (0.0120, 0.0040),
            (-0.4694, 0.0564),
            (-1.3713, 0.0730),
            (-0.3394, 0.0124),
            (0.4459, 0.5325),
            (-0.0173, 0.0714),
        ]
        .map(|(value, variance): (f64, f64)| (value, variance.sqrt()));
        let trials = of(&trials);
        assert_relative_eq!(
            between_variance(&[&trials]).unwrap(),
            0.3088,
            max_relative = 2e-3
        );
        let pooled = mean(&trials).unwrap();
        assert_relative_eq!(pooled.value, -0.7141, max_relative = 1e-3);
        assert_relative_eq!(pooled.std, 0.1787, max_relative = 1e-3);
    }
}
