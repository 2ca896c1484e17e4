//! Lines of a file and of its keys.

use std::fmt;

use toml::de::{DeTable, DeValue};

/// Error about a value of a file, with the file's name and the line of the value's key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InFile<E> {
    /// The file, as the caller named it.
    pub file: String,
    /// Line of the key, from 1; `None` if the error concerns several keys or the key is not in the file.
    pub line: Option<usize>,
    /// Error.
    pub error: E,
}

impl<E> InFile<E> {
    /// Adds to `error` the line of `text` with the key at the dotted `path`, see [`line_of`].
    pub fn at_key(error: E, path: &str, text: &str, file: &str) -> Self {
        Self {
            file: file.to_owned(),
            line: line_of(text, path),
            error,
        }
    }
}

impl<E: fmt::Display> fmt::Display for InFile<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}, line {line}: {}", self.file, self.error),
            None => write!(f, "{}: {}", self.file, self.error),
        }
    }
}

// No source: the text of `error` is included in this error's text and would be printed twice.
impl<E: std::error::Error> std::error::Error for InFile<E> {}

/// Returns the line, from 1, of the key at a dotted `path`; elements of arrays by index from 0: `drive.modulation_hz`,
/// `conditions.1.name`. `None` if `text` has no such key or is not TOML.
///
/// ```
/// let text = "[[plates]]\nlength_m = 0.1\n";
/// assert_eq!(strict_toml::line_of(text, "plates.0.length_m"), Some(2));
/// ```
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = path.split('.');
    let first = parts.next()?;
    let (key, mut value) = root.get_ref().get_key_value(first)?;
    let mut offset = key.span().start;
    for part in parts {
        value = match value.get_ref() {
            DeValue::Table(table) => {
                let (key, value) = table.get_key_value(part)?;
                offset = key.span().start;
                value
            }
            DeValue::Array(array) => {
                let value = array.get(part.parse::<usize>().ok()?)?;
                offset = value.span().start;
                value
            }
            _ => return None,
        };
    }
    Some(line_at(text, offset))
}

/// Returns the line, from 1, of the byte at `offset`.
pub(crate) fn line_at(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|&b| b == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::range::require_range;

    const TEXT: &str = "carrier_hz = 35e3\norder = \"fixed\"\n\n[[plate]]\ncentre_m = 0.05\n";

    #[test]
    fn finds_the_line_of_a_key_by_its_path() {
        assert_eq!(line_of(TEXT, "carrier_hz"), Some(1));
        assert_eq!(line_of(TEXT, "plate.0.centre_m"), Some(5));
        assert_eq!(line_of(TEXT, "plate.1.centre_m"), None);
        assert_eq!(line_of(TEXT, "order.x"), None);
        assert_eq!(line_of("order = = 2", "order"), None);
    }

    #[test]
    fn an_error_is_placed_at_its_key_or_at_the_file() {
        let refused = require_range("plate.0.centre_m", 0.05, 0.1, 0.5, "m").unwrap_err();
        let placed = InFile::at_key(refused.clone(), "plate.0.centre_m", TEXT, "bench.toml");
        assert_eq!((placed.line, &placed.error), (Some(5), &refused));
        assert_eq!(placed.to_string(), format!("bench.toml, line 5: {refused}"));
        let placed = InFile::at_key(refused.clone(), "missing", TEXT, "bench.toml");
        assert_eq!(placed.line, None);
        assert_eq!(placed.to_string(), format!("bench.toml: {refused}"));
    }
}
