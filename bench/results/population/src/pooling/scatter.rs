//! Scatter of members about their group's mean: larger or smaller than their errors explain.

use statistics::NORMAL_95;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::pooling::estimate::Estimate;
use crate::pooling::mean::{Weighted, between_variance, student95};

/// Quantile of the common scatter's distribution above which a group has a separate scatter.
const SEPARATE_QUANTILE: f64 = 0.99;
/// Largest shared fraction; closer to 1, rounding errors would count as scatter.
const MAX_SHARED: f64 = 1.0 - 1e-6;

/// Scatter of the members of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatter {
    /// Variance between members beyond that of their errors.
    pub(crate) between: f64,
    /// Fraction of the variance of their errors that they share; 0 if there is any variance between members.
    pub(crate) shared: f64,
    /// Degrees of freedom of the estimate.
    pub(crate) freedom: usize,
}

impl Scatter {
    /// Returns the scatter common to all groups.
    ///
    /// At this scatter, the probabilities of a scatter no larger than each group's average one half, weighted by degrees
    /// of freedom: Σ_i ν_i \[F(Q_i) − ½\] = 0, where Q_i = Σ_j (y_ij − m_i)²/(σ_ij² + τ²), F is its distribution, that of χ² with
    /// ν_i = n_i − 1, and with the shared fraction ρ the narrower one of [`probability`](Self::probability) if the sum is
    /// negative even at τ² = 0. A group with extreme scatter affects it by no more than its weight; a moment estimator would
    /// follow it.
    pub(crate) fn common<G: AsRef<[Estimate]>>(groups: &[G]) -> Self {
        let has_several = |group: &&[Estimate]| group.len() > 1;
        let groups: Vec<&[Estimate]> = groups
            .iter()
            .map(AsRef::as_ref)
            .filter(has_several)
            .collect();
        let freedom = groups.iter().map(|group| freedom(group)).sum();
        let surplus = |scatter: &Self| -> f64 {
            let all_groups = groups.iter();
            all_groups
                .map(|group| freedom_f64(group) * (scatter.probability(group) - 0.5))
                .sum()
        };
        let zero = Self {
            between: 0.0,
            shared: 0.0,
            freedom,
        };
        if surplus(&zero) > 0.0 {
            let scatter_with = |between| Self { between, ..zero };
            let mut limit = groups.iter().map(|group| spread(group)).fold(0.0, f64::max);
            while surplus(&scatter_with(limit)) > 0.0 && limit < f64::MAX / 4.0 {
                limit *= 2.0;
            }
            scatter_with(bisect(0.0, limit, |between| {
                surplus(&scatter_with(between)) > 0.0
            }))
        } else if freedom > 0 {
            let scatter_with = |shared| Self { shared, ..zero };
            scatter_with(bisect(0.0, MAX_SHARED, |shared| {
                surplus(&scatter_with(shared)) < 0.0
            }))
        } else {
            zero
        }
    }

    /// Returns this scatter, or the group's separate scatter if that is significantly larger.
    pub(crate) fn group_scatter(self, group: &[Estimate]) -> Self {
        let has_others = self.freedom > freedom(group);
        if group.len() > 1 && has_others && self.probability(group) > SEPARATE_QUANTILE {
            return Self {
                between: between_variance(&[group]).unwrap_or(0.0),
                shared: 0.0,
                freedom: freedom(group),
            };
        }
        self
    }

    /// Returns the probability of a scatter no larger than the group's.
    fn probability(&self, group: &[Estimate]) -> f64 {
        // With z_j = (y_ij − θ_i)/σ_ij the covariance of z is (1 − ρ) I + ρ 1 1ᵀ, and Q = zᵀ (I − u uᵀ) z with u_j ∝ 1/σ_ij. The
        // part of 1 along u moves only the mean; the rest has the square d = n − (Σ1/σ)²/Σ1/σ², 0 for equal σ. Therefore
        // Q = (1 − ρ) χ²_(ν−1) + (1 − ρ + ρ d) χ²_1. A scaled χ² has its mean and variance (Satterthwaite 1946); it is exact for
        // equal σ, and for two members.
        let weighted = Weighted::new(&[group], self.between);
        let along_mean =
            weighted.groups[0].map_or(0.0, |mean| mean.weights * mean.shared_std.powi(2));
        let independent = 1.0 - self.shared;
        let unequal = independent + self.shared * (group.len() as f64 - along_mean).max(0.0);
        let others = freedom_f64(group) - 1.0;
        let mean = independent * others + unequal;
        let half_variance = independent.powi(2) * others + unequal.powi(2);
        let distribution = ChiSquared::new(mean.powi(2) / half_variance);
        distribution.map_or(0.5, |distribution| {
            distribution.cdf(weighted.squares * mean / half_variance)
        })
    }

