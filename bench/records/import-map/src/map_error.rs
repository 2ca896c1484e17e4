//! Errors of a map.

use std::fmt;

use strict_toml::TomlError;

/// Error of a map.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    /// The text cannot be read into the map's keys.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A required key is missing.
    #[error("{file}{}: `{key}` is missing; {remedy}", .table.map(|table| format!(", table [{table}]")).unwrap_or_default())]
    Missing {
        /// The file, as the caller named it.
        file: String,
        /// Table that lacks the key; `None` for the top of the file.
        table: Option<&'static str>,
        /// The key, or the table.
        key: &'static str,
        /// Text to write.
        remedy: &'static str,
    },
    /// A value is not allowed.
    #[error("{file}{}: {key} {fault}", .line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Value {
        /// The file, as the caller named it.
        file: String,
        /// Line of the key.
        line: Option<usize>,
        /// Dotted path of the key.
        key: String,
        /// Fault and remedy.
        fault: String,
    },
}

/// All errors of a map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapErrors(pub Vec<MapError>);

impl fmt::Display for MapErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl std::error::Error for MapErrors {}
