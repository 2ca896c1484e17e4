//! Mean of estimates at one level.

use statistics::NORMAL_95;
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::pooling::estimate::Estimate;

/// Groups of estimates, weighted within each group by precision.
pub(crate) struct Weighted {
    /// Means of the groups; `None` without members.
    pub(crate) groups: Vec<Option<GroupMean>>,
    /// Weighted squares about the means; with the right weights, their expectation is the number of degrees of freedom.
    pub(crate) squares: f64,
    /// Increase of [`squares`](Self::squares) per variance between members.
    growth: f64,
    /// Degrees of freedom.
    pub(crate) freedom: usize,
}

/// Weighted mean of a group.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroupMean {
    pub(crate) value: f64,
    /// Sum of the weights.
    pub(crate) weights: f64,
    /// Weighted mean of the members' own standard errors: the standard error of the mean if the members share their error.
    pub(crate) shared_std: f64,
    /// Weighted mean of the members' common standard errors.
    ///
    /// For laws k with the errors δ_k ~ N(0, 1) and slopes g_jk, the common error of member j is Σ_k g_jk δ_k, with the standard
    /// error c_j = |g_j|. That of the mean is |Σ w_j g_j|/Σw ≤ Σ w_j c_j/Σw, by the triangle inequality; equal if all g_j have
    /// the same direction.
    pub(crate) common_std: f64,
}

impl Weighted {
    /// Weights estimates by their errors and the variance `between` them.
    pub(crate) fn new<G: AsRef<[Estimate]>>(groups: &[G], between: f64) -> Self {
        let mut weighted = Self {
            groups: Vec::with_capacity(groups.len()),
            squares: 0.0,
            growth: 0.0,
            freedom: 0,
        };
        for group in groups {
            let group = group.as_ref();
            let weight = |estimate: &Estimate| (estimate.variance() + between).recip();
            let weights: f64 = group.iter().map(weight).sum();
            let mean = |value: fn(Estimate) -> f64| {
                group
                    .iter()
                    .map(|estimate| weight(estimate) * value(*estimate))
                    .sum::<f64>()
                    / weights
            };
            let value = mean(Estimate::value);
            weighted.groups.push((!group.is_empty()).then(|| GroupMean {
                value,
                weights,
                shared_std: mean(Estimate::own_std),
                common_std: mean(Estimate::common_std),
            }));
            if group.len() > 1 {
                let square =
                    |estimate: &Estimate| weight(estimate) * (estimate.value() - value).powi(2);
                // Q = Σw (y − ȳ)² with w = 1/σ²: if the values scatter by τ² in addition, ⟨Q⟩ = n − 1 + τ² (Σw − Σw²/Σw).
                let squared_weights: f64 =
                    group.iter().map(|estimate| weight(estimate).powi(2)).sum();
                weighted.squares += group.iter().map(square).sum::<f64>();
                weighted.growth += weights - squared_weights / weights;
                weighted.freedom += group.len() - 1;
            }
        }
        weighted
    }

    /// Returns the weighted squares divided by their degrees of freedom, or 1 with zero degrees of freedom.
    pub(crate) fn scatter(&self) -> f64 {
        match self.freedom {
            0 => 1.0,
            freedom => self.squares / freedom as f64,
        }
    }
}

/// Returns the half-width of the 95 % interval of Student's distribution with `freedom` degrees of freedom.
pub(crate) fn student95(freedom: usize) -> f64 {
    let student = StudentsT::new(0.0, 1.0, freedom as f64);
    student.map_or(NORMAL_95, |student| student.inverse_cdf(0.975))
}

/// Returns the variance between estimates of a group beyond that of their errors (DerSimonian and Laird 1986, with their
/// moment summed over groups); `None` if no group has two estimates.
pub(crate) fn between_variance<G: AsRef<[Estimate]>>(groups: &[G]) -> Option<f64> {
    let weighted = Weighted::new(groups, 0.0);
    let surplus = weighted.squares - weighted.freedom as f64;
    // τ² = (Q − ν)/Σ(Σw − Σw²/Σw), the value with ⟨Q⟩ = Q; 0 instead of a negative one.
    (weighted.freedom > 0).then(|| (surplus / weighted.growth).max(0.0))
}

/// Returns the mean, with its standard error, of estimates whose own errors are independent and may scatter by more than these
/// (DerSimonian and Laird 1986): estimates that agree are weighted by their errors, others nearly equally. `None` without
/// estimates.
#[must_use]
pub fn mean(estimates: &[Estimate]) -> Option<Estimate> {
    let groups = [estimates];
    let weighted = Weighted::new(&groups, between_variance(&groups).unwrap_or(0.0));
    let group_mean = weighted.groups[0]?;
    let mean = Estimate::new(group_mean.value, group_mean.weights.sqrt().recip())?;
    Some(mean.with_common_error(group_mean.common_std))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn estimates(values: &[(f64, f64)]) -> Vec<Estimate> {
        let estimates = values.iter().map(|&(value, std)| Estimate::new(value, std));
        estimates.map(Option::unwrap).collect()
    }

    #[test]
    fn concordant_estimates_are_weighted_by_their_errors_and_discordant_ones_equally() {
        assert_eq!(mean(&[]), None);
        assert_eq!(mean(&estimates(&[(3.0, 0.1)])), Estimate::new(3.0, 0.1));
        let concordant = mean(&estimates(&[(1.0, 0.05), (1.05, 0.1)])).unwrap();
        assert_relative_eq!(concordant.value(), 1.01, max_relative = 1e-12);
        assert_relative_eq!(
            concordant.std(),
            500_f64.sqrt().recip(),
            max_relative = 1e-12
        );
        let discordant = mean(&estimates(&[(0.0, 0.03), (1.4, 0.06)])).unwrap();
        assert_relative_eq!(discordant.value(), 0.7, max_relative = 0.01);
        assert_relative_eq!(discordant.std(), 0.7, max_relative = 0.01);
    }

    /// Log relative risks of 13 trials of a vaccine against tuberculosis, with their variances, and the results of
    /// metafor for R with `method = "DL"` (Viechtbauer 2010).
    #[test]
    fn mean_and_between_variance_match_a_published_example() {
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
        let trials = estimates(&trials);
        assert_relative_eq!(
            between_variance(&[&trials]).unwrap(),
            0.3088,
            max_relative = 2e-3
        );
        let pooled = mean(&trials).unwrap();
        assert_relative_eq!(pooled.value(), -0.7141, max_relative = 1e-3);
        assert_relative_eq!(pooled.std(), 0.1787, max_relative = 1e-3);
    }
}
