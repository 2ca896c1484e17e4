//! Reasons for rejecting a scenario.

use faults::{OverlapError, RehearsedFaultError};
use strict_toml::{InFile, OutOfRange, TomlError};

/// Reason for rejecting a scenario.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// Text that is not TOML, or an unknown key or value. The message names file and line.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A number that the simulation cannot represent.
    #[error("{file}{}: {range}", at_line(.line))]
    OutOfRange {
        /// Name of the file, given by the caller.
        file: String,
        /// Line of the key, counted from 1; `None` if a default is out of range because of another key.
        line: Option<usize>,
        /// Key, value and range.
        range: OutOfRange,
    },
    /// A fault that cannot be injected with these settings.
    #[error(transparent)]
    Fault(InFile<RehearsedFaultError>),
    /// Faults that could not be distinguished.
    #[error("{file}: {error}")]
    Overlap {
        /// Name of the file, given by the caller.
        file: String,
        /// The two faults.
        error: OverlapError,
    },
    /// A name that is not a built-in scenario's.
    #[error("unknown scenario `{name}`{}; built-in scenarios: {}", did_you_mean(.nearest), .names.join(", "))]
    UnknownName {
        /// Requested name.
        name: String,
        /// Most similar name of a built-in scenario, if any is similar.
        nearest: Option<String>,
        /// Names of all built-in scenarios.
        names: Vec<String>,
    },
}

fn at_line(line: &Option<usize>) -> String {
    line.map(|line| format!(", line {line}"))
        .unwrap_or_default()
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|name| format!(", did you mean `{name}`?"))
        .unwrap_or_default()
}
