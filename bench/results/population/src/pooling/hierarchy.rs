//! Pooling of estimates on two levels: members of a group (trials of a participant) and groups (participants of a study).
//!
//! True values are normally distributed: members about their group's mean with a variance common to all groups, and group
//! means about the overall mean with another. All groups contribute to the variance between members, so a group's
//! interval has the degrees of freedom of all groups; a group with significantly larger scatter has a separate variance.
//!
//! Members that agree better than their errors allow share a part of these errors: a law that no trial constrains is
//! marginalised in each trial, and its error is the same in all. Averaging does not reduce the shared part.
//!
//! A part of the errors may be stated as common to all members of all groups. It moves all values in the same direction, so it
//! shows in no scatter; each interval of a value includes it, and those of the variation do not.

use statistics::NORMAL_95;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::pooling::estimate::Estimate;
use crate::pooling::mean::{Weighted, between_variance, student95};
use crate::pooling::scatter::{Scatter, bisect};

/// Pooled estimates of groups.
#[derive(Debug, Clone, PartialEq)]
pub struct Hierarchy {
    /// Standard deviation between the members of a group beyond their errors, common to all groups without a separate
    /// one; `None` if no group has two members, and then the groups' intervals include only the members' errors.
    pub between_members_std: Option<f64>,
    /// Fraction of the variance of the members' errors that a group's members share; 0 without evidence of sharing.
    pub shared_error: f64,
    /// Groups in the given order; `None` without members.
    pub groups: Vec<Option<Group>>,
    /// All groups together; `None` with fewer than two groups.
    pub overall: Option<Overall>,
}

/// Mean with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// Standard error of the mean.
    pub std: f64,
    /// 95 % interval of the mean.
    pub interval95: [f64; 2],
    /// Number of estimates.
    pub n: usize,
}

/// Group of members.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Mean of its members.
    pub mean: Mean,
    /// Standard deviation between its members beyond their errors, as used in its interval; `None` if it cannot be
    /// estimated.
    pub between_members_std: Option<f64>,
    /// Mean shrunken towards that of all groups; `None` with too few groups to estimate the shrinkage.
    pub shrunken: Option<Shrunken>,
    /// Members shrunken towards the group's mean; `None` with too few members in all groups to estimate the shrinkage.
    pub members: Option<Vec<Shrunken>>,
}

/// Estimate shrunken towards a mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shrunken {
    /// Shrunken value.
    pub value: f64,
    /// 95 % interval.
    pub interval95: [f64; 2],
}

/// All groups together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overall {
    /// Mean of the groups.
    pub mean: Mean,
    /// Standard deviation between groups beyond the errors of their means.
    pub between_std: f64,
    /// Its 95 % interval, by the Q profile (Viechtbauer 2007) with the quantiles of F, since the means' errors are
    /// estimated.
    pub between_std_interval95: [f64; 2],
}

/// Pools the estimates of each group, and the groups.
#[must_use]
pub fn hierarchy<G: AsRef<[Estimate]>>(groups: &[G]) -> Hierarchy {
    let common = Scatter::common(groups);
    let means = groups.iter().map(|group| {
        let group = group.as_ref();
        let scatter = common.group_scatter(group);
        let estimate = scatter.mean(group)?;
        let mean = Mean::with_interval(estimate, scatter.deviations(), group.len());
        Some((mean, estimate, scatter))
    });
    let means: Vec<Option<(Mean, Estimate, Scatter)>> = means.collect();
    let group_estimates: Vec<Estimate> = means.iter().flatten().map(|group| group.1).collect();
    let overall = overall(&group_estimates, common.freedom);
    let overall_target = overall.map(|(overall, mean)| ShrinkageTarget {
        mean,
        between: overall.between_std.powi(2),
        freedom: group_estimates.len() - 1,
    });
    let pooled_group = |(pooled, group): (&Option<(Mean, Estimate, Scatter)>, &G)| {
        let (mean, estimate, scatter) = (*pooled)?;
        // A Student interval is treated as a normal one with the same width.
        let widening = scatter.deviations() / NORMAL_95;
        let estimate = Estimate::new(mean.value, widening * estimate.own_std())?
            .with_common_error(estimate.common_std());
        let shrunken_mean = overall_target
            .as_ref()
            .and_then(|target| target.shrink(estimate));
        let target = ShrinkageTarget {
            mean: shrunken_mean.unwrap_or(estimate),
            between: scatter.between,
            freedom: scatter.freedom,
        };
        let members = group
            .as_ref()
            .iter()
            .map(|&member| target.shrink(member).map(Shrunken::from));
        Some(Group {
            mean,
            between_members_std: (scatter.freedom > 0).then(|| scatter.between.sqrt()),
            shrunken: shrunken_mean.map(Shrunken::from),
            members: members.collect(),
        })
    };
    Hierarchy {
        between_members_std: (common.freedom > 0).then(|| common.between.sqrt()),
        shared_error: common.shared,
        groups: means.iter().zip(groups).map(pooled_group).collect(),
        overall: overall.map(|(overall, _)| overall),
    }
}

