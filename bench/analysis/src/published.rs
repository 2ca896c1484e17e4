//! The published statistics (Huloux 2021, as digested in SCIENCE.md section 7) over instances, trials and participants,
//! by both methods, beside the published values. A trial is a recording.

use std::collections::BTreeMap;

use contact::Contact;
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::analysed::{Analysed, RecordingFindings};
use crate::analysis_settings::Settings;
use crate::clustered::{self, Clustered};
use crate::estimate::{Estimated, InstanceAnalysis, Method};
use crate::statistics::{Coefficient, Spread, r_squared, spread};

/// Amplitude, m, and normal force, N, at which k_c is compared with k_c at rest.
const FALL_AT: (f64, f64) = (5e-6, 1.0);

/// Level that a statistic is taken over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Samples of all instances together.
    Samples,
    /// Instances.
    Instances,
    /// Trials, each by the mean over its instances or by its own statistic.
    Trials,
    /// Participants whose name is known, each by the mean over their instances.
    Participants,
}

impl Level {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Instances => "instances",
            Self::Trials => "trials",
            Self::Participants => "participants",
        }
    }
}

/// Statistic with its number of values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistic {
    /// Mean, median, coefficient or share; `None` if there is too little data.
    pub value: Option<f64>,
    /// Sample standard deviation of what the value is the mean of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
    /// Two-sided p-value of a correlation, as if its pairs were independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
    /// The same at the level of participants, where one has several pairs and all are known by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clustered: Option<Clustered>,
    /// Number of values.
    pub n: usize,
    /// Level of the values.
    pub over: Level,
}

impl Statistic {
    fn spread(over: Level, values: impl IntoIterator<Item = f64>) -> Self {
        let spread = spread(values);
        Self {
            value: spread.map(|s| s.mean),
            std: spread.and_then(|s: Spread| s.std),
            p: None,
            clustered: None,
            n: spread.map_or(0, |s| s.n),
            over,
        }
    }

    fn correlation(over: Level, coefficient: Coefficient, pairs: &Pairs) -> Self {
        let found = coefficient.of(&pairs.x, &pairs.y);
        let people = pairs.people.as_deref();
        Self {
            value: found.map(|c| c.rho),
            std: None,
            p: found.map(|c| c.p),
            clustered: people
                .and_then(|people| clustered::test(coefficient, &pairs.x, &pairs.y, people)),
            n: found.map_or(pairs.x.len(), |c| c.n),
            over,
        }
    }
}

/// Values to be correlated.
#[derive(Default)]
struct Pairs {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Who each is of, as a number from 0; `None` if that is not known of all, or each is another's.
    people: Option<Vec<usize>>,
}

/// Statistic by one method: at the published level, and at others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Statistic at the published level.
    #[serde(flatten)]
    pub main: Statistic,
    /// Statistics at the other levels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<Statistic>,
}

/// Published value beside what the data give.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StatisticRow {
    /// Name in results.
    #[serde(skip)]
    pub name: &'static str,
    /// Meaning in words.
    pub meaning: &'static str,
    /// Published value.
    pub published: &'static str,
    /// Statistic by the published method.
    pub paper: Found,
    /// Statistic by the dynamic method.
    pub dynamic: Found,
}

/// All rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Rows in the order of SCIENCE.md section 7.
    pub rows: Vec<StatisticRow>,
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.rows.len()))?;
        for row in &self.rows {
            map.serialize_entry(row.name, row)?;
        }
        map.end()
    }
}

