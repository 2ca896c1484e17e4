//! Instances in groups: of the study, of each condition, participant and trial; likewise explorations without instances.
//!
//! Each mean counts the units of the level below once: a trial's is over its instances, a participant's over the means of the
//! trials, that of a condition or of the study over the means of the participants. Where a participant is not known, the mean of a
//! condition or of the study is over trials.

use std::collections::BTreeSet;

use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::mean::Mean;
use crate::quantity::Quantity;
use crate::trial_key::TrialKey;

/// Level of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// All recordings.
    Study,
    /// Recordings of a condition.
    Condition,
    /// Recordings of a participant.
    Participant,
    /// Recordings of a participant in a condition.
    ParticipantInCondition,
    /// A trial.
    Trial,
}

impl Level {
    /// Returns its name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Study => "study",
            Self::Condition => "condition",
            Self::Participant => "participant",
            Self::ParticipantInCondition => "participant in condition",
            Self::Trial => "trial",
        }
    }
}

/// Unit that a mean counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Instances.
    Instances,
    /// Explorations.
    Explorations,
    /// Means of trials.
    Trials,
    /// Means of participants.
    Participants,
}

impl Unit {
    /// Returns its name in files, in the plural.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Instances => "instances",
            Self::Explorations => "explorations",
            Self::Trials => "trials",
            Self::Participants => "participants",
        }
    }

    /// Returns a number of units in words.
    #[must_use]
    pub fn count(self, n: usize) -> String {
        let name = self.name();
        match n {
            1 => format!("1 {}", &name[..name.len() - 1]),
            n => format!("{n} {name}"),
        }
    }
}

/// Group of instances, or of explorations, with its means.
#[derive(Debug, Clone, PartialEq)]
pub struct Group<const N: usize = { Quantity::ALL.len() }> {
    /// Level of the group.
    pub level: Level,
    /// Participant; `None` for a group of several, or an unknown one.
    pub participant: Option<String>,
    /// Condition, if the group has only one.
    pub condition: Option<String>,
    /// Identity of the trial, for a group that is one.
    pub trial: Option<TrialKey>,
    /// Unit that the means count.
    pub over: Unit,
    /// Means in the order of [`Quantity::ALL`], or of [`StrokeQuantity::ALL`](crate::strokes::StrokeQuantity::ALL).
    pub means: [Mean; N],
    /// Unit that the mean of a trial counts.
    pub of: Unit,
    /// Number of instances, or of explorations.
    pub n_instances: usize,
    /// Number of trials with instances.
    pub n_trials: usize,
    /// Number of known participants with instances.
    pub n_participants: usize,
    /// Number of sessions with instances.
    pub n_sessions: usize,
}

impl Group {
    /// Returns the mean of a quantity.
    #[must_use]
    pub fn mean(&self, quantity: Quantity) -> &Mean {
        let mut means = Quantity::ALL.iter().zip(&self.means);
        let mean = means.find_map(|(candidate, mean)| (*candidate == quantity).then_some(mean));
        mean.unwrap_or(&self.means[0])
    }
}

impl<const N: usize> Group<N> {
    /// Returns the number of units with friction, which every described instance and exploration has.
    #[must_use]
    pub fn n(&self) -> usize {
        self.means.first().map_or(0, |mean| mean.n)
    }
}

impl Serialize for Group {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("level", self.level.name())?;
        map.serialize_entry("participant", &self.participant)?;
        map.serialize_entry("condition", &self.condition)?;
        if let Some(trial) = &self.trial {
            map.serialize_entry("session", &trial.session)?;
            map.serialize_entry("trial", &trial.trial)?;
            map.serialize_entry("attempt", &trial.attempt)?;
        }
        map.serialize_entry("over", self.over.name())?;
        map.serialize_entry("n", &self.n())?;
        map.serialize_entry("n_instances", &self.n_instances)?;
        for (quantity, mean) in Quantity::ALL.into_iter().zip(&self.means) {
            map.serialize_entry(quantity.names().value, mean)?;
        }
        map.end()
    }
}