impl Mean {
    /// Makes the mean with an interval of so many `deviations` of its own error. The common error is normal; the half-widths of
    /// the two parts add in quadrature, because they are independent.
    fn with_interval(mean: Estimate, deviations: f64, n: usize) -> Self {
        let value = mean.value();
        let reach = (deviations * mean.own_std()).hypot(NORMAL_95 * mean.common_std());
        Self {
            value,
            std: mean.std(),
            interval95: [value - reach, value + reach],
            n,
        }
    }
}

impl From<Estimate> for Shrunken {
    fn from(estimate: Estimate) -> Self {
        let (value, reach) = (estimate.value(), NORMAL_95 * estimate.std());
        Self {
            value,
            interval95: [value - reach, value + reach],
        }
    }
}

/// Returns two or more groups together, and their mean; `None` with fewer.
fn overall(groups: &[Estimate], member_freedom: usize) -> Option<(Overall, Estimate)> {
    if groups.len() < 2 {
        return None;
    }
    let between = between_variance(&[groups]).unwrap_or(0.0);
    let weighted = Weighted::new(&[groups], between);
    let mean = weighted.groups[0]?;
    // Hartung and Knapp (2001): var M = Σw (m − M)²/((k − 1) Σw), with w = 1/(var m + T²) and k − 1 degrees of freedom for
    // Student's t, but never less than the errors alone give, 1/Σw.
    let std = (weighted.scatter().max(1.0) / mean.weights).sqrt();
    let mean = Estimate::new(mean.value, std)?.with_common_error(mean.common_std);
    let overall = Overall {
        mean: Mean::with_interval(mean, student95(weighted.freedom), groups.len()),
        between_std: between.sqrt(),
        between_std_interval95: [0.975, 0.025].map(|part| {
            let scatter = quantile(part, groups.len() - 1, member_freedom);
            profile(groups, scatter).sqrt()
        }),
    };
    Some((overall, mean))
}

/// Returns a quantile of the weighted squares of means about their mean, with `freedom` degrees of freedom: of F if the
/// means' errors are themselves estimated, with `member_freedom` degrees of freedom; of χ² otherwise.
fn quantile(part: f64, freedom: usize, member_freedom: usize) -> f64 {
    let n = freedom as f64;
    let f_quantile = FisherSnedecor::new(n, member_freedom as f64).map(|f| n * f.inverse_cdf(part));
    f_quantile
        .unwrap_or_else(|_| ChiSquared::new(n).map_or(f64::NAN, |chi2| chi2.inverse_cdf(part)))
}

/// Returns the variance between groups at which their weighted squares equal `scatter`; 0 if they are smaller even
/// without variance: T² with Q(T²) = Σ (m_i − M)²/(var m_i + T²) = `scatter`. At the true T², Q is distributed like χ² (or F
/// times its degrees of freedom), so its quantiles 0.975 and 0.025 give the lower and the upper end of the interval of T².
fn profile(groups: &[Estimate], scatter: f64) -> f64 {
    let squares_at = |between: f64| Weighted::new(&[groups], between).squares;
    if squares_at(0.0) <= scatter {
        return 0.0;
    }
    // The weighted squares fall to 0 as the variance grows, no later than with equal weights.
    let (mut low, mut high) = (0.0, groups[0].variance());
    while squares_at(high) > scatter && high < f64::MAX / 4.0 {
        (low, high) = (high, 2.0 * high);
    }
    bisect(low, high, |between| squares_at(between) > scatter)
}

/// Mean to shrink estimates towards, by empirical Bayes.
struct ShrinkageTarget {
    mean: Estimate,
    /// Variance of true values about the mean.
    between: f64,
    /// Degrees of freedom of the estimate of this variance.
    freedom: usize,
}