type Compute = fn(&Pool<'_>) -> Found;

const ROWS: [(&str, &str, &str, Compute); 17] = [
    (
        "sigma_t_typical_participant_m",
        "sigma_t of the participant with the median sigma_t, m",
        "(1.92 ± 0.14)e-6",
        |pool| pool.typical_participant(|_, e| e.sigma_t_m),
    ),
    ("sigma_t_m", "sigma_t, m", "(1.7 ± 0.4)e-6", |pool| {
        pool.spread(|_, e| e.sigma_t_m)
    }),
    (
        "r2_impedance",
        "R² of the modelled impedance, median trial",
        "0.82",
        |pool| pool.median_trial(|trial| trial.mean(|_, e| e.agreement.r2_impedance)),
    ),
    (
        "spearman_abs_z_m_mu",
        "Spearman of |Z_m| and mu within a trial",
        "0.78 ± 0.26",
        |pool| pool.over_trials(|trial| trial.sampled(|i, m, k| i.z_m(m)[k].norm())),
    ),
    (
        "spearman_k_c_mu",
        "Spearman of k_c and mu within the median trial",
        "0.91",
        |pool| {
            pool.median_trial(|trial| trial.sampled(|i, m, k| i.estimated(m).series.k_c_n_per_m[k]))
        },
    ),
    (
        "spearman_mu_estimated_mu",
        "Spearman of estimated and measured mu within a trial",
        "0.94 ± 0.07",
        |pool| pool.over_trials(|trial| trial.sampled(|i, m, k| i.estimated(m).series.mu[k])),
    ),
    (
        "spearman_delta_abs_z_m_delta_mu",
        "Spearman of the falls of |Z_m| and mu",
        "0.28",
        |pool| {
            pool.correlate(
                Coefficient::Spearman,
                |_, e| e.deltas.abs_z_m_n_s_per_m,
                |i, _| i.delta_mu,
            )
        },
    ),
    (
        "spearman_acoustic_force_delta_mu",
        "Spearman of the rise of the squeeze film's force and the fall of mu",
        "0.34",
        |pool| {
            pool.correlate(
                Coefficient::Spearman,
                |_, e| e.deltas.squeeze_n,
                |i, _| i.delta_mu,
            )
        },
    ),
    (
        "spearman_delta_gap_delta_mu",
        "Spearman of the rise of the gap and the fall of mu",
        "0.43",
        |pool| {
            pool.correlate(
                Coefficient::Spearman,
                |_, e| e.deltas.gap_m,
                |i, _| i.delta_mu,
            )
        },
    ),
    (
        "spearman_within_trials_delta_re_z_m_delta_mu",
        "Spearman of the falls of Re Z_m and mu within a trial",
        "0.58 ± 0.27",
        |pool| {
            pool.over_trials(|trial| {
                trial.within(|_, e| e.deltas.re_z_m_n_s_per_m, |i, _| i.delta_mu)
            })
        },
    ),
    (
        "spearman_within_trials_delta_im_z_m_delta_mu",
        "Spearman of the falls of |Im Z_m| and mu within a trial",
        "0.65 ± 0.30",
        |pool| {
            pool.over_trials(|trial| {
                trial.within(|_, e| e.deltas.abs_im_z_m_n_s_per_m, |i, _| i.delta_mu)
            })
        },
    ),
    (
        "pearson_delta_mu_estimated_delta_mu",
        "Pearson of the falls of estimated and measured mu",
        "0.76 (140 trials)",
        |pool| pool.correlate(Coefficient::Pearson, |_, e| e.deltas.mu, |i, _| i.delta_mu),
    ),
    (
        "spearman_mu0_im_z_t",
        "Spearman of mu0 and Im Z_t",
        "-0.58",
        |pool| {
            pool.correlate(
                Coefficient::Spearman,
                |_, e| e.mu0,
                |_, e| e.z_t_n_s_per_m.im,
            )
        },
    ),
    (
        "spearman_mu0_re_z_t",
        "Spearman of mu0 and Re Z_t",
        "-0.25",
        |pool| {
            pool.correlate(
                Coefficient::Spearman,
                |_, e| e.mu0,
                |_, e| e.z_t_n_s_per_m.re,
            )
        },
    ),
    (
        "r2_mu",
        "R² of estimated against measured mu, slope 1",
        "0.98 (text), 0.93 (abstract)",
        |pool| pool.r2_mu(),
    ),
    (
        "drift_z_t_within_trial",
        "largest departure of Z_t from the trial's mean, as a part of it",
        "< 0.10",
        |pool| pool.over_trials(Trial::drift),
    ),
    (
        "k_c_fall_5um_1n",
        "1 - k_c/k_c0 at 5 um and 1 N with the fitted sigma_t",
        "0.90 (Eqs. 17-18: 0.87)",
        |pool| pool.spread(|_, e| fall(&pool.analysed.settings, e.sigma_t_m)),
    ),
];

/// Returns all statistics of an analysis.
pub fn statistics(analysed: &Analysed) -> Statistics {
    let pools = Method::BOTH.map(|method| Pool::new(analysed, method));
    let [paper, dynamic] = &pools;
    let rows = ROWS
        .iter()
        .map(|(name, meaning, published, compute)| StatisticRow {
            name,
            meaning,
            published,
            paper: compute(paper),
            dynamic: compute(dynamic),
        });
    Statistics {
        rows: rows.collect(),
    }
}

fn fall(settings: &Settings, sigma_t_m: f64) -> f64 {
    let (amplitude_m, normal_n) = FALL_AT;
    let fall = || {
        let contact = Contact::new(&settings.assumed(), sigma_t_m).ok()?;
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).ok()?;
        let k_c = contact.balance_stiffness_n_per_m(gap_m, normal_n);
        Some(1.0 - k_c / contact.rest_stiffness_n_per_m(normal_n))
    };
    fall().unwrap_or(f64::NAN)
}

