//! Instances in groups: by exploration, trial and participant.

use std::collections::BTreeMap;

use num_complex::Complex64;

use crate::statistic::{Level, MethodStatistic, Pairs, Statistic};
use analysis::MuAgreement;
use analysis::estimate::{InstanceAnalysis, InstanceEstimate, Method, MethodEstimate};
use analysis::findings::{Analysis, RecordingFindings};
use analysis::sample_statistics::SampleStatistics;
use analysis::sampled_quantity::{Extent, SampledQuantity};
use correlations::{Coefficient, slope, spread};

/// Value of an instance.
pub(super) type InstanceValue = fn(&InstanceAnalysis, &InstanceEstimate) -> f64;
/// Statistic over the samples of a recording.
pub(super) type SampleValue = fn(&SampleStatistics) -> f64;

/// All instances by one method.
pub(super) struct Pool<'a> {
    trials: Vec<Group<'a>>,
    agreement: MuAgreement,
    participants: BTreeMap<&'a str, Group<'a>>,
}

/// Explorations of a trial or of a participant.
#[derive(Default)]
struct Group<'a> {
    /// Number of the participant, from 0; `None` if unknown.
    person: Option<usize>,
    explorations: Vec<Exploration<'a>>,
    /// Statistics over the samples of a trial.
    samples: SampleStatistics,
}

/// Instances of an exploration, at least one.
#[derive(Clone)]
struct Exploration<'a>(Vec<MethodEstimate<'a>>);

impl<'a> Pool<'a> {
    pub(super) fn new(analysed: &'a Analysis, method: Method) -> Self {
        let mut participants: BTreeMap<&str, Group<'_>> = BTreeMap::new();
        let mut trials = Vec::new();
        for findings in analysed.findings() {
            let instances = findings.instances.iter();
            let instances: Vec<_> = instances
                .filter_map(|instance| instance.estimate_by(method))
                .collect();
            if instances.is_empty() {
                continue;
            }
            let explorations: Vec<_> = instances
                .chunk_by(|a, b| a.instance.exploration == b.instance.exploration)
                .map(|fits| Exploration(fits.to_vec()))
                .collect();
            let person = RecordingFindings::participant(findings).map(|id| {
                let number = participants.len();
                let group = participants.entry(id).or_insert_with(|| Group {
                    person: Some(number),
                    ..Group::default()
                });
                group.explorations.extend(explorations.iter().cloned());
                group.person.unwrap_or(number)
            });
            trials.push(Group {
                person,
                explorations,
                samples: *findings.sample_statistics.get(method),
            });
        }
        Self {
            trials,
            participants,
            agreement: *analysed.agreement.get(method),
        }
    }