/// Values of the instances of a trial, or of its explorations.
pub(crate) struct Trial<const N: usize> {
    pub(crate) key: TrialKey,
    pub(crate) instances: Vec<[f64; N]>,
}

impl<const N: usize> Trial<N> {
    fn means(&self) -> [Mean; N] {
        means(&self.instances)
    }
}

fn means<const N: usize>(values: &[[f64; N]]) -> [Mean; N] {
    std::array::from_fn(|index| Mean::new(values.iter().map(|value| value[index])))
}

/// Returns the values of each mean.
fn values<const N: usize>(means: [Mean; N]) -> [f64; N] {
    means.map(|mean| mean.value)
}

/// Returns the groups of trials whose means are over a unit.
pub(crate) fn groups<const N: usize>(trials: &[Trial<N>], of: Unit) -> Vec<Group<N>> {
    let all: Vec<&Trial<N>> = trials.iter().collect();
    let conditions: BTreeSet<&str> = trials.iter().map(|trial| &*trial.key.condition).collect();
    let people: BTreeSet<Option<&str>> = trials
        .iter()
        .map(|trial| trial.key.participant.as_deref())
        .collect();
    let of_condition = |trials: &[&'_ Trial<N>], condition: &str| -> Vec<usize> {
        let numbers = trials.iter().enumerate();
        let numbers = numbers.filter(|(_, trial)| trial.key.condition == condition);
        numbers.map(|(number, _)| number).collect()
    };
    let mut groups = vec![group(Level::Study, &all, of)];
    if conditions.len() > 1 {
        groups.extend(conditions.iter().map(|condition| {
            let numbers = of_condition(&all, condition);
            let members: Vec<&Trial<N>> = numbers.iter().map(|number| all[*number]).collect();
            group(Level::Condition, &members, of)
        }));
    }
    for person in people {
        let is_theirs = |trial: &&Trial<N>| trial.key.participant.as_deref() == person;
        let members: Vec<&Trial<N>> = all.iter().copied().filter(is_theirs).collect();
        if person.is_some() {
            groups.push(group(Level::Participant, &members, of));
            for condition in conditions.iter().filter(|_| conditions.len() > 1) {
                let numbers = of_condition(&members, condition);
                let members: Vec<&Trial<N>> =
                    numbers.iter().map(|number| members[*number]).collect();
                if !members.is_empty() {
                    groups.push(group(Level::ParticipantInCondition, &members, of));
                }
            }
        }
        groups.extend(
            members
                .iter()
                .map(|trial| group(Level::Trial, &[trial], of)),
        );
    }
    groups
}

