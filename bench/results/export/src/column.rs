//! Tables of a recording: columns of equal length, each with its name, unit and meaning.

use std::borrow::Cow;

use crate::stream::Stream;

/// Table of a recording.
#[derive(Debug)]
pub(crate) struct ExportedTable {
    /// Name, such as `forces`.
    pub(crate) name: &'static str,
    /// Even time base of the rows; `None` if a column has their times.
    pub(crate) rate_hz: Option<f64>,
    /// Number of rows.
    pub(crate) rows: u64,
    /// Columns.
    pub(crate) columns: Vec<ExportedColumn>,
}

/// Column of a table.
#[derive(Debug)]
pub(crate) struct ExportedColumn {
    /// Name; a quantity's ends in its SI unit.
    pub(crate) name: Cow<'static, str>,
    /// SI unit: `1` for a pure number, empty for a text.
    pub(crate) unit: &'static str,
    /// Meaning in a phrase.
    pub(crate) meaning: Cow<'static, str>,
    /// Values.
    pub(crate) values: ColumnValues,
}

/// Values of a column; NaN is an unknown number.
#[derive(Debug)]
pub(crate) enum ColumnValues {
    /// Numbers read from a file of the recording.
    Stream(Stream),
    /// Numbers.
    Real(Vec<f64>),
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Texts.
    Text(Vec<String>),
}

impl ExportedColumn {
    pub(crate) fn new(
        name: impl Into<Cow<'static, str>>,
        unit: &'static str,
        meaning: impl Into<Cow<'static, str>>,
        values: ColumnValues,
    ) -> Self {
        Self {
            name: name.into(),
            unit,
            meaning: meaning.into(),
            values,
        }
    }

    pub(crate) fn real(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        values: Vec<f64>,
    ) -> Self {
        Self::new(name, unit, meaning, ColumnValues::Real(values))
    }

    pub(crate) fn whole(name: &'static str, meaning: &'static str, values: Vec<i64>) -> Self {
        Self::new(name, "1", meaning, ColumnValues::Whole(values))
    }

    pub(crate) fn text(name: &'static str, meaning: &'static str, values: Vec<String>) -> Self {
        Self::new(name, "", meaning, ColumnValues::Text(values))
    }
}