impl ShrinkageTarget {
    /// Returns the shrunken estimate; `None` with fewer than three degrees of freedom.
    ///
    /// The estimate moves by a fraction B of its distance to the mean, where B is the error's fraction of the variance.
    /// Because B is estimated, it is reduced by two degrees of freedom, and a variance of 2 B²/(freedom − 2) times the
    /// squared distance is added (Morris 1983).
    ///
    /// With V the error's variance, A that of true values, ν the degrees of freedom and μ ± s the mean:
    /// ```text
    /// B = (ν − 2)/ν · V/(V + A),    θ = y + B (μ − y),    var θ = (1 − B) V + B² s² + 2/(ν − 2) · B² (μ − y)²
    /// ```
    /// for a known B and μ, for the error of μ, and for that of B. The common errors of y and μ, which have the same direction,
    /// add with the same weights: (1 − B) c_y + B c_μ.
    fn shrink(&self, estimate: Estimate) -> Option<Estimate> {
        let reduced_freedom = self
            .freedom
            .checked_sub(2)
            .filter(|reduced_freedom| *reduced_freedom > 0)? as f64;
        let error = estimate.variance();
        let part = reduced_freedom / self.freedom as f64 * error / (error + self.between);
        let distance = self.mean.value() - estimate.value();
        let value = estimate.value() + part * distance;
        let part_variance = 2.0 / reduced_freedom * (part * distance).powi(2);
        let variance = (1.0 - part) * error + part * part * self.mean.variance() + part_variance;
        let common_std = (1.0 - part) * estimate.common_std() + part * self.mean.common_std();
        Some(Estimate::new(value, variance.sqrt())?.with_common_error(common_std))
    }
}

#[cfg(test)]
mod tests {
    use super::super::estimate::tests::estimates;
    use super::*;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DRAWS: usize = 600;

    /// Population of simulated studies, for example of S in logarithms.
    struct Population {
        people: usize,
        trials: usize,
        between_people: f64,
        between_trials: f64,
        /// Fraction of the errors' variance that the trials of a person share.
        shared: f64,
        /// Standard error that all trials of all people have in common.
        common: f64,
        /// Whether the common error is stated.
        is_common_stated: bool,
    }

    impl Population {
        /// Returns a population without common errors.
        fn new(
            (people, trials): (usize, usize),
            (between_people, between_trials): (f64, f64),
            shared: f64,
        ) -> Self {
            Self {
                people,
                trials,
                between_people,
                between_trials,
                shared,
                common: 0.0,
                is_common_stated: true,
            }
        }
    }

    const MEAN: f64 = -8.5;

    /// Coverage of the intervals.
    #[derive(Debug, Default)]
    struct Coverage {
        study: f64,
        between: f64,
        person: f64,
        shrunken_person: f64,
        shrunken_trial: f64,
        /// Mean squared errors of the trials, raw and shrunken.
        squares: (f64, f64),
    }

    fn coverage(population: &Population) -> Coverage {
        let mut rng = ChaCha8Rng::seed_from_u64(1986);
        let mut normal = |mean: f64, std: f64| {
            let deviate: f64 = StandardNormal.sample(&mut rng);
            mean + std * deviate
        };
        let mut coverage = Coverage::default();
        let (people, trials) = (population.people as f64, population.trials as f64);
        let hit = |interval: [f64; 2], truth: f64| {
            f64::from(u8::from(interval[0] <= truth && truth <= interval[1]))
        };
        for _ in 0..DRAWS {
            let mut truths = Vec::new();
            let mut groups = Vec::new();
            let law = match population.common > 0.0 {
                true => normal(0.0, 1.0),
                false => 0.0,
            };
            for _ in 0..population.people {
                let person = normal(MEAN, population.between_people);
                let common = population.shared.sqrt() * normal(0.0, 1.0);
                let pairs = (0..population.trials).map(|_| {
                    let trial = normal(person, population.between_trials);
                    let error = common + (1.0 - population.shared).sqrt() * normal(0.0, 1.0);
                    // Errors of 3 to 15 %.
                    let std = 0.03 * 5_f64.powf(normal(0.5, 0.25).clamp(0.0, 1.0));
                    // Its size depends on the trial: a law acts more at large amplitudes.
                    let slope = population.common * (1.0 + (std - 0.067) / 0.2);
                    let estimate = Estimate::new(trial + std * error + slope * law, std).unwrap();
                    let stated = f64::from(u8::from(population.is_common_stated)) * slope;
                    (trial, estimate.with_common_error(stated))
                });
                let (trial_truths, group): (Vec<f64>, Vec<Estimate>) = pairs.unzip();
                truths.push((person, trial_truths));
                groups.push(group);
            }
            let pooled = hierarchy(&groups);
            let draws = DRAWS as f64;
            if let Some(overall) = pooled.overall {
                coverage.study += hit(overall.mean.interval95, MEAN) / draws;
                let between = overall.between_std_interval95;
                coverage.between += hit(between, population.between_people) / draws;
            }
            for ((group, (person, trial_truths)), raw) in
                pooled.groups.iter().zip(&truths).zip(&groups)
            {
                let group = group.as_ref().unwrap();
                let people_draws = people * draws;
                coverage.person += hit(group.mean.interval95, *person) / people_draws;
                if let Some(shrunken) = group.shrunken {
                    coverage.shrunken_person += hit(shrunken.interval95, *person) / people_draws;
                }
                let Some(members) = &group.members else {
                    continue;
                };
                for ((member, truth), raw) in members.iter().zip(trial_truths).zip(raw) {
                    coverage.shrunken_trial +=
                        hit(member.interval95, *truth) / (people_draws * trials);
                    coverage.squares.0 += (raw.value() - truth).powi(2);
                    coverage.squares.1 += (member.value - truth).powi(2);
                }
            }
        }
        coverage
    }

