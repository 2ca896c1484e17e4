//! Configuration files, read strictly: an unknown key is an error that names the key, its line and the nearest
//! known key.
//!
//! The types must carry `#[serde(deny_unknown_fields)]` and no `flatten` or `untagged`, which hide keys from serde.

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use crate::suggestion::nearest;

/// Why a file could not be read. Lines count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TomlError {
    /// A key that no table of this kind has.
    #[error("{file}, line {line}: unknown key `{key}`{}; known here: {}", did_you_mean(.nearest), quoted(.known))]
    UnknownKey {
        /// The file, as the caller named it.
        file: String,
        /// Where the key stands.
        line: usize,
        /// The key as written.
        key: String,
        /// The known key that is most like it, if any is like it at all.
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
        /// The allowed value that is most like it, if any is like it at all.
        nearest: Option<String>,
        /// All values allowed in that place.
        allowed: Vec<String>,
    },
    /// A key that must be there is not.
    #[error("{file}{}: key `{key}` is missing", in_table(.table))]
    MissingKey {
        /// The file, as the caller named it.
        file: String,
        /// Dotted path of the table that lacks it; `None` for the top of the file.
        table: Option<String>,
        /// The missing key.
        key: String,
    },
    /// Not TOML, or a value of the wrong type or form.
    #[error("{file}, line {line}{}: {message}", .key.as_ref().map(|key| format!(", key `{key}`")).unwrap_or_default())]
    Invalid {
        /// The file, as the caller named it.
        file: String,
        /// Where it was noticed.
        line: usize,
        /// Dotted path of the key, where it is known.
        key: Option<String>,
        /// What is wrong.
        message: String,
    },
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

/// Reads `text` into `T`; `file` is only used to name the file in errors.
///
/// # Errors
/// [`TomlError`], for anything that is not a `T` written to the letter.
pub fn parse<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, TomlError> {
    toml::from_str(text).map_err(|error| explain(error, text, file))
}

/// The line, from 1, on which the key at a dotted `path` stands; elements of arrays by index from 0:
/// `drive.modulation_hz`, `conditions.1.name`. `None` if there is no such key or `text` is not TOML.
///
/// For errors about values that parsed well but are out of range.
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut parts = path.split('.');
    let first = parts.next()?;
    let (key, mut value) = root.get_ref().get_key_value(first)?;
    let mut at = key.span().start;
    for part in parts {
        value = match value.get_ref() {
            DeValue::Table(table) => {
                let (key, value) = table.get_key_value(part)?;
                at = key.span().start;
                value
            }
            DeValue::Array(array) => {
                let value = array.get(part.parse::<usize>().ok()?)?;
                at = value.span().start;
                value
            }
            _ => return None,
        };
    }
    Some(line_at(text, at))
}

fn line_at(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|&b| b == b'\n').count()
}

fn explain(mut error: toml::de::Error, text: &str, file: &str) -> TomlError {
    let file = file.to_owned();
    let line = error.span().map_or(1, |span| line_at(text, span.start));
    let message = error.message().trim_end().to_owned();
    // The path of keys shows only in the text of an error that has lost its input.
    error.set_input(None);
    let path = error
        .to_string()
        .rsplit_once("\nin `")
        .and_then(|(_, rest)| rest.trim_end().strip_suffix('`').map(str::to_owned));
    if let Some((key, known)) = unknown(&message, "unknown field ") {
        return TomlError::UnknownKey {
            nearest: nearest(&key, &known),
            file,
            line,
            key,
            known,
        };
    }
    if let Some((value, allowed)) = unknown(&message, "unknown variant ") {
        return TomlError::UnknownValue {
            nearest: nearest(&value, &allowed),
            file,
            line,
            value,
            allowed,
        };
    }
    if let Some(key) = message.strip_prefix("missing field ") {
        return TomlError::MissingKey {
            file,
            table: path,
            key: key.trim_matches('`').to_owned(),
        };
    }
    TomlError::Invalid {
        file,
        line,
        key: path,
        message,
    }
}

