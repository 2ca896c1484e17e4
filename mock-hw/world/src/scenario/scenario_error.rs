//! Reasons for which a scenario is rejected.

use rehearsal::{OverlapError, RehearsedFaultError};
use strict::{InFile, OutOfRange, TomlError};

/// Why a scenario is rejected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ScenarioError {
    /// Text that is not TOML, or a key or value that no scenario has. The message names file and line.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A number that the simulation cannot represent.
    #[error("{file}{}: {range}", at_line(.line))]
    OutOfRange {
        /// The file, as the caller named it.
        file: String,
        /// Line of the key, counted from 1; `None` where a default is out of range because of another key.
        line: Option<usize>,
        /// Key, value and range.
        range: OutOfRange,
    },
    /// A fault that cannot be injected as it is asked for.
    #[error(transparent)]
    Fault(InFile<RehearsedFaultError>),
    /// Faults that could not be told from each other.
    #[error("{file}: {error}")]
    Overlap {
        /// The file, as the caller named it.
        file: String,
        /// The two faults.
        error: OverlapError,
    },
    /// A name that no built-in scenario has.
    #[error("unknown scenario `{name}`{}; built-in scenarios: {}", did_you_mean(.nearest), .known.join(", "))]
    UnknownName {
        /// The name asked for.
        name: String,
        /// The built-in scenario whose name is most like it, if any is like it at all.
        nearest: Option<String>,
        /// Names of all built-in scenarios.
        known: Vec<String>,
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