fn group<const N: usize>(level: Level, trials: &[&Trial<N>], of: Unit) -> Group<N> {
    let described: Vec<&Trial<N>> = trials
        .iter()
        .copied()
        .filter(|trial| !trial.instances.is_empty())
        .collect();
    let people: BTreeSet<&str> = described
        .iter()
        .filter_map(|trial| trial.key.participant.as_deref())
        .collect();
    let all_known = described
        .iter()
        .all(|trial| trial.key.participant.is_some());
    let trial_means = |trials: &[&Trial<N>]| -> Vec<_> {
        trials.iter().map(|trial| values(trial.means())).collect()
    };
    let (over, means) = match level {
        Level::Trial => {
            let instances: Vec<_> = described
                .iter()
                .flat_map(|trial| &trial.instances)
                .copied()
                .collect();
            (of, means(&instances))
        }
        Level::Study | Level::Condition if all_known => {
            let person_means = people.iter().map(|person| {
                let is_theirs =
                    |trial: &&&Trial<N>| trial.key.participant.as_deref() == Some(*person);
                let theirs: Vec<&Trial<N>> = described.iter().filter(is_theirs).copied().collect();
                values(means(&trial_means(&theirs)))
            });
            (Unit::Participants, means(&person_means.collect::<Vec<_>>()))
        }
        _ => (Unit::Trials, means(&trial_means(&described))),
    };
    let first = trials.first().map(|trial| &trial.key);
    let is_of_one = matches!(
        level,
        Level::Participant | Level::ParticipantInCondition | Level::Trial
    );
    let one_condition = first.map(|key| &key.condition).filter(|condition| {
        trials
            .iter()
            .all(|trial| trial.key.condition == **condition)
    });
    let sessions: BTreeSet<(Option<&str>, i64)> = described
        .iter()
        .map(|trial| (trial.key.participant.as_deref(), trial.key.session))
        .collect();
    Group {
        level,
        participant: first
            .filter(|_| is_of_one)
            .and_then(|key| key.participant.clone()),
        condition: one_condition.cloned(),
        trial: first.filter(|_| level == Level::Trial).cloned(),
        over,
        means,
        of,
        n_instances: described.iter().map(|trial| trial.instances.len()).sum(),
        n_trials: described.len(),
        n_participants: people.len(),
        n_sessions: sessions.len(),
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn trial(
        participant: Option<&str>,
        number: i64,
        condition: &str,
        falls: &[f64],
    ) -> Trial<{ Quantity::ALL.len() }> {
        Trial {
            key: TrialKey {
                participant: participant.map(str::to_owned),
                session: 1,
                trial: number,
                attempt: 1,
                condition: condition.to_owned(),
            },
            instances: falls
                .iter()
                .map(|fall| [*fall; Quantity::ALL.len()])
                .collect(),
        }
    }

    fn fall<'a>(groups: &'a [Group], level: Level, participant: Option<&str>) -> &'a Mean {
        let is_it =
            |group: &&Group| group.level == level && group.participant.as_deref() == participant;
        groups.iter().find(is_it).unwrap().mean(Quantity::Fall)
    }

    /// A participant with many instances must not outweigh one with few.
    #[test]
    fn each_level_counts_the_units_of_the_level_below_once() {
        let trials = [
            trial(Some("a"), 1, "slow", &[0.9; 10]),
            trial(Some("a"), 2, "fast", &[0.8, 0.6]),
            trial(Some("b"), 1, "slow", &[0.5]),
            trial(Some("b"), 2, "fast", &[]),
        ];
        let groups = groups(&trials, Unit::Instances);
        let person = fall(&groups, Level::Participant, Some("a"));
        assert_relative_eq!(person.value, 0.8, max_relative = 1e-12);
        assert_eq!(person.n, 2);
        let study = fall(&groups, Level::Study, None);
        assert_relative_eq!(study.value, 0.65, max_relative = 1e-12);
        assert_eq!((study.n, groups[0].over), (2, Unit::Participants));
        // b's second trial has no instance, so b's interval has nothing to be over.
        let person = fall(&groups, Level::Participant, Some("b"));
        assert_eq!((person.n, person.interval95), (1, None));
        let conditions = groups
            .iter()
            .filter(|group| group.level == Level::Condition);
        let conditions: Vec<_> = conditions
            .map(|group| {
                (
                    group.condition.as_deref(),
                    group.mean(Quantity::Fall).value,
                    group.n(),
                )
            })
            .collect();
        assert_relative_eq!(conditions[0].1, 0.7, max_relative = 1e-12);
        assert_eq!((conditions[0].0, conditions[0].2), (Some("fast"), 1));
        assert_eq!((conditions[1].0, conditions[1].2), (Some("slow"), 2));
        let empty = groups
            .iter()
            .find(|group| group.level == Level::Trial && group.n() == 0);
        assert_eq!(empty.unwrap().participant.as_deref(), Some("b"));
    }

    #[test]
    fn an_unknown_participant_makes_the_study_a_mean_over_trials() {
        let trials = [
            trial(None, 1, "", &[0.9, 0.7]),
            trial(Some("a"), 1, "", &[0.6]),
        ];
        let groups = groups(&trials, Unit::Instances);
        assert_eq!((groups[0].over, groups[0].n()), (Unit::Trials, 2));
        assert_relative_eq!(
            groups[0].mean(Quantity::Fall).value,
            0.7,
            max_relative = 1e-12
        );
        assert!(groups.iter().all(|group| group.level != Level::Condition));
    }
}
