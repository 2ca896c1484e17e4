//! The published statistics (Huloux 2021, as digested in SCIENCE.md section 7) over instances, trials and participants,
//! by both methods, beside the published values. A trial is a recording.

mod grouped;
mod rows;
mod text;

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::analysed::Analysed;
use crate::clustered::{self, Clustered};
use crate::estimate::Method;
use crate::statistics::{Coefficient, Spread, spread};
pub(crate) use grouped::OfSample as Change;
use grouped::Pool;
use rows::ROWS;
pub(crate) use rows::{ABS_Z_M, GAP, MU_ESTIMATED};
pub use text::TableFormat;

/// Fewest trials that are drawn as such, as many as a coefficient needs.
const FEWEST_TRIALS: usize = 3;

/// Level that a statistic is taken over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Samples of all instances together.
    Samples,
    /// Instances.
    Instances,
    /// Explorations with an instance.
    Explorations,
    /// Trials, each by the mean over its instances or explorations or by its own statistic.
    Trials,
    /// Participants whose name is known, each by the mean over their instances or explorations.
    Participants,
}

impl Level {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Instances => "instances",
            Self::Explorations => "explorations",
            Self::Trials => "trials",
            Self::Participants => "participants",
        }
    }
}

/// Statistic with its number of values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistic {
    /// Mean, median, coefficient, slope or share; `None` if there is too little data.
    pub value: Option<f64>,
    /// Sample standard deviation of what the value is the mean of; standard error of a slope.
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
    fn none(over: Level) -> Self {
        Self {
            value: None,
            std: None,
            p: None,
            clustered: None,
            n: 0,
            over,
        }
    }

    fn spread(over: Level, values: impl IntoIterator<Item = f64>) -> Self {
        let spread = spread(values);
        Self {
            value: spread.map(|s| s.mean),
            std: spread.and_then(|s: Spread| s.std),
            n: spread.map_or(0, |s| s.n),
            ..Self::none(over)
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

impl Found {
    fn alone(main: Statistic) -> Self {
        Self {
            main,
            also: Vec::new(),
        }
    }
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

/// Changes of a quantity beside those of the measured friction, each a maximum less a minimum.
pub(crate) struct Changes {
    /// Level of the pairs.
    pub(crate) over: Level,
    /// Change of friction, change of the quantity.
    pub(crate) pairs: Vec<(f64, f64)>,
}

/// Returns the changes of an exploration, averaged over a trial's; with too few trials for a correlation those of an instance.
pub(crate) fn changes(analysed: &Analysed, method: Method, change: Change) -> Changes {
    let pool = Pool::new(analysed, method);
    let by_trial = pool.changes_by_trial(rows::MU, change);
    if by_trial.len() >= FEWEST_TRIALS {
        Changes {
            over: Level::Trials,
            pairs: by_trial,
        }
    } else {
        Changes {
            over: Level::Instances,
            pairs: pool.changes_by_instance(rows::MU, change),
        }
    }
}
