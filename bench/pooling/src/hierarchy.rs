//! Two levels above the estimates: members of a group (trials of a participant), groups of the whole (participants of a
//! study).
//!
//! A member's true value scatters about its group's with one variance in all groups, and a group's about the whole's
//! with another, all normal. A group's interval has the degrees of freedom of all groups together, since all of them
//! tell the variance between members; a group that scatters by more than the others can has a variance of its own.
//!
//! Members that agree better than their errors allow share a part of these: a law that no trial tells is marginalised
//! in each, and is wrong by the same in all. The mean of many has that part as one has it.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::estimate::Estimate;
use crate::mean::{WITHIN_95, Weighted, between_variance, student95};
use crate::scatter::{Scatter, bisect};

/// Estimates in their groups, pooled.
#[derive(Debug, Clone, PartialEq)]
pub struct Hierarchy {
    /// Standard deviation between the members of a group beyond their errors, the same in all but those that differ;
    /// `None` where no group has two, and then the groups' intervals hold the members' errors alone.
    pub between_members_std: Option<f64>,
    /// Part of the variance of the members' errors that those of a group have in common; 0 where none shows.
    pub shared_error: f64,
    /// The groups, in the order in which they were given; `None` without members.
    pub groups: Vec<Option<Group>>,
    /// The whole; `None` with fewer than two groups.
    pub overall: Option<Overall>,
}

/// A mean with its 95 % interval.
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

/// A group.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Mean of its members.
    pub mean: Mean,
    /// Standard deviation between its members beyond their errors, as its interval has it; `None` where nothing tells
    /// it.
    pub between_members_std: Option<f64>,
    /// The mean, drawn towards that of all groups; `None` with too few groups to tell by how much.
    pub shrunken: Option<Shrunken>,
    /// Its members, drawn towards its mean; `None` with too few members of all groups to tell by how much.
    pub members: Option<Vec<Shrunken>>,
}

/// An estimate that has been drawn towards others of its kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shrunken {
    /// The value.
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
    /// 95 % interval of it, by the Q profile (Viechtbauer 2007) with the quantiles of F, since the means' errors are
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
        // What is known with Student's distribution is taken for as much less known.
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
    // Hartung and Knapp (2001), and never less than the errors alone allow.
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

/// Returns a quantile of the weighted squares of means about their mean: of F, as far as the means' errors are
/// themselves estimated, with so many degrees of freedom; of χ² where they are not.
fn quantile(part: f64, freedom: usize, freedom_within: usize) -> f64 {
    let n = freedom as f64;
    let of_f = FisherSnedecor::new(n, freedom_within as f64).map(|f| n * f.inverse_cdf(part));
    of_f.unwrap_or_else(|_| ChiSquared::new(n).map_or(f64::NAN, |of| of.inverse_cdf(part)))
}

/// Returns the variance between groups at which their weighted squares are `scatter`; 0 where they are less even
/// without any.
fn profile(groups: &[Estimate], scatter: f64) -> f64 {
    let apart = |between: f64| Weighted::new(&[groups], between).apart;
    if apart(0.0) <= scatter {
        return 0.0;
    }
    // Falls to 0 with the variance, at the latest as that of equal weights does.
    let (mut low, mut high) = (0.0, groups[0].variance());
    while apart(high) > scatter && high < f64::MAX / 4.0 {
        (low, high) = (high, 2.0 * high);
    }
    bisect(low, high, |between| apart(between) > scatter)
}

/// Mean that estimates are drawn towards, by empirical Bayes.
struct Towards {
    /// The mean and the variance of its error.
    mean: (f64, f64),
    /// Variance of true values about the mean.
    between: f64,
    /// Degrees of freedom that this variance was estimated from.
    freedom: usize,
}

impl Towards {
    /// Returns value and variance of the drawn estimate; `None` with fewer than three degrees of freedom.
    ///
    /// Part B of the way is gone, B the error's share of the variance. That B is itself estimated makes it less by two
    /// degrees of freedom, and adds a variance of 2 B²/(freedom − 2) times the squared distance (Morris 1983).
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

    /// Population that studies are drawn from: S in logarithms, say.
    struct Population {
        people: usize,
        trials: usize,
        between_people: f64,
        between_trials: f64,
        /// Part of the errors' variance that the trials of a person share.
        shared: f64,
    }

    const MEAN: f64 = -8.5;

    /// How often the truth was in each interval.
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
            // Errors that are shared are in what they are drawn to as well.
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
        // Two values 0.2 apart: a mean within more than t(1) · 0.1.
        assert!(group.mean.interval95[1] > 5.1 + 12.706 * 0.1, "{group:?}");
    }

    #[test]
    fn one_trial_alone_keeps_its_own_error_and_nothing_is_known_between() {
        let found = hierarchy(&[of(&[5.0], 0.1)]);
        assert_eq!(found.between_members_std, None);
        let group = found.groups[0].as_ref().unwrap();
        assert_relative_eq!(group.mean.interval95[0], 5.0 - 0.1 * WITHIN_95);
        // Beside somebody with several trials, it has what is between theirs.
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

    /// Errors and distances from the least to the greatest of floating point give numbers.
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
