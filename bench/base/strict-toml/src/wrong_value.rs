//! Unreadable values, and the values expected in their place.

use crate::slip;

/// Kind of wrong value.
#[derive(Debug, PartialEq)]
pub(crate) enum WrongValue {
    /// A number between quotes where a number is expected.
    QuotedNumber(String),
    /// A number between quotes that is not written as TOML writes it.
    QuotedSlip { text: String, number: String },
    /// A number and a unit.
    NumberWithUnit(String),
    /// Another type, or a whole number outside the type's range.
    Type {
        given_text: String,
        expected: String,
    },
}

/// Parses serde's "invalid type: string \"5\", expected f64"; `None` for any other message.
pub(crate) fn from_message(message: &str) -> Option<WrongValue> {
    let rest = message
        .strip_prefix("invalid type: ")
        .or_else(|| message.strip_prefix("invalid value: "))?;
    let (given_text, expected_type) = rest.rsplit_once(", expected ")?;
    let text = given_text
        .strip_prefix("string \"")
        .and_then(|text| text.strip_suffix('"'));
    if let Some(text) = text.filter(|_| is_number_wanted(expected_type)) {
        if let Some(number) = slip::corrected(text.trim()) {
            return Some(WrongValue::QuotedSlip {
                text: text.to_owned(),
                number,
            });
        }
        let (number, unit) = split_number(text);
        if !number.is_empty() && unit.is_empty() {
            return Some(WrongValue::QuotedNumber(text.to_owned()));
        }
        if !number.is_empty() && is_unit(unit) {
            return Some(WrongValue::NumberWithUnit(text.to_owned()));
        }
    }
    Some(WrongValue::Type {
        given_text: found_in_words(given_text),
        expected: wanted_in_words(expected_type),
    })
}

/// Returns serde's "invalid length 2, expected an array of length 3" in a user's words; `None` for any other message.
pub(crate) fn length_words(message: &str) -> Option<String> {
    let rest = message.strip_prefix("invalid length ")?;
    let (given, expected) = rest.split_once(", expected ")?;
    let count = expected
        .rsplit(' ')
        .find_map(|word| word.parse::<usize>().ok());
    let wanted = count.map_or_else(
        || "another number of values".to_owned(),
        |n| format!("a list of {n}"),
    );
    Some(format!("the list has {given} values; write {wanted}"))
}

/// Value that is not TOML, as written.
#[derive(Debug, PartialEq)]
pub(crate) struct Unreadable<'a> {
    /// Dotted path of its key, if the key is on the value's line.
    pub(crate) key: Option<String>,
    /// The value as written; may be empty.
    pub(crate) value: &'a str,
}

impl Unreadable<'_> {
    /// Returns whether the value is a number and a unit.
    pub(crate) fn is_number_with_unit(&self) -> bool {
        let (number, unit) = split_number(self.value);
        !number.is_empty() && is_unit(unit)
    }

    /// Returns whether the value of a key is a word without quotes.
    pub(crate) fn is_bare_word(&self) -> bool {
        self.key.is_some()
            && self.value.starts_with(char::is_alphabetic)
            && self.value.chars().all(|c| c.is_alphanumeric() || c == '_')
    }
}

/// Finds the value around `offset`, where a parser stopped. `None` if no value is found.
pub(crate) fn unreadable(text: &str, offset: usize) -> Option<Unreadable<'_>> {
    let head = text.get(..offset)?;
    let line_start = head.rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[line_start..].lines().next()?;
    let offset = (offset - line_start).min(line.len());
    // A value begins after the preceding sign, or with its line; a comment is not a value.
    let opening = line[..offset].rfind(['=', '[', ',', '#']);
    if opening.is_some_and(|delimiter| line.as_bytes()[delimiter] == b'#') {
        return None;
    }
    let (opened, rest) = line.split_at(opening.map_or(0, |delimiter| delimiter + 1));
    let value = rest
        .find([',', ']', '}', '#'])
        .map_or(rest, |end| &rest[..end]);
    Some(Unreadable {
        key: key_before(text, line_start, opened),
        value: value.trim(),
    })
}

/// Returns the dotted path of the key that `line` begins with: the table header above it, the key, and the key within an
/// inline table.
fn key_before(text: &str, line_start: usize, line: &str) -> Option<String> {
    let (first, rest) = line.split_once('=')?;
    let header = text[..line_start].lines().rev().find_map(|line| {
        let line = line.split('#').next().unwrap_or_default().trim();
        let name = line.strip_prefix('[')?.strip_suffix(']')?;
        Some(name.trim_matches(['[', ']', ' ']))
    });
    let inner = rest
        .trim_end()
        .strip_suffix('=')
        .and_then(|rest| rest.rsplit(['{', ',', '=']).next());
    let parts = header.into_iter().chain([first.trim()]);
    let parts: Vec<_> = parts.chain(inner.map(str::trim)).collect();
    Some(parts.join("."))
}

