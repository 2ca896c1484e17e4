//! Reasons why a configuration is rejected.

use std::path::PathBuf;

/// A `bench.toml` that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The text is not TOML, has an unknown key, or a value of the wrong type.
    #[error(transparent)]
    Toml(#[from] strict_toml::TomlError),
    /// A value is out of its range, or does not fit another one.
    #[error("{file}{}: {why}", line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Value {
        /// The file, as the caller named it.
        file: String,
        /// Line of the key, from 1; `None` if the fault is not in a single key.
        line: Option<usize>,
        /// Key, value and the allowed values.
        why: String,
        /// Range violated by the value; `None` if another rule is broken.
        range: Option<Box<strict_toml::OutOfRange>>,
    },
}