    /// Returns mean and standard error of a group.
    ///
    /// m = Σwy/Σw with w = 1/(σ² + τ²) has the variance (1 − ρ)/Σw + ρ (Σwσ/Σw)²: of the independent and of the shared part. Its
    /// common error is Σwc/Σw, regardless of the number of members.
    pub(crate) fn mean(&self, group: &[Estimate]) -> Option<Estimate> {
        let group_mean = Weighted::new(&[group], self.between).groups[0]?;
        let shared = if group.len() > 1 { self.shared } else { 0.0 };
        let variance = (1.0 - shared) / group_mean.weights + shared * group_mean.shared_std.powi(2);
        let mean = Estimate::new(group_mean.value, variance.sqrt())?;
        Some(mean.with_common_error(group_mean.common_std))
    }

    /// Returns the half-width of the 95 % interval of a mean in standard errors: Student's if the variance between
    /// members is estimated, the normal distribution's if the members' errors explain all of the scatter.
    pub(crate) fn deviations(&self) -> f64 {
        match self.between > 0.0 {
            true => student95(self.freedom),
            false => NORMAL_95,
        }
    }
}

fn freedom(group: &[Estimate]) -> usize {
    group.len().saturating_sub(1)
}

fn freedom_f64(group: &[Estimate]) -> f64 {
    freedom(group) as f64
}

/// Returns the squared distance between the two most distant members, at least an error's variance.
fn spread(group: &[Estimate]) -> f64 {
    let values = || group.iter().map(|estimate| estimate.value());
    let distance = values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min);
    let variances = group.iter().map(|estimate| estimate.variance());
    variances.fold(distance * distance, f64::max)
}

/// Returns the point at which `is_below` turns from true to false.
pub(crate) fn bisect(mut low: f64, mut high: f64, is_below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if is_below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::super::estimate::tests::estimates;
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn one_group_scatters_by_the_median_of_its_distribution() {
        // 0.4549 is the median of χ² with one degree of freedom: 0.5²/(2 · (0.1² + τ²)).
        let scatter = Scatter::common(&[estimates(&[0.0, 0.5], 0.1)]);
        assert_relative_eq!(
            scatter.between,
            0.125 / 0.454_936 - 0.01,
            max_relative = 1e-5
        );
        assert_eq!((scatter.shared, scatter.freedom), (0.0, 1));
        // Half a standard error apart: 0.05²/(2 · 0.1²) = 0.125.
        let scatter = Scatter::common(&[estimates(&[0.0, 0.05], 0.1)]);
        assert_relative_eq!(scatter.shared, 1.0 - 0.125 / 0.454_936, max_relative = 1e-5);
        assert_eq!(scatter.between, 0.0);
    }

    #[test]
    fn an_outlying_group_has_a_separate_scatter() {
        let typical = || estimates(&[0.0, 0.01, -0.01, 0.0], 0.1);
        let outlier = estimates(&[5.0, -5.0, 4.0, -4.0], 0.1);
        let groups = [typical(), typical(), typical(), typical(), outlier.clone()];
        let common = Scatter::common(&groups);
        assert!(common.between == 0.0 && common.shared > 0.8, "{common:?}");
        assert_eq!(common.group_scatter(&groups[0]), common);
        let separate = common.group_scatter(&outlier);
        assert!(
            separate.between > 10.0 && separate.freedom == 3,
            "{separate:?}"
        );
        // A single group determines the common scatter.
        let single = Scatter::common(std::slice::from_ref(&outlier));
        assert_eq!(single.group_scatter(&outlier), single);
    }

    /// Regression test: with standard errors of 1 : 2 : 3, a shared fraction of 0.6 was read as 0.44.
    #[test]
    fn the_shared_fraction_of_unequal_errors_is_found() {
        use rand_chacha::rand_core::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(17);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        for (shared, stds) in [(0.6_f64, [1.0, 2.0, 3.0]), (0.8, [1.0, 1.0, 2.0])] {
            let mut group = || -> Vec<Estimate> {
                let common = shared.sqrt() * normal();
                let members = stds.map(|std| {
                    let error = common + (1.0 - shared).sqrt() * normal();
                    Estimate::new(std * error, std)
                });
                members.into_iter().flatten().collect()
            };
            let groups: Vec<Vec<Estimate>> = (0..4000).map(|_| group()).collect();
            let scatter = Scatter::common(&groups);
            assert_relative_eq!(scatter.shared, shared, epsilon = 0.04);
        }
    }

    #[test]
    fn scatter_needs_a_group_of_two() {
        let scatter = Scatter::common(&[estimates(&[1.0], 0.1), estimates(&[], 0.1)]);
        assert_eq!(
            (scatter.between, scatter.shared, scatter.freedom),
            (0.0, 0.0, 0)
        );
        assert_eq!(
            scatter.mean(&estimates(&[1.0], 0.1)),
            Estimate::new(1.0, 0.1)
        );
    }
}
