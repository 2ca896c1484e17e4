//! Pooling of estimates on two levels: members of a group (trials of a participant) and groups (participants of a study).
//!
//! True values are normally distributed: members about their group's mean with a variance common to all groups, and group
//! means about the overall mean with another. All groups contribute to the variance between members, so a group's
//! interval has the degrees of freedom of all groups; a group with significantly larger scatter has a separate variance.
//!
//! Members that agree better than their errors allow share a part of these errors: a law that no trial constrains is
//! marginalised in each trial, and its error is the same in all. Averaging does not reduce the shared part.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::estimate::Estimate;
use crate::mean::{WITHIN_95, Weighted, between_variance, student95};
use crate::scatter::{Scatter, bisect};

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
        let scatter = common.of(group);
        let estimate = scatter.mean(group)?;
        let (value, std) = (estimate.value(), estimate.std());
        let mean = Mean::within(value, std, scatter.deviations(), group.len());
        Some((mean, estimate, scatter))
    });
    let means: Vec<Option<(Mean, Estimate, Scatter)>> = means.collect();
    let of_groups: Vec<Estimate> = means.iter().flatten().map(|of| of.1).collect();
    let overall = (of_groups.len() > 1).then(|| overall(&of_groups, common.freedom));
    let to_whole = overall.map(|of| Towards {
        mean: (of.mean.value, of.mean.std.powi(2)),
        between: of.between_std.powi(2),
        freedom: of_groups.len() - 1,
    });
    let of_group = |(of, group): (&Option<(Mean, Estimate, Scatter)>, &G)| {
        let (mean, estimate, scatter) = (*of)?;
        // A Student interval is treated as a normal one with the same width.
        let wider = scatter.deviations() / WITHIN_95;
        let estimate = Estimate::new(mean.value, wider * estimate.std())?;
        let drawn = to_whole.as_ref().and_then(|towards| towards.draw(estimate));
        let (centre, variance) = drawn.unwrap_or((mean.value, estimate.variance()));
        let towards = Towards {
            mean: (centre, variance),
            between: scatter.between,
            freedom: scatter.freedom,
        };
        let members = group
            .as_ref()
            .iter()
            .map(|&of| towards.draw(of).map(shrunken));
        Some(Group {
            mean,
            between_members_std: (scatter.freedom > 0).then(|| scatter.between.sqrt()),
            shrunken: drawn.map(shrunken),
            members: members.collect(),
        })
    };
    Hierarchy {
        between_members_std: (common.freedom > 0).then(|| common.between.sqrt()),
        shared_error: common.shared,
        groups: means.iter().zip(groups).map(of_group).collect(),
        overall,
    }
}

impl Mean {
    fn within(value: f64, std: f64, deviations: f64, n: usize) -> Self {
        let reach = deviations * std;
        Self {
            value,
            std,
            interval95: [value - reach, value + reach],
            n,
        }
    }
}

fn shrunken((value, variance): (f64, f64)) -> Shrunken {
    let reach = WITHIN_95 * variance.sqrt();
    Shrunken {
        value,
        interval95: [value - reach, value + reach],
    }
}

fn overall(groups: &[Estimate], freedom_within: usize) -> Overall {
    let between = between_variance(&[groups]).unwrap_or(0.0);
    let weighted = Weighted::new(&[groups], between);
    let of = weighted.groups[0].map_or((f64::NAN, f64::NAN), |of| (of.value, of.weights));
    // Hartung and Knapp (2001), but never less than the errors alone give.
    let std = (weighted.scatter().max(1.0) / of.1).sqrt();
    Overall {
        mean: Mean::within(of.0, std, student95(weighted.freedom), groups.len()),
        between_std: between.sqrt(),
        between_std_interval95: [0.975, 0.025].map(|part| {
            let scatter = quantile(part, groups.len() - 1, freedom_within);
            profile(groups, scatter).sqrt()
        }),
    }
}

/// Returns a quantile of the weighted squares of means about their mean, with `freedom` degrees of freedom: of F if the
/// means' errors are themselves estimated, with `freedom_within` degrees of freedom; of χ² otherwise.
fn quantile(part: f64, freedom: usize, freedom_within: usize) -> f64 {
    let n = freedom as f64;
    let of_f = FisherSnedecor::new(n, freedom_within as f64).map(|f| n * f.inverse_cdf(part));
    of_f.unwrap_or_else(|_| ChiSquared::new(n).map_or(f64::NAN, |of| of.inverse_cdf(part)))
}

/// Returns the variance between groups at which their weighted squares equal `scatter`; 0 if they are smaller even
/// without variance.
fn profile(groups: &[Estimate], scatter: f64) -> f64 {
    let apart = |between: f64| Weighted::new(&[groups], between).apart;
    if apart(0.0) <= scatter {
        return 0.0;
    }
    // The weighted squares fall to 0 as the variance grows, no later than with equal weights.
    let (mut low, mut high) = (0.0, groups[0].variance());
    while apart(high) > scatter && high < f64::MAX / 4.0 {
        (low, high) = (high, 2.0 * high);
    }
    bisect(low, high, |between| apart(between) > scatter)
}