/// All instances as one method sees them.
struct Pool<'a> {
    analysed: &'a Analysed,
    trials: Vec<Trial<'a>>,
    participants: BTreeMap<&'a str, Trial<'a>>,
}

/// Instances that belong together.
struct Trial<'a> {
    method: Method,
    /// Number of the participant, from 0; `None` if unknown.
    person: Option<usize>,
    instances: Vec<&'a InstanceAnalysis>,
}

impl<'a> Pool<'a> {
    fn new(analysed: &'a Analysed, method: Method) -> Self {
        let mut participants: BTreeMap<&str, Trial<'_>> = BTreeMap::new();
        let mut trials = Vec::new();
        for found in analysed.findings().filter(|f| !f.instances.is_empty()) {
            let instances: Vec<_> = found.instances.iter().collect();
            let person = RecordingFindings::participant(found).map(|id| {
                let number = participants.len();
                let of = participants.entry(id).or_insert_with(|| Trial {
                    method,
                    person: Some(number),
                    instances: Vec::new(),
                });
                of.instances.extend(&instances);
                of.person.unwrap_or(number)
            });
            trials.push(Trial {
                method,
                person,
                instances,
            });
        }
        Self {
            analysed,
            trials,
            participants,
        }
    }

    fn spread(&self, value: impl Fn(&InstanceAnalysis, &Estimated) -> f64 + Copy) -> Found {
        let instances = self.trials.iter().flat_map(|trial| trial.values(value));
        Found {
            main: Statistic::spread(Level::Instances, instances),
            also: vec![
                Statistic::spread(Level::Trials, self.trials.iter().map(|t| t.mean(value))),
                Statistic::spread(
                    Level::Participants,
                    self.participants.values().map(|p| p.mean(value)),
                ),
            ],
        }
    }

    /// Takes the spread over the instances of the participant whose mean is the (lower) median; over none if no
    /// participant is known.
    fn typical_participant(
        &self,
        value: impl Fn(&InstanceAnalysis, &Estimated) -> f64 + Copy,
    ) -> Found {
        let mut participants: Vec<_> = self.participants.values().collect();
        participants.sort_by(|a, b| a.mean(value).total_cmp(&b.mean(value)));
        let typical = participants.get(participants.len().saturating_sub(1) / 2);
        Found {
            main: Statistic::spread(
                Level::Instances,
                typical.map(|p| p.values(value)).unwrap_or_default(),
            ),
            also: Vec::new(),
        }
    }

