//! Rows of statistics with the published values.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::statistic::MethodStatistic;

/// Published value and the statistics of the data.
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
    pub paper: MethodStatistic,
    /// Statistic by the dynamic method.
    pub dynamic: MethodStatistic,
    /// Statistic by the fit of whole trials, over those in which it can be used.
    pub trial: MethodStatistic,
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