/// Mean to shrink estimates towards, by empirical Bayes.
struct Towards {
    /// The mean and the variance of its error.
    mean: (f64, f64),
    /// Variance of true values about the mean.
    between: f64,
    /// Degrees of freedom of the estimate of this variance.
    freedom: usize,
}

impl Towards {
    /// Returns value and variance of the shrunken estimate; `None` with fewer than three degrees of freedom.
    ///
    /// The estimate moves by a fraction B of its distance to the mean, where B is the error's fraction of the variance.
    /// Because B is estimated, it is reduced by two degrees of freedom, and a variance of 2 B²/(freedom − 2) times the
    /// squared distance is added (Morris 1983).
    fn draw(&self, estimate: Estimate) -> Option<(f64, f64)> {
        let left = self.freedom.checked_sub(2).filter(|left| *left > 0)? as f64;
        let error = estimate.variance();
        let part = left / self.freedom as f64 * error / (error + self.between);
        let distance = self.mean.0 - estimate.value();
        let value = estimate.value() + part * distance;
        let of_part = 2.0 / left * (part * distance).powi(2);
        let variance = (1.0 - part) * error + part * part * self.mean.1 + of_part;
        Some((value, variance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DRAWS: usize = 600;

    fn of(values: &[f64], std: f64) -> Vec<Estimate> {
        let each = values.iter().map(|&value| Estimate::new(value, std));
        each.map(Option::unwrap).collect()
    }

    /// Population of simulated studies, for example of S in logarithms.
    struct Population {
        people: usize,
        trials: usize,
        between_people: f64,
        between_trials: f64,
        /// Fraction of the errors' variance that the trials of a person share.
        shared: f64,
    }

    const MEAN: f64 = -8.5;

    /// Coverage of the intervals.
    #[derive(Debug, Default)]
    struct Held {
        study: f64,
        between: f64,
        person: f64,
        shrunken_person: f64,
        shrunken_trial: f64,
        /// Mean squared errors of the trials, raw and shrunken.
        squares: (f64, f64),
    }

    fn held(population: &Population) -> Held {
        let mut rng = ChaCha8Rng::seed_from_u64(1986);
        let mut normal = |mean: f64, std: f64| {
            let drawn: f64 = StandardNormal.sample(&mut rng);
            mean + std * drawn
        };
        let mut held = Held::default();
        let (people, trials) = (population.people as f64, population.trials as f64);
        let inside = |interval: [f64; 2], truth: f64| {
            f64::from(u8::from(interval[0] <= truth && truth <= interval[1]))
        };
        for _ in 0..DRAWS {
            let mut truths = Vec::new();
            let mut groups = Vec::new();
            for _ in 0..population.people {
                let person = normal(MEAN, population.between_people);
                let common = population.shared.sqrt() * normal(0.0, 1.0);
                let each = (0..population.trials).map(|_| {
                    let trial = normal(person, population.between_trials);
                    let error = common + (1.0 - population.shared).sqrt() * normal(0.0, 1.0);
                    // Errors of 3 to 15 %.
                    let std = 0.03 * 5_f64.powf(normal(0.5, 0.25).clamp(0.0, 1.0));
                    (trial, Estimate::new(trial + std * error, std).unwrap())
                });
                let (of_trials, group): (Vec<f64>, Vec<Estimate>) = each.unzip();
                truths.push((person, of_trials));
                groups.push(group);
            }
            let found = hierarchy(&groups);
            let draws = DRAWS as f64;
            if let Some(overall) = found.overall {
                held.study += inside(overall.mean.interval95, MEAN) / draws;
                let between = overall.between_std_interval95;
                held.between += inside(between, population.between_people) / draws;
            }
            for ((group, (person, of_trials)), raw) in found.groups.iter().zip(&truths).zip(&groups)
            {
                let group = group.as_ref().unwrap();
                let each = people * draws;
                held.person += inside(group.mean.interval95, *person) / each;
                if let Some(shrunken) = group.shrunken {
                    held.shrunken_person += inside(shrunken.interval95, *person) / each;
                }
                let Some(members) = &group.members else {
                    continue;
                };
                for ((member, truth), raw) in members.iter().zip(of_trials).zip(raw) {
                    held.shrunken_trial += inside(member.interval95, *truth) / (each * trials);
                    held.squares.0 += (raw.value() - truth).powi(2);
                    held.squares.1 += (member.value - truth).powi(2);
                }
            }
        }
        held
    }

    #[test]
    fn intervals_hold_the_truth_of_drawn_populations() {
        for (people, trials, between_people, between_trials, shared) in [
            (3, 4, 0.2, 0.1, 0.0),
            (6, 4, 0.2, 0.1, 0.0),
            (6, 3, 0.1, 0.0, 0.0),
            (14, 10, 0.3, 0.05, 0.0),
            (14, 2, 0.0, 0.1, 0.0),
            (5, 4, 0.3, 0.0, 0.9),
            (14, 10, 0.3, 0.0, 0.5),
        ] {
            let held = held(&Population {
                people,
                trials,
                between_people,
                between_trials,
                shared,
            });
            let said = format!("{people} people with {trials} trials: {held:?}");
            for part in [held.study, held.person] {
                assert!((0.92..=0.995).contains(&part), "{said}");
            }
            assert!((0.92..=0.99).contains(&held.between), "{said}");
            assert!((0.92..=0.995).contains(&held.shrunken_trial), "{said}");
            // Shared errors are also in the mean that the trials are shrunken towards.
            let gain = if shared > 0.0 { 1.01 } else { 0.95 };
            assert!(held.squares.1 < gain * held.squares.0, "{said}");
            if people > 3 {
                assert!((0.92..=0.995).contains(&held.shrunken_person), "{said}");
            }
        }
    }

    #[test]
    fn a_single_participant_has_an_interval_of_their_own_trials() {
        let held = held(&Population {
            people: 1,
            trials: 4,
            between_people: 0.0,
            between_trials: 0.1,
            shared: 0.0,
        });
        assert!((0.93..=0.98).contains(&held.person), "{held:?}");
        let found = hierarchy(&[of(&[5.0, 5.2], 0.01)]);
        assert_eq!(found.overall, None);
        let group = found.groups[0].as_ref().unwrap();
        assert_eq!((group.shrunken, &group.members), (None, &None));
        // Two values 0.2 apart: the interval of the mean extends beyond t(1) · 0.1.
        assert!(group.mean.interval95[1] > 5.1 + 12.706 * 0.1, "{group:?}");
    }

    #[test]
    fn one_trial_alone_keeps_its_own_error_and_nothing_is_known_between() {
        let found = hierarchy(&[of(&[5.0], 0.1)]);
        assert_eq!(found.between_members_std, None);
        let group = found.groups[0].as_ref().unwrap();
        assert_relative_eq!(group.mean.interval95[0], 5.0 - 0.1 * WITHIN_95);
        // Next to a group with several trials, it has the variance between these.
        let found = hierarchy(&[of(&[5.0], 0.1), of(&[4.0, 5.0, 6.0, 5.0, 4.0], 0.1)]);
        let wider = found.groups[0].as_ref().unwrap();
        assert!(wider.mean.interval95[0] < 4.0, "{wider:?}");
    }

    #[test]
    fn trials_that_agree_entirely_share_their_errors_and_the_mean_is_known_no_better_than_one() {
        let found = hierarchy(&[of(&[5.0; 4], 0.1), of(&[5.0; 4], 0.1)]);
        assert_eq!(found.between_members_std, Some(0.0));
        assert!(found.shared_error > 0.999_99);
        let overall = found.overall.unwrap();
        assert_eq!(
            (overall.between_std, overall.between_std_interval95),
            (0.0, [0.0; 2])
        );
        for group in found.groups.iter().flatten() {
            assert_relative_eq!(group.mean.std, 0.1, max_relative = 1e-5);
            for member in group.members.as_ref().unwrap() {
                assert_relative_eq!(member.value, 5.0);
                let reach = member.interval95[1] - 5.0;
                assert!((0.05..0.1).contains(&(reach / WITHIN_95)), "{reach}");
            }
        }
    }

    #[test]
    fn a_participant_without_a_trial_is_none_and_changes_nobody_else() {
        let others = [of(&[5.0, 5.2], 0.1), of(&[5.5, 5.6], 0.1)];
        let beside = [of(&[], 0.1), others[0].clone(), others[1].clone()];
        let (alone, beside) = (hierarchy(&others), hierarchy(&beside));
        assert_eq!(beside.groups[0], None);
        assert_eq!(alone.groups, beside.groups[1..]);
        assert_eq!(alone.overall, beside.overall);
        let nobody = hierarchy::<Vec<Estimate>>(&[]);
        assert_eq!((nobody.overall, nobody.groups), (None, Vec::new()));
    }

    /// Errors and distances at the limits of floating point give finite numbers.
    #[test]
    fn extreme_errors_give_finite_means() {
        for std in [1e-12, 1e-3, 1e6] {
            for apart in [0.0, 1e-9, 1.0, 1e6] {
                let found = hierarchy(&[of(&[0.0, apart], std), of(&[apart, 2.0 * apart], std)]);
                let overall = found.overall.unwrap();
                let ends = [overall.mean.interval95, overall.between_std_interval95].concat();
                assert!(
                    ends.iter().all(|end| end.is_finite()),
                    "{std} {apart}: {overall:?}"
                );
                assert!(overall.between_std_interval95[0] <= overall.between_std + 1e-9 * apart);
            }
        }
    }
}