    fn over_trials(&self, statistic: impl Fn(&Trial<'a>) -> f64) -> Found {
        Found {
            main: Statistic::spread(Level::Trials, self.trials.iter().map(statistic)),
            also: Vec::new(),
        }
    }

    fn median_trial(&self, statistic: impl Fn(&Trial<'a>) -> f64) -> Found {
        let mut values: Vec<f64> = self.trials.iter().map(statistic).collect();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        Found {
            main: Statistic {
                value: crate::model_check::quantile(&values, 0.5),
                std: None,
                p: None,
                clustered: None,
                n: values.len(),
                over: Level::Trials,
            },
            also: vec![Statistic::spread(Level::Trials, values)],
        }
    }

    fn correlate(
        &self,
        coefficient: Coefficient,
        x: impl Fn(&InstanceAnalysis, &Estimated) -> f64 + Copy,
        y: impl Fn(&InstanceAnalysis, &Estimated) -> f64 + Copy,
    ) -> Found {
        let means = |of: &mut dyn Iterator<Item = &Trial<'a>>| -> Pairs {
            let (x, y) = of.map(|group| (group.mean(x), group.mean(y))).unzip();
            Pairs { x, y, people: None }
        };
        let trials = Pairs {
            people: self.trials.iter().map(|trial| trial.person).collect(),
            ..means(&mut self.trials.iter())
        };
        let person_of_each = self
            .trials
            .iter()
            .flat_map(|trial| std::iter::repeat_n(trial.person, trial.instances.len()));
        let instances = Pairs {
            x: self
                .trials
                .iter()
                .flat_map(|trial| trial.values(x))
                .collect(),
            y: self
                .trials
                .iter()
                .flat_map(|trial| trial.values(y))
                .collect(),
            people: person_of_each.collect(),
        };
        let participants = means(&mut self.participants.values());
        let of = |over, pairs| Statistic::correlation(over, coefficient, &pairs);
        Found {
            main: of(Level::Trials, trials),
            also: vec![
                of(Level::Instances, instances),
                of(Level::Participants, participants),
            ],
        }
    }

    fn r2_mu(&self) -> Found {
        let instances = || {
            self.trials
                .iter()
                .flat_map(|t| t.instances.iter().map(move |i| (t, i)))
        };
        let measured: Vec<f64> = instances()
            .flat_map(|(_, i)| i.samples.mu.iter().copied())
            .collect();
        let estimated: Vec<f64> = instances()
            .flat_map(|(t, i)| i.estimated(t.method).series.mu.iter().copied())
            .collect();
        Found {
            main: Statistic {
                value: r_squared(&measured, &estimated),
                std: None,
                p: None,
                clustered: None,
                n: measured.len(),
                over: Level::Samples,
            },
            also: Vec::new(),
        }
    }
}

impl Trial<'_> {
    fn values(&self, value: impl Fn(&InstanceAnalysis, &Estimated) -> f64) -> Vec<f64> {
        self.instances
            .iter()
            .map(|instance| value(instance, instance.estimated(self.method)))
            .collect()
    }

    fn mean(&self, value: impl Fn(&InstanceAnalysis, &Estimated) -> f64) -> f64 {
        spread(self.values(value)).map_or(f64::NAN, |spread| spread.mean)
    }

    /// Returns Spearman's coefficient of a sampled quantity and the measured friction, all instances together.
    fn sampled(&self, value: impl Fn(&InstanceAnalysis, Method, usize) -> f64) -> f64 {
        let (x, y): (Vec<f64>, Vec<f64>) = self
            .instances
            .iter()
            .flat_map(|instance| {
                let at = |k| (value(instance, self.method, k), instance.samples.mu[k]);
                (0..instance.samples.mu.len()).map(at).collect::<Vec<_>>()
            })
            .unzip();
        Coefficient::Spearman
            .of(&x, &y)
            .map_or(f64::NAN, |correlation| correlation.rho)
    }

    /// Returns Spearman's coefficient over the instances.
    fn within(
        &self,
        x: impl Fn(&InstanceAnalysis, &Estimated) -> f64,
        y: impl Fn(&InstanceAnalysis, &Estimated) -> f64,
    ) -> f64 {
        Coefficient::Spearman
            .of(&self.values(x), &self.values(y))
            .map_or(f64::NAN, |correlation| correlation.rho)
    }

    fn drift(&self) -> f64 {
        let z_t = || {
            self.instances
                .iter()
                .map(|instance| instance.estimated(self.method).z_t_n_s_per_m)
        };
        if self.instances.len() < 2 {
            return f64::NAN;
        }
        let mean = z_t().sum::<num_complex::Complex64>() / self.instances.len() as f64;
        z_t().map(|z| (z - mean).norm()).fold(0.0, f64::max) / mean.norm()
    }
}
