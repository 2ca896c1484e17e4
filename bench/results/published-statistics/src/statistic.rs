//! A statistic with its level and number of values.

use serde::Serialize;

use crate::cluster_test::{self, Clustered};
use correlations::{Coefficient, Spread, spread};

/// Level of a statistic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Samples of all instances together.
    Samples,
    /// Instances.
    Instances,
    /// Explorations with an instance.
    Explorations,
    /// Trials, each by the mean over its instances or explorations, or by its own statistic; averaged.
    Trials,
    /// The same trials, by their median.
    #[serde(rename = "trials, median")]
    MedianTrial,
    /// Participants known by name, each by the mean over their instances or explorations.
    Participants,
}

impl Level {
    /// Returns the name in results and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Instances => "instances",
            Self::Explorations => "explorations",
            Self::Trials => "trials",
            Self::MedianTrial => "trials, median",
            Self::Participants => "participants",
        }
    }
}

/// Statistic with its number of values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistic {
    /// Mean, median, coefficient, slope or fraction; `None` with too few data.
    pub value: Option<f64>,
    /// Sample standard deviation of the values behind a mean; standard error of a slope.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
    /// Two-sided p-value of a correlation, with its pairs treated as independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p: Option<f64>,
    /// p-value at the level of participants, if one has several pairs and all are known by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clustered: Option<Clustered>,
    /// Number of values.
    pub n: usize,
    /// Level of the values.
    pub over: Level,
}

impl Statistic {
    pub(super) fn empty(level: Level) -> Self {
        Self {
            value: None,
            std: None,
            p: None,
            clustered: None,
            n: 0,
            over: level,
        }
    }

    pub(super) fn spread(level: Level, values: impl IntoIterator<Item = f64>) -> Self {
        let spread = spread(values);
        Self {
            value: spread.map(|s| s.mean),
            std: spread.and_then(|s: Spread| s.std),
            n: spread.map_or(0, |s| s.n),
            ..Self::empty(level)
        }
    }

    pub(super) fn correlation(level: Level, coefficient: Coefficient, pairs: &Pairs) -> Self {
        let correlation = coefficient.correlate(&pairs.x, &pairs.y);
        let people = pairs.people.as_deref();
        Self {
            value: correlation.map(|c| c.rho),
            std: None,
            p: correlation.map(|c| c.p),
            clustered: people
                .and_then(|people| cluster_test::test(coefficient, &pairs.x, &pairs.y, people)),
            n: correlation.map_or(pairs.x.len(), |c| c.n),
            over: level,
        }
    }
}

/// Values to be correlated.
#[derive(Default)]
pub(super) struct Pairs {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    /// Person of each pair, as a number from 0; `None` if not all are known, or each pair has another person.
    pub(super) people: Option<Vec<usize>>,
}

/// Statistic by one method: at the published level, and at others.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodStatistic {
    /// Statistic at the published level.
    #[serde(flatten)]
    pub main: Statistic,
    /// Statistics at the other levels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<Statistic>,
}

impl MethodStatistic {
    pub(super) fn single(main: Statistic) -> Self {
        Self {
            main,
            also: Vec::new(),
        }
    }
}