/// Takes serde's "unknown field `a`, expected one of `b`, `c`" apart.
fn unknown(message: &str, prefix: &str) -> Option<(String, Vec<String>)> {
    let rest = message.strip_prefix(prefix)?.strip_prefix('`')?;
    // The unknown word is the user's and may hold backticks; serde's own text follows the last "`, ".
    let (word, expected) = rest
        .rsplit_once("`, expected ")
        .or_else(|| rest.rsplit_once("`, there are no fields"))?;
    let known = expected
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect();
    Some((word.to_owned(), known))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Outer {
        carrier_hz: f64,
        order: Word,
        plate: Vec<Inner>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        centre_m: f64,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "snake_case")]
    enum Word {
        Fixed,
        Randomised,
    }

    const GOOD: &str = "carrier_hz = 35e3\norder = \"fixed\"\n\n[[plate]]\ncentre_m = 0.05\n";

    fn failure(text: &str) -> TomlError {
        parse::<Outer>(text, "bench.toml").unwrap_err()
    }

    #[test]
    fn reads_what_is_right() {
        let read: Outer = parse(GOOD, "bench.toml").unwrap();
        assert_eq!(
            read,
            Outer {
                carrier_hz: 35e3,
                order: Word::Fixed,
                plate: vec![Inner { centre_m: 0.05 }]
            }
        );
    }

    #[test]
    fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
        let error = failure(&GOOD.replace("centre_m", "center_m"));
        assert_eq!(
            error.to_string(),
            "bench.toml, line 5: unknown key `center_m`, did you mean `centre_m`?; known here: `centre_m`"
        );
    }

    #[test]
    fn a_wrong_unit_leads_to_the_right_one() {
        let error = failure(&GOOD.replace("carrier_hz", "carrier_khz"));
        let TomlError::UnknownKey {
            line,
            key,
            nearest,
            known,
            ..
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!(
            (line, key.as_str(), nearest.as_deref()),
            (1, "carrier_khz", Some("carrier_hz"))
        );
        assert_eq!(known, ["carrier_hz", "order", "plate"]);
    }

    #[test]
    fn a_key_like_no_other_gets_no_suggestion() {
        let error = failure(&format!("zzz = 1\n{GOOD}"));
        assert!(
            matches!(
                error,
                TomlError::UnknownKey {
                    nearest: None,
                    line: 1,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn a_key_with_backticks_is_shown_whole() {
        let error = failure(&format!("\"a`, expected `b\" = 1\n{GOOD}"));
        assert!(
            matches!(&error, TomlError::UnknownKey { key, .. } if key == "a`, expected `b"),
            "{error:?}"
        );
    }

    #[test]
    fn an_unknown_word_is_named_with_the_allowed_ones() {
        let error = failure(&GOOD.replace("fixed", "randomized"));
        assert_eq!(
            error.to_string(),
            "bench.toml, line 2: unknown value `randomized`, did you mean `randomised`?; allowed: `fixed`, `randomised`"
        );
    }

    #[test]
    fn a_missing_key_is_named_with_its_table() {
        let error = failure(&GOOD.replace("centre_m = 0.05\n", ""));
        assert_eq!(
            error.to_string(),
            "bench.toml, table [plate]: key `centre_m` is missing"
        );
        let error = failure("order = \"fixed\"\nplate = []\n");
        assert_eq!(error.to_string(), "bench.toml: key `carrier_hz` is missing");
    }

    #[test]
    fn a_wrong_type_is_named_with_its_line() {
        let error = failure(&GOOD.replace("0.05", "\"50 mm\""));
        assert!(
            matches!(&error, TomlError::Invalid { line: 5, .. }),
            "{error:?}"
        );
        assert!(error.to_string().contains("50 mm"), "{error}");
    }

    #[test]
    fn text_that_is_not_toml_is_an_error_with_its_line() {
        let error = failure("carrier_hz = 1\norder = = 2\n");
        assert!(
            matches!(&error, TomlError::Invalid { line: 2, .. }),
            "{error:?}"
        );
    }

    #[test]
    fn a_key_given_twice_is_an_error() {
        let error = failure(&format!("carrier_hz = 1.0\n{GOOD}"));
        assert!(
            matches!(&error, TomlError::Invalid { line: 2, .. }),
            "{error:?}"
        );
    }

    #[test]
    fn finds_the_line_of_a_key_by_its_path() {
        assert_eq!(line_of(GOOD, "carrier_hz"), Some(1));
        assert_eq!(line_of(GOOD, "plate.0.centre_m"), Some(5));
        assert_eq!(line_of(GOOD, "plate.1.centre_m"), None);
        assert_eq!(line_of(GOOD, "order.x"), None);
    }
}
