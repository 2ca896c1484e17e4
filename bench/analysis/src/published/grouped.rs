//! Instances in groups: by exploration, trial and participant.

use std::collections::BTreeMap;

use contact::AssumedConstants;
use num_complex::Complex64;

use super::statistic::{Found, Level, Pairs, Statistic};
use crate::analysed::{Analysed, RecordingFindings};
use crate::estimate::{Estimated, InstanceAnalysis, InstanceBy, Method};
use crate::statistics::{Coefficient, r_squared, r_squared_complex, slope, spread};

/// Value of an instance.
pub(super) type OfInstance = fn(&InstanceAnalysis, &Estimated) -> f64;
/// Value of a sample of an instance.
pub type OfSample = fn(&InstanceBy<'_>, usize) -> f64;

/// All instances by one method.
pub(super) struct Pool<'a> {
    /// Constants of the skin; `None` if each estimate has its own.
    assumed: Option<AssumedConstants>,
    trials: Vec<Group<'a>>,
    participants: BTreeMap<&'a str, Group<'a>>,
}

/// Explorations of a trial or of a participant.
#[derive(Default)]
struct Group<'a> {
    /// Number of the participant, from 0; `None` if unknown.
    person: Option<usize>,
    explorations: Vec<Exploration<'a>>,
}

/// Instances of an exploration, at least one.
#[derive(Clone)]
struct Exploration<'a>(Vec<InstanceBy<'a>>);

impl<'a> Pool<'a> {
    pub(super) fn new(analysed: &'a Analysed, method: Method) -> Self {
        let mut participants: BTreeMap<&str, Group<'_>> = BTreeMap::new();
        let mut trials = Vec::new();
        for found in analysed.findings() {
            let instances = found.instances.iter();
            let instances: Vec<_> = instances.filter_map(|of| of.by(method)).collect();
            if instances.is_empty() {
                continue;
            }
            let explorations: Vec<_> = instances
                .chunk_by(|a, b| a.instance.exploration == b.instance.exploration)
                .map(|of| Exploration(of.to_vec()))
                .collect();
            let person = RecordingFindings::participant(found).map(|id| {
                let number = participants.len();
                let of = participants.entry(id).or_insert_with(|| Group {
                    person: Some(number),
                    explorations: Vec::new(),
                });
                of.explorations.extend(explorations.iter().cloned());
                of.person.unwrap_or(number)
            });
            trials.push(Group {
                person,
                explorations,
            });
        }
        let settings = &analysed.settings;
        Self {
            assumed: (method != Method::Trial).then(|| settings.assumed()),
            trials,
            participants,
        }
    }

    pub(super) fn skin(&self, estimated: &Estimated) -> AssumedConstants {
        self.assumed.unwrap_or(estimated.skin)
    }

