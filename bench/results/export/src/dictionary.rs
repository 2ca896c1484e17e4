//! Dictionary of exported names: the unit and the meaning of each.

use crate::content::{FactValue, RecordingContent};

/// Entry of the dictionary.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct DictionaryEntry {
    /// Table.
    pub(crate) table: &'static str,
    /// Column of the table, or name of the fact or constant.
    pub(crate) column: String,
    /// SI unit: `1` for a pure number, empty for a text.
    pub(crate) unit: &'static str,
    /// Meaning in a phrase.
    pub(crate) meaning: String,
}

impl DictionaryEntry {
    /// Returns the entries of a recording.
    pub(crate) fn of_recording(content: &RecordingContent) -> impl Iterator<Item = Self> {
        let facts = content.facts().into_iter().map(|fact| Self {
            table: "recording",
            column: fact.name.to_owned(),
            unit: match fact.value {
                FactValue::Text(_) => "",
                FactValue::Whole(_) => "1",
            },
            meaning: fact.meaning.to_owned(),
        });
        let constants = content.constants.iter().map(|constant| Self {
            table: "constants",
            column: constant.name.to_owned(),
            unit: constant.unit,
            meaning: constant.meaning.to_owned(),
        });
        let columns = content.tables().flat_map(|table| {
            let rate = table.rate_hz.map(|_| Self {
                table: table.name,
                column: "rate_hz".to_owned(),
                unit: "Hz",
                meaning: "rate of the rows; the first is at time 0".to_owned(),
            });
            let columns = table.columns.iter().map(|column| Self {
                table: table.name,
                column: column.name.clone().into_owned(),
                unit: column.unit,
                meaning: column.meaning.clone().into_owned(),
            });
            rate.into_iter().chain(columns)
        });
        facts.chain(constants).chain(columns)
    }
}