    pub(super) fn spread(
        &self,
        value: impl Fn(&InstanceAnalysis, &InstanceEstimate) -> f64,
    ) -> MethodStatistic {
        let level_spread = |level, groups: &mut dyn Iterator<Item = &Group<'_>>| {
            Statistic::spread(level, groups.map(|group| group.mean(&value)))
        };
        let instances = self.trials.iter().flat_map(|t| t.values(&value));
        MethodStatistic {
            main: Statistic::spread(Level::Instances, instances),
            also: vec![
                level_spread(Level::Trials, &mut self.trials.iter()),
                level_spread(Level::Participants, &mut self.participants.values()),
            ],
        }
    }

    /// Returns the spread over the instances of the participant with the (lower) median mean; over none if no
    /// participant is known.
    pub(super) fn typical_participant(&self, value: InstanceValue) -> MethodStatistic {
        let mut participants: Vec<_> = self.participants.values().collect();
        let mean = |participant: &Group<'_>| participant.mean(value);
        participants.sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        let median_participant = participants.get(participants.len().saturating_sub(1) / 2);
        let values = median_participant.map(|p| p.values(value));
        MethodStatistic::single(Statistic::spread(
            Level::Instances,
            values.unwrap_or_default(),
        ))
    }

    /// Returns the spread of `statistic` over trials.
    fn spread_over_trials(&self, statistic: impl Fn(&Group<'a>) -> f64) -> MethodStatistic {
        let values = self.trials.iter().map(statistic);
        MethodStatistic::single(Statistic::spread(Level::Trials, values))
    }

    /// Returns the median of `statistic` over trials.
    fn median_trial(&self, statistic: impl Fn(&Group<'a>) -> f64) -> MethodStatistic {
        let mut values: Vec<f64> = self.trials.iter().map(statistic).collect();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        MethodStatistic {
            main: Statistic {
                value: statistics::quantile(&values, 0.5),
                n: values.len(),
                ..Statistic::empty(Level::MedianTrial)
            },
            also: vec![Statistic::spread(Level::Trials, values)],
        }
    }

    pub(super) fn median_trial_mean(&self, value: InstanceValue) -> MethodStatistic {
        self.median_trial(|trial| trial.mean(value))
    }

    /// Returns R² of the impedance modelled with the participant's average σ_t, with the samples of a trial together.
    pub(super) fn r2_averaged(&self) -> MethodStatistic {
        self.median_trial(|trial| trial.samples.r2_averaged)
    }

    /// Returns Spearman's coefficient of a sampled quantity and the measured friction within the median trial.
    pub(super) fn mu_correlation_in_median_trial(&self, value: SampleValue) -> MethodStatistic {
        self.median_trial(|trial| value(&trial.samples))
    }

    /// Returns Spearman's coefficient of a sampled quantity and the measured friction within each trial.
    pub(super) fn mu_correlation_within_trials(&self, value: SampleValue) -> MethodStatistic {
        self.spread_over_trials(|trial| value(&trial.samples))
    }

    /// Returns Spearman's coefficient, within each trial, of the ranges (maximum minus minimum) of two quantities in an
    /// instance. The published ranges are those of explorations, but a trial has only two of them.
    pub(super) fn range_correlation_within_trials(
        &self,
        x: SampledQuantity,
        y: SampledQuantity,
    ) -> MethodStatistic {
        self.spread_over_trials(|trial| {
            let ranges = |value| trial.ranges_of_instances(value);
            let correlation = Coefficient::Spearman.correlate(&ranges(x), &ranges(y));
            correlation.map_or(f64::NAN, |correlation| correlation.rho)
        })
    }

    /// Correlates the means of two quantities over the instances of a trial.
    pub(super) fn correlate(
        &self,
        coefficient: Coefficient,
        x: InstanceValue,
        y: InstanceValue,
    ) -> MethodStatistic {
        let means = |group: &Group<'_>| (group.mean(x), group.mean(y));
        let instances = self.pairs_of(|trial| {
            let values = |value: InstanceValue| trial.values(value);
            values(x).into_iter().zip(values(y)).collect()
        });
        let [trials, participants] = self.correlations_of_groups(coefficient, &means);
        MethodStatistic {
            main: trials,
            also: vec![
                Statistic::correlation(Level::Instances, coefficient, &instances),
                participants,
            ],
        }
    }

    /// Correlates the ranges (maximum minus minimum) of two quantities in an instance, as in Fig. 14; further in an exploration,
    /// and for a trial or participant, their means over the explorations.
    pub(super) fn correlate_ranges(
        &self,
        coefficient: Coefficient,
        x: SampledQuantity,
        y: SampledQuantity,
    ) -> MethodStatistic {
        let instances = self.pairs_of(|trial| trial.range_pairs_of_instances(x, y));
        let explorations = self.pairs_of(|trial| {
            let ranges = |value: SampledQuantity| trial.ranges(value);
            ranges(x).into_iter().zip(ranges(y)).collect()
        });
        let correlation = |level, pairs: &Pairs| Statistic::correlation(level, coefficient, pairs);
        let [trials, participants] =
            self.correlations_of_groups(coefficient, &|group| group.mean_ranges(x, y));
        MethodStatistic {
            main: correlation(Level::Instances, &instances),
            also: vec![
                correlation(Level::Explorations, &explorations),
                trials,
                participants,
            ],
        }
    }

    /// Returns the slope of `y` on `x`, each the range (maximum minus minimum) in an instance; for a trial or participant, the
    /// mean range of its explorations.
    pub(super) fn slope_of_ranges(
        &self,
        x: SampledQuantity,
        y: SampledQuantity,
    ) -> MethodStatistic {
        let level_slope = |level, pairs: Vec<(f64, f64)>| {
            let (x, y): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            let line = slope(&x, &y);
            Statistic {
                value: line.map(|line| line.slope),
                std: line.and_then(|line| line.std),
                n: line.map_or(x.len(), |line| line.n),
                ..Statistic::empty(level)
            }
        };
        let mean_ranges = |groups: &mut dyn Iterator<Item = &Group<'_>>| {
            groups.map(|group| group.mean_ranges(x, y)).collect()
        };
        MethodStatistic {
            main: level_slope(Level::Instances, self.changes(x, y)),
            also: vec![
                level_slope(Level::Trials, mean_ranges(&mut self.trials.iter())),
                level_slope(
                    Level::Participants,
                    mean_ranges(&mut self.participants.values()),
                ),
            ],
        }
    }

    /// Returns R² of the estimated against the measured friction about the line of slope 1, with all samples together.
    pub(super) fn r2_mu(&self) -> MethodStatistic {
        MethodStatistic::single(Statistic {
            value: self.agreement.r2,
            n: self.agreement.samples,
            ..Statistic::empty(Level::Samples)
        })
    }

    /// Returns the largest deviation of Z_t from the mean of a trial, relative to the modulus of the mean.
    pub(super) fn drift_of_z_t(&self) -> MethodStatistic {
        self.spread_over_trials(|trial| trial.departures_of_z_t().fold(f64::NAN, f64::max))
    }

    /// Returns the standard deviation of Z_t within a trial, relative to the modulus of its mean.
    pub(super) fn variation_of_z_t(&self) -> MethodStatistic {
        self.spread_over_trials(|trial| {
            let departures: Vec<f64> = trial.departures_of_z_t().collect();
            let freedom = departures
                .len()
                .checked_sub(1)
                .map_or(f64::NAN, |n| n as f64);
            (departures
                .iter()
                .map(|departure| departure * departure)
                .sum::<f64>()
                / freedom)
                .sqrt()
        })
    }

    /// Returns the ranges (maximum minus minimum) of two quantities in each instance.
    pub(super) fn changes(&self, x: SampledQuantity, y: SampledQuantity) -> Vec<(f64, f64)> {
        let trials = self.trials.iter();
        trials
            .flat_map(|trial| trial.range_pairs_of_instances(x, y))
            .collect()
    }

    /// Returns the ranges of two quantities in each instance of a participant.
    pub(super) fn changes_of(
        &self,
        participant: &str,
        x: SampledQuantity,
        y: SampledQuantity,
    ) -> Vec<(f64, f64)> {
        let group = self.participants.get(participant);
        group.map_or_else(Vec::new, |group| group.range_pairs_of_instances(x, y))
    }

    /// Returns the pairs of all trials, each with its person.
    fn pairs_of(&self, pairs: impl Fn(&Group<'a>) -> Vec<(f64, f64)>) -> Pairs {
        let mut trial_pairs = Pairs {
            people: Some(Vec::new()),
            ..Pairs::default()
        };
        for trial in &self.trials {
            for (x, y) in pairs(trial) {
                trial_pairs.x.push(x);
                trial_pairs.y.push(y);
                trial_pairs.people =
                    trial_pairs
                        .people
                        .zip(trial.person)
                        .map(|(mut people, person)| {
                            people.push(person);
                            people
                        });
            }
        }
        trial_pairs
    }

    /// Correlates a pair of each trial, and one of each participant.
    fn correlations_of_groups(
        &self,
        coefficient: Coefficient,
        group_pair: &dyn Fn(&Group<'_>) -> (f64, f64),
    ) -> [Statistic; 2] {
        let trials = self.pairs_of(|trial| vec![group_pair(trial)]);
        let (x, y) = self.participants.values().map(group_pair).unzip();
        let participants = Pairs { x, y, people: None };
        [(Level::Trials, trials), (Level::Participants, participants)]
            .map(|(level, pairs)| Statistic::correlation(level, coefficient, &pairs))
    }
}

impl<'a> Group<'a> {
    fn instances(&self) -> impl Iterator<Item = MethodEstimate<'a>> {
        self.explorations
            .iter()
            .flat_map(|exploration| exploration.0.iter().copied())
    }

    fn values(&self, value: impl Fn(&InstanceAnalysis, &InstanceEstimate) -> f64) -> Vec<f64> {
        self.instances()
            .map(|fit| value(fit.instance, fit.estimate))
            .collect()
    }

    fn mean(&self, value: impl Fn(&InstanceAnalysis, &InstanceEstimate) -> f64) -> f64 {
        spread(self.values(value)).map_or(f64::NAN, |spread| spread.mean)
    }

    fn ranges(&self, value: SampledQuantity) -> Vec<f64> {
        let explorations = self.explorations.iter();
        explorations
            .map(|exploration| exploration.range(value))
            .collect()
    }

    fn ranges_of_instances(&self, value: SampledQuantity) -> Vec<f64> {
        let instances = self.instances().map(|fit| Exploration(vec![fit]));
        instances.map(|instance| instance.range(value)).collect()
    }

    fn range_pairs_of_instances(&self, x: SampledQuantity, y: SampledQuantity) -> Vec<(f64, f64)> {
        let ranges = |value| self.ranges_of_instances(value);
        ranges(x).into_iter().zip(ranges(y)).collect()
    }

    /// Returns the mean ranges of two quantities over the explorations.
    fn mean_ranges(&self, x: SampledQuantity, y: SampledQuantity) -> (f64, f64) {
        let mean = |value| spread(self.ranges(value)).map_or(f64::NAN, |s| s.mean);
        (mean(x), mean(y))
    }

    /// Returns |Z_t − mean|/|mean| of each instance; empty for fewer than two.
    fn departures_of_z_t(&self) -> impl Iterator<Item = f64> {
        let z_t: Vec<Complex64> = self
            .instances()
            .map(|fit| fit.estimate.z_t_n_s_per_m)
            .collect();
        let mean = z_t.iter().sum::<Complex64>() / z_t.len() as f64;
        let has_several = z_t.len() > 1;
        z_t.into_iter()
            .filter(move |_| has_several)
            .map(move |z| (z - mean).norm() / mean.norm())
    }
}

impl Exploration<'_> {
    /// Returns the maximum minus the minimum of a sampled quantity; NaN without a finite value.
    fn range(&self, quantity: SampledQuantity) -> f64 {
        let extents = self.0.iter().map(|fit| fit.estimate.extents.get(quantity));
        extents.fold(Extent::default(), Extent::union).range()
    }
}
