//! Errors of reading a TOML file.

/// Error of reading a TOML file. Lines count from 1; keys are dotted paths, elements of an array without their index.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TomlError {
    /// Unknown key.
    #[error("{file}, line {line}: unknown key `{key}`{}; known here: {}", did_you_mean(.nearest), quoted(.known))]
    UnknownKey {
        /// The file, as the caller named it.
        file: String,
        /// Line of the key.
        line: usize,
        /// The key as written, without its table.
        key: String,
        /// Most similar known key, if any is similar.
        nearest: Option<String>,
        /// All known keys of that table.
        known: Vec<String>,
    },
    /// Word that is not among the allowed ones.
    #[error("{file}, line {line}: unknown value `{value}`{}; allowed: {}", did_you_mean(.nearest), quoted(.allowed))]
    UnknownValue {
        /// The file, as the caller named it.
        file: String,
        /// Line of the value.
        line: usize,
        /// The value as written.
        value: String,
        /// Most similar allowed value, if any is similar.
        nearest: Option<String>,
        /// All allowed values.
        allowed: Vec<String>,
    },
    /// Missing required key.
    #[error("{file}{}: key `{key}` is missing", in_table(.table))]
    MissingKey {
        /// The file, as the caller named it.
        file: String,
        /// Dotted path of the table that lacks the key; `None` for the top of the file.
        table: Option<String>,
        /// The missing key.
        key: String,
    },
    /// Number in quotes.
    #[error("{file}, line {line}{}: \"{number}\" is text; write the number without quotes", at_key(.key))]
    QuotedNumber {
        /// The file, as the caller named it.
        file: String,
        /// Line of the value.
        line: usize,
        /// Key, if known.
        key: Option<String>,
        /// Text between the quotes.
        number: String,
    },
    /// Number followed by a unit, in quotes or not.
    #[error(
        "{file}, line {line}{}: `{value}` has a unit; write a number without a unit; the unit is in the key's name",
        at_key(.key)
    )]
    NumberWithUnit {
        /// The file, as the caller named it.
        file: String,
        /// Line of the value.
        line: usize,
        /// Key, if known.
        key: Option<String>,
        /// Number and unit as written, without quotes.
        value: String,
    },
    /// Value of another type than the key's, or a whole number outside the type's range.
    #[error("{file}, line {line}{}: {given_text} is not allowed; write {expected}", at_key(.key))]
    WrongType {
        /// The file, as the caller named it.
        file: String,
        /// Line of the value.
        line: usize,
        /// Key, if known.
        key: Option<String>,
        /// Value as written.
        given_text: String,
        /// Expected value.
        expected: String,
    },
    /// Text that is not TOML, or a value in the wrong form.
    #[error("{file}, line {line}{}: {message}", at_key(.key))]
    Invalid {
        /// The file, as the caller named it.
        file: String,
        /// Line of the error.
        line: usize,
        /// Key, if known.
        key: Option<String>,
        /// Parser's message.
        message: String,
    },
    /// Several errors of one file.
    #[error("{}", in_lines(.0))]
    Several(Vec<TomlError>),
}

impl TomlError {
    /// Returns the only error, or all as one; `None` without errors.
    pub fn of_several(mut errors: Vec<Self>) -> Option<Self> {
        match errors.len() {
            0 | 1 => errors.pop(),
            _ => Some(Self::Several(errors)),
        }
    }

    /// Returns the line, if the error has one.
    pub(crate) fn line(&self) -> Option<usize> {
        match self {
            Self::UnknownKey { line, .. }
            | Self::UnknownValue { line, .. }
            | Self::QuotedNumber { line, .. }
            | Self::NumberWithUnit { line, .. }
            | Self::WrongType { line, .. }
            | Self::Invalid { line, .. } => Some(*line),
            Self::MissingKey { .. } | Self::Several(_) => None,
        }
    }

    /// Moves the error to another line.
    pub(crate) fn move_to(&mut self, to: usize) {
        match self {
            Self::UnknownKey { line, .. }
            | Self::UnknownValue { line, .. }
            | Self::QuotedNumber { line, .. }
            | Self::NumberWithUnit { line, .. }
            | Self::WrongType { line, .. }
            | Self::Invalid { line, .. } => *line = to,
            Self::MissingKey { .. } | Self::Several(_) => {}
        }
    }
}

fn in_lines(errors: &[TomlError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
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