    #[test]
    fn intervals_cover_the_truth_of_simulated_populations() {
        for (people, trials, between_people, between_trials, shared) in [
            (3, 4, 0.2, 0.1, 0.0),
            (6, 4, 0.2, 0.1, 0.0),
            (6, 3, 0.1, 0.0, 0.0),
            (14, 10, 0.3, 0.05, 0.0),
            (14, 2, 0.0, 0.1, 0.0),
            (5, 4, 0.3, 0.0, 0.9),
            (14, 10, 0.3, 0.0, 0.5),
        ] {
            let coverage = coverage(&Population::new(
                (people, trials),
                (between_people, between_trials),
                shared,
            ));
            let message = format!("{people} people with {trials} trials: {coverage:?}");
            for part in [coverage.study, coverage.person] {
                assert!((0.92..=0.995).contains(&part), "{message}");
            }
            assert!((0.92..=0.99).contains(&coverage.between), "{message}");
            assert!(
                (0.92..=0.995).contains(&coverage.shrunken_trial),
                "{message}"
            );
            // Shared errors are also in the mean that the trials are shrunken towards.
            let gain = if shared > 0.0 { 1.01 } else { 0.95 };
            assert!(coverage.squares.1 < gain * coverage.squares.0, "{message}");
            if people > 3 {
                assert!(
                    (0.92..=0.995).contains(&coverage.shrunken_person),
                    "{message}"
                );
            }
        }
    }

    /// The error of a law is the same in all trials of all people: it is in the intervals of all means, and no number of trials
    /// makes them shorter than it.
    #[test]
    fn a_common_error_is_in_every_mean_and_does_not_shrink() {
        for (people, trials, between_people, between_trials, shared) in [
            (6, 4, 0.2, 0.1, 0.0),
            (14, 10, 0.1, 0.05, 0.0),
            (14, 10, 0.1, 0.0, 0.5),
        ] {
            let population = Population {
                common: 0.15,
                ..Population::new((people, trials), (between_people, between_trials), shared)
            };
            let stated = coverage(&population);
            let message = format!("{people} people with {trials} trials: {stated:?}");
            for part in [
                stated.study,
                stated.between,
                stated.person,
                stated.shrunken_person,
                stated.shrunken_trial,
            ] {
                assert!((0.92..=0.995).contains(&part), "{message}");
            }
            // Unstated, it is missed.
            let unstated = coverage(&Population {
                is_common_stated: false,
                ..population
            });
            assert!(unstated.study < 0.8, "{unstated:?}");
            assert!(unstated.person < 0.8, "{unstated:?}");
        }
        for trials in [1, 4, 400] {
            let group = || {
                let estimates = estimates(&vec![5.0; trials], 0.1).into_iter();
                let with_error = estimates.map(|estimate| estimate.with_common_error(0.2));
                with_error.collect::<Vec<_>>()
            };
            let groups: Vec<_> = (0..20).map(|_| group()).collect();
            let pooled = hierarchy(&groups);
            let overall = pooled.overall.unwrap().mean;
            let group = pooled.groups[0].as_ref().unwrap();
            for (name, std, [low, high]) in [
                ("study", overall.std, overall.interval95),
                ("person", group.mean.std, group.mean.interval95),
            ] {
                let half_width = 0.5 * (high - low);
                assert!(
                    std >= 0.2 && half_width >= 0.2 * NORMAL_95,
                    "{name} {trials}"
                );
                assert!(
                    half_width < 0.3 * NORMAL_95,
                    "{name} {trials}: {half_width}"
                );
            }
        }
    }

