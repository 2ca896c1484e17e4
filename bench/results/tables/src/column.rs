//! A table as columns, each with its unit and meaning, so that no column exists without them.

use std::borrow::Cow;
use std::sync::Arc;

/// Table of an analysis.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Name, which its files have.
    pub name: &'static str,
    /// Subject of a row, and the columns that together identify it.
    pub row: &'static str,
    /// Columns, of equal lengths.
    pub columns: Vec<Column>,
}

impl Table {
    /// Returns the number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Returns whether it has no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Column with its unit and meaning.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name; a quantity's ends in its SI unit.
    pub name: Cow<'static, str>,
    /// SI unit: `1` for a pure number, empty for a text or truth value.
    pub unit: &'static str,
    /// Meaning in a phrase.
    pub meaning: Cow<'static, str>,
    /// Values.
    pub values: Values,
}

/// Values of a column; NaN is an unknown number.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Truth values.
    Flag(Vec<bool>),
    /// Texts.
    Text(Vec<Arc<str>>),
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Numbers.
    Real(Vec<f64>),
}

impl Values {
    /// Returns the number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Flag(values) => values.len(),
            Self::Text(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Real(values) => values.len(),
        }
    }

    /// Returns whether there are no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Removes all values.
    #[cfg(feature = "parquet")]
    pub(crate) fn clear(&mut self) {
        match self {
            Self::Flag(values) => values.clear(),
            Self::Text(values) => values.clear(),
            Self::Integer(values) => values.clear(),
            Self::Real(values) => values.clear(),
        }
    }

    /// Appends values of the same type.
    pub(crate) fn append(&mut self, values: &Self) {
        match (self, values) {
            (Self::Flag(all), Self::Flag(values)) => all.extend(values),
            (Self::Text(all), Self::Text(values)) => all.extend(values.iter().map(Arc::clone)),
            (Self::Integer(all), Self::Integer(values)) => all.extend(values),
            (Self::Real(all), Self::Real(values)) => all.extend(values),
            _ => debug_assert!(false, "parts of a table have the same columns"),
        }
    }

    /// Returns the name of their type.
    #[must_use]
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Flag(_) => "boolean",
            Self::Text(_) => "text",
            Self::Integer(_) => "integer",
            Self::Real(_) => "real",
        }
    }

    /// Returns a value as a cell of a CSV file; empty if unknown.
    #[must_use]
    pub fn cell(&self, row: usize) -> String {
        match self {
            Self::Flag(values) => values[row].to_string(),
            Self::Text(values) => escaping::to_cell(&values[row]),
            Self::Integer(values) => values[row].to_string(),
            Self::Real(values) if values[row].is_finite() => values[row].to_string(),
            Self::Real(_) => String::new(),
        }
    }
}

/// Columns made from rows of one kind.
pub(crate) struct Columns<'a, R> {
    rows: &'a [R],
    list: Vec<Column>,
}

impl<'a, R> Columns<'a, R> {
    pub(crate) fn new(rows: &'a [R]) -> Self {
        Self {
            rows,
            list: Vec::new(),
        }
    }

    pub(crate) fn into_list(self) -> Vec<Column> {
        self.list
    }

    fn push(
        &mut self,
        name: impl Into<Cow<'static, str>>,
        unit: &'static str,
        meaning: impl Into<Cow<'static, str>>,
        values: Values,
    ) {
        self.list.push(Column {
            name: name.into(),
            unit,
            meaning: meaning.into(),
            values,
        });
    }

    pub(crate) fn flag(
        &mut self,
        name: &'static str,
        meaning: &'static str,
        value: impl Fn(&R) -> bool,
    ) {
        let values = Values::Flag(self.rows.iter().map(value).collect());
        self.push(name, "", meaning, values);
    }

    pub(crate) fn text(
        &mut self,
        name: &'static str,
        meaning: &'static str,
        value: impl Fn(&R) -> Arc<str>,
    ) {
        let values = Values::Text(self.rows.iter().map(value).collect());
        self.push(name, "", meaning, values);
    }

    pub(crate) fn integer(
        &mut self,
        name: &'static str,
        meaning: &'static str,
        value: impl Fn(&R) -> i64,
    ) {
        let values = Values::Integer(self.rows.iter().map(value).collect());
        self.push(name, "1", meaning, values);
    }

    pub(crate) fn real(
        &mut self,
        name: &'static str,
        unit: &'static str,
        meaning: impl Into<Cow<'static, str>>,
        value: impl Fn(&R) -> f64,
    ) {
        let values = Values::Real(self.rows.iter().map(value).collect());
        self.push(name, unit, meaning, values);
    }
}
