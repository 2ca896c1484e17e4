//! Why a TOML file cannot be read.

/// Why a file cannot be read. Lines count from 1; keys are dotted paths, elements of an array without their index.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TomlError {
    /// A key that no table of this kind has.
    #[error("{file}, line {line}: unknown key `{key}`{}; known here: {}", did_you_mean(.nearest), quoted(.known))]
    UnknownKey {
        /// The file, as the caller named it.
        file: String,
        /// Where the key stands.
        line: usize,
        /// The key as written, without its table.
        key: String,
        /// The known key that is most like it, if any is like it.
        nearest: Option<String>,
        /// All keys known in that place.
        known: Vec<String>,
    },
    /// A word where one of a few others must stand.
    #[error("{file}, line {line}: unknown value `{value}`{}; allowed: {}", did_you_mean(.nearest), quoted(.allowed))]
    UnknownValue {
        /// The file, as the caller named it.
        file: String,
        /// Where the value stands.
        line: usize,
        /// The value as written.
        value: String,
        /// The allowed value that is most like it, if any is like it.
        nearest: Option<String>,
        /// All values allowed in that place.
        allowed: Vec<String>,
    },
    /// A required key that is not there.
    #[error("{file}{}: key `{key}` is missing", in_table(.table))]
    MissingKey {
        /// The file, as the caller named it.
        file: String,
        /// Dotted path of the table that lacks it; `None` for the top of the file.
        table: Option<String>,
        /// The missing key.
        key: String,
    },
    /// A number in quotes.
    #[error("{file}, line {line}{}: \"{number}\" is text; write the number without quotes", at_key(.key))]
    QuotedNumber {
        /// The file, as the caller named it.
        file: String,
        /// Where the value stands.
        line: usize,
        /// The key, where it is known.
        key: Option<String>,
        /// What stands between the quotes.
        number: String,
    },
    /// A number followed by a unit, in quotes or not.
    #[error(
        "{file}, line {line}{}: `{value}` has a unit; write a number without a unit; the unit is in the key's name",
        at_key(.key)
    )]
    NumberWithUnit {
        /// The file, as the caller named it.
        file: String,
        /// Where the value stands.
        line: usize,
        /// The key, where it is known.
        key: Option<String>,
        /// Number and unit as written, without quotes.
        value: String,
    },
    /// A value of another type than the key's, or a whole number too large or small for it.
    #[error("{file}, line {line}{}: {found} is not allowed; write {wanted}", at_key(.key))]
    WrongType {
        /// The file, as the caller named it.
        file: String,
        /// Where the value stands.
        line: usize,
        /// The key, where it is known.
        key: Option<String>,
        /// What is written.
        found: String,
        /// What must be written.
        wanted: String,
    },
    /// Text that is not TOML, or a value in the wrong form.
    #[error("{file}, line {line}{}: {message}", at_key(.key))]
    Invalid {
        /// The file, as the caller named it.
        file: String,
        /// Where it was noticed.
        line: usize,
        /// The key, where it is known.
        key: Option<String>,
        /// What is wrong.
        message: String,
    },
}

fn at_key(key: &Option<String>) -> String {
    key.as_ref()
        .map(|key| format!(", key `{key}`"))
        .unwrap_or_default()
}

fn did_you_mean(nearest: &Option<String>) -> String {
    nearest
        .as_ref()
        .map(|n| format!(", did you mean `{n}`?"))
        .unwrap_or_default()
}

fn in_table(table: &Option<String>) -> String {
    table
        .as_ref()
        .map(|t| format!(", table [{t}]"))
        .unwrap_or_default()
}

fn quoted(words: &[String]) -> String {
    words
        .iter()
        .map(|w| format!("`{w}`"))
        .collect::<Vec<_>>()
        .join(", ")
}