    #[test]
    fn a_single_participant_has_an_interval_of_their_own_trials() {
        let coverage = coverage(&Population::new((1, 4), (0.0, 0.1), 0.0));
        assert!((0.93..=0.98).contains(&coverage.person), "{coverage:?}");
        let pooled = hierarchy(&[estimates(&[5.0, 5.2], 0.01)]);
        assert_eq!(pooled.overall, None);
        let group = pooled.groups[0].as_ref().unwrap();
        assert_eq!((group.shrunken, &group.members), (None, &None));
        // Two values 0.2 apart: the interval of the mean extends beyond t(1) · 0.1.
        assert!(group.mean.interval95[1] > 5.1 + 12.706 * 0.1, "{group:?}");
    }

    #[test]
    fn a_single_trial_keeps_its_error_and_gives_no_scatter() {
        let pooled = hierarchy(&[estimates(&[5.0], 0.1)]);
        assert_eq!(pooled.between_members_std, None);
        let group = pooled.groups[0].as_ref().unwrap();
        assert_relative_eq!(group.mean.interval95[0], 5.0 - 0.1 * NORMAL_95);
        // Next to a group with several trials, it has the variance between these.
        let pooled = hierarchy(&[
            estimates(&[5.0], 0.1),
            estimates(&[4.0, 5.0, 6.0, 5.0, 4.0], 0.1),
        ]);
        let single_group = pooled.groups[0].as_ref().unwrap();
        assert!(single_group.mean.interval95[0] < 4.0, "{single_group:?}");
    }

    #[test]
    fn identical_trials_share_their_errors() {
        let pooled = hierarchy(&[estimates(&[5.0; 4], 0.1), estimates(&[5.0; 4], 0.1)]);
        assert_eq!(pooled.between_members_std, Some(0.0));
        assert!(pooled.shared_error > 0.999_99);
        let overall = pooled.overall.unwrap();
        assert_eq!(
            (overall.between_std, overall.between_std_interval95),
            (0.0, [0.0; 2])
        );
        for group in pooled.groups.iter().flatten() {
            assert_relative_eq!(group.mean.std, 0.1, max_relative = 1e-5);
            for member in group.members.as_ref().unwrap() {
                assert_relative_eq!(member.value, 5.0);
                let reach = member.interval95[1] - 5.0;
                assert!((0.05..0.1).contains(&(reach / NORMAL_95)), "{reach}");
            }
        }
    }

    #[test]
    fn a_participant_without_a_trial_does_not_affect_the_others() {
        let reference_groups = [estimates(&[5.0, 5.2], 0.1), estimates(&[5.5, 5.6], 0.1)];
        let groups = [
            estimates(&[], 0.1),
            reference_groups[0].clone(),
            reference_groups[1].clone(),
        ];
        let (reference, pooled) = (hierarchy(&reference_groups), hierarchy(&groups));
        assert_eq!(pooled.groups[0], None);
        assert_eq!(reference.groups, pooled.groups[1..]);
        assert_eq!(reference.overall, pooled.overall);
        let empty = hierarchy::<Vec<Estimate>>(&[]);
        assert_eq!((empty.overall, empty.groups), (None, Vec::new()));
    }

    /// Errors and distances at the limits of floating point give finite numbers.
    #[test]
    fn extreme_errors_give_finite_means() {
        for std in [1e-12, 1e-3, 1e6] {
            for distance in [0.0, 1e-9, 1.0, 1e6] {
                let pooled = hierarchy(&[
                    estimates(&[0.0, distance], std),
                    estimates(&[distance, 2.0 * distance], std),
                ]);
                let overall = pooled.overall.unwrap();
                let ends = [overall.mean.interval95, overall.between_std_interval95].concat();
                assert!(
                    ends.iter().all(|end| end.is_finite()),
                    "{std} {distance}: {overall:?}"
                );
                assert!(overall.between_std_interval95[0] <= overall.between_std + 1e-9 * distance);
            }
        }
    }
}