/// Splits "6.0 Hz" into "6.0" and "Hz"; the number is empty if the text does not begin with one.
fn split_number(text: &str) -> (&str, &str) {
    let text = text.trim();
    let mut end = 0;
    let bytes = text.as_bytes();
    let digits = |start: usize| {
        bytes[start..]
            .iter()
            .take_while(|b| b.is_ascii_digit() || **b == b'_')
            .count()
    };
    if matches!(bytes.first(), Some(b'+' | b'-')) {
        end += 1;
    }
    let integer = digits(end);
    end += integer;
    let mut has_digits = integer > 0;
    if bytes.get(end) == Some(&b'.') {
        let fraction = digits(end + 1);
        has_digits |= fraction > 0;
        end += 1 + fraction;
    }
    if !has_digits {
        return ("", text);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits((end + 1 + sign).min(bytes.len()));
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    (&text[..end], text[end..].trim_start())
}

/// Returns whether `text` reads as a unit: a letter, `%` or `°`, followed only by signs of powers, products and ratios.
fn is_unit(text: &str) -> bool {
    let begins = text.starts_with(|c: char| c.is_alphabetic() || matches!(c, '%' | '°'));
    let sign = |c: char| {
        c.is_alphanumeric() || matches!(c, '%' | '°' | '/' | '^' | '·' | '*' | '-' | '⁻' | ' ')
    };
    begins && text.chars().all(sign)
}

const WHOLE_NUMBERS: [(&str, &str); 10] = [
    ("u8", "a whole number from 0 to 255"),
    ("u16", "a whole number from 0 to 65535"),
    ("u32", "a whole number from 0 to 4294967295"),
    ("u64", "a whole number from 0"),
    ("usize", "a whole number from 0"),
    ("i8", "a whole number from -128 to 127"),
    ("i16", "a whole number from -32768 to 32767"),
    ("i32", "a whole number from -2147483648 to 2147483647"),
    ("i64", "a whole number"),
    ("isize", "a whole number"),
];

fn is_number_wanted(expected_type: &str) -> bool {
    matches!(expected_type, "f32" | "f64")
        || WHOLE_NUMBERS.iter().any(|(name, _)| *name == expected_type)
        || expected_type.contains("number")
}

/// Returns serde's name of an expected type in a user's words.
fn wanted_in_words(expected_type: &str) -> String {
    let words = match expected_type {
        "f32" | "f64" => "a number",
        "a boolean" => "`true` or `false`",
        "a string" | "a borrowed string" => "text in quotes",
        "a sequence" => "a list in brackets",
        "a map" => "a table",
        _ if expected_type.starts_with("struct ") => "a table",
        _ => WHOLE_NUMBERS
            .iter()
            .find(|(name, _)| *name == expected_type)
            .map_or(expected_type, |(_, words)| words),
    };
    words.to_owned()
}

/// Returns serde's description of an unexpected value in a user's words.
fn found_in_words(text_given: &str) -> String {
    for kind in ["integer ", "floating point ", "boolean "] {
        if let Some(value) = text_given.strip_prefix(kind) {
            return value.to_owned();
        }
    }
    match text_given {
        "sequence" => "a list".to_owned(),
        "map" => "a table".to_owned(),
        _ => match text_given.strip_prefix("string ") {
            Some(text) => format!("the text {text}"),
            None => text_given.to_owned(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_split_from_its_unit() {
        for (text, number, unit) in [
            ("6.0 Hz", "6.0", "Hz"),
            ("20g", "20", "g"),
            ("-6.0e-3m", "-6.0e-3", "m"),
            ("192_000", "192_000", ""),
            ("5e", "5", "e"),
            (".5 m/s", ".5", "m/s"),
            ("Hz", "", "Hz"),
            ("-", "", "-"),
            ("", "", ""),
        ] {
            assert_eq!(split_number(text), (number, unit), "{text}");
        }
    }

    #[test]
    fn units_are_distinguished_from_other_text() {
        for unit in ["Hz", "%", "µm", "m/s", "N·s/m", "°C", "m s^-1"] {
            assert!(is_unit(unit), "{unit}");
        }
        for text in ["", "3", ".k", "/s", "m = 3", "\"m\""] {
            assert!(!is_unit(text), "{text}");
        }
    }

    #[test]
    fn only_complaints_about_types_are_taken_apart() {
        assert_eq!(from_message("invalid length 2, expected 3"), None);
        assert_eq!(
            from_message("invalid type: string \"true\", expected a boolean"),
            Some(WrongValue::Type {
                given_text: "the text \"true\"".to_owned(),
                expected: "`true` or `false`".to_owned()
            })
        );
    }
}