    pub(super) fn spread(&self, value: impl Fn(&InstanceAnalysis, &Estimated) -> f64) -> Found {
        let over = |level, groups: &mut dyn Iterator<Item = &Group<'_>>| {
            Statistic::spread(level, groups.map(|group| group.mean(&value)))
        };
        let instances = self.trials.iter().flat_map(|t| t.values(&value));
        Found {
            main: Statistic::spread(Level::Instances, instances),
            also: vec![
                over(Level::Trials, &mut self.trials.iter()),
                over(Level::Participants, &mut self.participants.values()),
            ],
        }
    }

    /// Returns the spread over the instances of the participant with the (lower) median mean; over none if no
    /// participant is known.
    pub(super) fn typical_participant(&self, value: OfInstance) -> Found {
        let mut participants: Vec<_> = self.participants.values().collect();
        let mean = |of: &Group<'_>| of.mean(value);
        participants.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        let typical = participants.get(participants.len().saturating_sub(1) / 2);
        let values = typical.map(|p| p.values(value));
        Found::alone(Statistic::spread(
            Level::Instances,
            values.unwrap_or_default(),
        ))
    }

    /// Returns the spread of `statistic` over trials.
    fn over_trials(&self, statistic: impl Fn(&Group<'a>) -> f64) -> Found {
        let each = self.trials.iter().map(statistic);
        Found::alone(Statistic::spread(Level::Trials, each))
    }

    /// Returns the median of `statistic` over trials.
    fn median_trial(&self, statistic: impl Fn(&Group<'a>) -> f64) -> Found {
        let mut values: Vec<f64> = self.trials.iter().map(statistic).collect();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        Found {
            main: Statistic {
                value: crate::model_check::quantile(&values, 0.5),
                n: values.len(),
                ..Statistic::none(Level::Trials)
            },
            also: vec![Statistic::spread(Level::Trials, values)],
        }
    }

    pub(super) fn median_trial_mean(&self, value: OfInstance) -> Found {
        self.median_trial(|trial| trial.mean(value))
    }

    /// Returns R² of the impedance modelled with the participant's average σ_t, with the samples of a trial together.
    pub(super) fn r2_averaged(&self) -> Found {
        self.median_trial(|trial| trial.r2_averaged())
    }

    /// Returns Spearman's coefficient of a sampled quantity and the measured friction within the median trial.
    pub(super) fn sampled_in_median_trial(&self, value: OfSample) -> Found {
        self.median_trial(|trial| trial.sampled(value))
    }

    /// Returns Spearman's coefficient of a sampled quantity and the measured friction within each trial.
    pub(super) fn sampled_within_trials(&self, value: OfSample) -> Found {
        self.over_trials(|trial| trial.sampled(value))
    }

    /// Returns Spearman's coefficient, within each trial, of the ranges (maximum minus minimum) of two quantities in an
    /// instance. The published ranges are those of explorations, but a trial has only two of them.
    pub(super) fn ranges_within_trials(&self, x: OfSample, y: OfSample) -> Found {
        self.over_trials(|trial| {
            let of = |value| trial.ranges_of_instances(value);
            let found = Coefficient::Spearman.of(&of(x), &of(y));
            found.map_or(f64::NAN, |correlation| correlation.rho)
        })
    }

    /// Correlates the means of two quantities over the instances of a trial.
    pub(super) fn correlate(
        &self,
        coefficient: Coefficient,
        x: OfInstance,
        y: OfInstance,
    ) -> Found {
        let means = |group: &Group<'_>| (group.mean(x), group.mean(y));
        let instances = self.pairs_of(|trial| {
            let of = |value: OfInstance| trial.values(value);
            of(x).into_iter().zip(of(y)).collect()
        });
        self.correlations(coefficient, &means, (Level::Instances, instances))
    }

    /// Correlates the ranges (maximum minus minimum) of two quantities in an exploration; for a trial or participant, their
    /// means over the explorations.
    pub(super) fn correlate_ranges(
        &self,
        coefficient: Coefficient,
        x: OfSample,
        y: OfSample,
    ) -> Found {
        let explorations = self.pairs_of(|trial| {
            let of = |value: OfSample| trial.ranges(value);
            of(x).into_iter().zip(of(y)).collect()
        });
        self.correlations(
            coefficient,
            &|group| self.mean_ranges(group, x, y),
            (Level::Explorations, explorations),
        )
    }

    /// Returns the slope of `y` on `x`, each the range (maximum minus minimum) in an exploration, averaged over a trial's
    /// explorations.
    pub(super) fn slope_of_ranges(&self, x: OfSample, y: OfSample) -> Found {
        let over = |level, groups: &mut dyn Iterator<Item = &Group<'_>>| {
            let (x, y): (Vec<f64>, Vec<f64>) =
                groups.map(|group| self.mean_ranges(group, x, y)).unzip();
            let found = slope(&x, &y);
            Statistic {
                value: found.map(|line| line.slope),
                std: found.and_then(|line| line.std),
                n: found.map_or(x.len(), |line| line.n),
                ..Statistic::none(level)
            }
        };
        Found {
            main: over(Level::Trials, &mut self.trials.iter()),
            also: vec![over(Level::Participants, &mut self.participants.values())],
        }
    }

    /// Returns R² of the estimated against the measured friction about the line of slope 1, with all samples together.
    pub(super) fn r2_mu(&self) -> Found {
        let instances = || self.trials.iter().flat_map(Group::instances);
        let measured: Vec<f64> = instances()
            .flat_map(|of| of.instance.samples.mu().iter().copied())
            .collect();
        let estimated: Vec<f64> = instances()
            .flat_map(|of| of.estimated.series.mu.iter().copied())
            .collect();
        Found::alone(Statistic {
            value: r_squared(&measured, &estimated),
            n: measured.len(),
            ..Statistic::none(Level::Samples)
        })
    }

    /// Returns the largest deviation of Z_t from the mean of a trial, relative to the modulus of the mean.
    pub(super) fn drift_of_z_t(&self) -> Found {
        self.over_trials(|trial| trial.departures_of_z_t().fold(f64::NAN, f64::max))
    }

    /// Returns the standard deviation of Z_t within a trial, relative to the modulus of its mean.
    pub(super) fn variation_of_z_t(&self) -> Found {
        self.over_trials(|trial| {
            let parts: Vec<f64> = trial.departures_of_z_t().collect();
            let freedom = parts.len().checked_sub(1).map_or(f64::NAN, |n| n as f64);
            (parts.iter().map(|part| part * part).sum::<f64>() / freedom).sqrt()
        })
    }

    pub(super) fn changes_by_trial(&self, x: OfSample, y: OfSample) -> Vec<(f64, f64)> {
        let each = self.trials.iter();
        each.map(|trial| self.mean_ranges(trial, x, y)).collect()
    }

    pub(super) fn changes_by_instance(&self, x: OfSample, y: OfSample) -> Vec<(f64, f64)> {
        let of = |trial: &Group<'_>, value| trial.ranges_of_instances(value);
        let pairs = |trial| of(trial, x).into_iter().zip(of(trial, y));
        self.trials.iter().flat_map(pairs).collect()
    }

    fn mean_ranges(&self, group: &Group<'_>, x: OfSample, y: OfSample) -> (f64, f64) {
        let mean = |value| spread(group.ranges(value)).map_or(f64::NAN, |s| s.mean);
        (mean(x), mean(y))
    }

    /// Returns the pairs of all trials, each with its person.
    fn pairs_of(&self, pairs: impl Fn(&Group<'a>) -> Vec<(f64, f64)>) -> Pairs {
        let mut found = Pairs {
            people: Some(Vec::new()),
            ..Pairs::default()
        };
        for trial in &self.trials {
            for (x, y) in pairs(trial) {
                found.x.push(x);
                found.y.push(y);
                found.people = found.people.zip(trial.person).map(|(mut people, person)| {
                    people.push(person);
                    people
                });
            }
        }
        found
    }

    fn correlations(
        &self,
        coefficient: Coefficient,
        of_group: &dyn Fn(&Group<'_>) -> (f64, f64),
        (finest, pairs): (Level, Pairs),
    ) -> Found {
        let trials = self.pairs_of(|trial| vec![of_group(trial)]);
        let (x, y) = self.participants.values().map(of_group).unzip();
        let participants = Pairs { x, y, people: None };
        let of = |over, pairs| Statistic::correlation(over, coefficient, &pairs);
        Found {
            main: of(Level::Trials, trials),
            also: vec![of(finest, pairs), of(Level::Participants, participants)],
        }
    }
}

impl<'a> Group<'a> {
    fn instances(&self) -> impl Iterator<Item = InstanceBy<'a>> {
        self.explorations.iter().flat_map(|of| of.0.iter().copied())
    }

    fn values(&self, value: impl Fn(&InstanceAnalysis, &Estimated) -> f64) -> Vec<f64> {
        self.instances()
            .map(|of| value(of.instance, of.estimated))
            .collect()
    }

    fn mean(&self, value: impl Fn(&InstanceAnalysis, &Estimated) -> f64) -> f64 {
        spread(self.values(value)).map_or(f64::NAN, |spread| spread.mean)
    }

    fn ranges(&self, value: OfSample) -> Vec<f64> {
        let each = self.explorations.iter();
        each.map(|of| of.range(value)).collect()
    }

    fn ranges_of_instances(&self, value: OfSample) -> Vec<f64> {
        let each = self.instances().map(|of| Exploration(vec![of]));
        each.map(|one| one.range(value)).collect()
    }

    /// Returns Spearman's coefficient of a sampled quantity and the measured friction, with all instances together.
    fn sampled(&self, value: OfSample) -> f64 {
        let (x, y): (Vec<f64>, Vec<f64>) = self
            .instances()
            .flat_map(|of| {
                let mu = of.instance.samples.mu();
                (0..mu.len()).map(move |k| (value(&of, k), mu[k]))
            })
            .unzip();
        Coefficient::Spearman
            .of(&x, &y)
            .map_or(f64::NAN, |correlation| correlation.rho)
    }

    fn r2_averaged(&self) -> f64 {
        let (mut measured, mut modelled) = (Vec::<Complex64>::new(), Vec::<Complex64>::new());
        for of in self.instances() {
            let Some(model) = &of.estimated.averaged.series else {
                return f64::NAN;
            };
            measured.extend(of.z_m());
            modelled.extend(&model.z_m_n_s_per_m);
        }
        r_squared_complex(&measured, &modelled)
    }

    /// Returns |Z_t − mean|/|mean| of each instance; empty for fewer than two.
    fn departures_of_z_t(&self) -> impl Iterator<Item = f64> {
        let z_t: Vec<Complex64> = self
            .instances()
            .map(|of| of.estimated.z_t_n_s_per_m)
            .collect();
        let mean = z_t.iter().sum::<Complex64>() / z_t.len() as f64;
        let several = z_t.len() > 1;
        z_t.into_iter()
            .filter(move |_| several)
            .map(move |z| (z - mean).norm() / mean.norm())
    }
}

impl Exploration<'_> {
    /// Returns the maximum minus the minimum of a sampled quantity; NaN without a finite value.
    fn range(&self, value: OfSample) -> f64 {
        let samples = self
            .0
            .iter()
            .flat_map(|of| (0..of.instance.samples.mu().len()).map(move |k| value(of, k)));
        let (least, greatest) = samples
            .filter(|value| value.is_finite())
            .fold((f64::NAN, f64::NAN), |(least, greatest), value| {
                (value.min(least), value.max(greatest))
            });
        greatest - least
    }
}
