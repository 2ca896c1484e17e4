//! One reading of a TOML file, with the explanation of its first error.

use serde::de::DeserializeOwned;
use toml::de::DeTable;

use crate::document::{self, Mismatch};
use crate::place::line_at;
use crate::slip::{Slip, shown_line, slip};
use crate::suggestion::nearest;
use crate::toml_error::TomlError;
use crate::wrong_value::{self, WrongValue};

/// An error and the byte at which it was found.
pub(crate) struct Failure {
    pub error: TomlError,
    pub offset: Option<usize>,
}

/// Reads `text` up to its first error.
pub(crate) fn attempt<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, Box<Failure>> {
    let failure = |error, offset| Box::new(Failure { error, offset });
    let document = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map(|span| span.start);
        failure(not_toml(&error, text, file.to_owned()), offset)
    })?;
    document::read(document).map_err(|mismatch| {
        let offset = mismatch.span.as_ref().map(|span| span.start);
        failure(explain(mismatch, text, file), offset)
    })
}

pub(crate) fn slip_error(slip: Slip, file: String, key: Option<String>) -> TomlError {
    TomlError::Invalid {
        file,
        line: slip.line,
        key,
        message: slip.words,
    }
}

fn explain(mismatch: Mismatch, text: &str, file: &str) -> TomlError {
    let file = file.to_owned();
    let Mismatch {
        message,
        keys,
        span,
    } = mismatch;
    let line = span.map_or(1, |span| line_at(text, span.start));
    let path = (!keys.is_empty()).then(|| keys.join("."));
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
    if let Some(mismatch) = wrong_value::from_message(&message) {
        return wrong_type(mismatch, file, line, path);
    }
    let message = wrong_value::length_words(&message).unwrap_or(message);
    TomlError::Invalid {
        file,
        line,
        key: path,
        message,
    }
}

fn wrong_type(mismatch: WrongValue, file: String, line: usize, key: Option<String>) -> TomlError {
    match mismatch {
        WrongValue::QuotedNumber(number) => TomlError::QuotedNumber {
            file,
            line,
            key,
            number,
        },
        WrongValue::QuotedSlip { text, number } => TomlError::WrongType {
            file,
            line,
            key,
            given_text: format!("the text \"{text}\""),
            expected: number,
        },
        WrongValue::NumberWithUnit(value) => TomlError::NumberWithUnit {
            file,
            line,
            key,
            value,
        },
        WrongValue::Type {
            given_text,
            expected,
        } => TomlError::WrongType {
            file,
            line,
            key,
            given_text,
            expected,
        },
    }
}

/// Explains a text that is not TOML, such as a number with a unit.
fn not_toml(error: &toml::de::Error, text: &str, file: String) -> TomlError {
    /// The parser's message for most words outside quotes and for a missing value.
    const BARE_WORD: &str = "string values must be quoted";
    let message = error.message();
    let offset = error.span().map_or(0, |span| span.start);
    let line = line_at(text, offset);
    let unreadable = wrong_value::unreadable(text, offset);
    let has_unit = unreadable
        .as_ref()
        .is_some_and(wrong_value::Unreadable::is_number_with_unit);
    if let Some(slip) = slip(text, offset).filter(|_| !has_unit) {
        let key = unreadable.and_then(|passage| passage.key);
        return slip_error(slip, file, key);
    }
    match unreadable {
        Some(found) if found.is_number_with_unit() => TomlError::NumberWithUnit {
            file,
            line,
            value: found.value.to_owned(),
            key: found.key,
        },
        Some(found) if found.is_bare_word() || message.starts_with(BARE_WORD) => {
            TomlError::Invalid {
                file,
                line,
                message: match found.value {
                    "" => "the value is missing".to_owned(),
                    value => {
                        format!(
                            "`{value}` is neither a number, `true` or `false`, nor text in quotes"
                        )
                    }
                },
                key: found.key,
            }
        }
        _ => TomlError::Invalid {
            file,
            line,
            key: None,
            message: words(message, text, offset),
        },
    }
}

/// Returns the parser's message in a user's words, with the line.
fn words(message: &str, text: &str, offset: usize) -> String {
    let line = shown_line(text, offset);
    if message.contains("duplicate key") {
        return format!("`{line}` repeats a key or a table; keep one of them");
    }
    let cause = if message.contains("unclosed array") {
        "a bracket is not closed"
    } else if message.contains("unclosed") || message.contains("brace") {
        "a bracket or brace is not closed"
    } else if line.matches('"').count() % 2 == 1 || line.matches('\'').count() % 2 == 1 {
        "a quotation mark is not closed"
    } else if message.contains("overflow") {
        "the number is too large"
    } else if message.contains("newline") && message.contains("carriage") {
        "its line ends are those of an old Macintosh (CR); save it with LF or CR LF"
    } else {
        "a line is `key = value`, `[table]` or a comment after #"
    };
    format!("`{line}` is not TOML: {cause}")
}

/// Parses serde's "unknown field `a`, expected one of `b`, `c`".
fn unknown(message: &str, prefix: &str) -> Option<(String, Vec<String>)> {
    let rest = message.strip_prefix(prefix)?.strip_prefix('`')?;
    // The unknown word is the user's and may contain backticks; serde's own text follows the last "`, ".
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
    use crate::strict_reading::parse;
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
    fn a_valid_file_is_read() {
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

    /// Fault 33.
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

    /// Fault 33.
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
    fn a_number_in_quotes_is_to_lose_them() {
        let error = failure(&GOOD.replace("35e3", "\"35_000.0\""));
        assert_eq!(
            error,
            TomlError::QuotedNumber {
                file: "bench.toml".to_owned(),
                line: 1,
                key: Some("carrier_hz".to_owned()),
                number: "35_000.0".to_owned(),
            }
        );
        assert_eq!(
            error.to_string(),
            "bench.toml, line 1, key `carrier_hz`: \"35_000.0\" is text; write the number without quotes"
        );
    }

    /// Fault 33.
    #[test]
    fn a_number_with_a_unit_is_to_lose_it() {
        let with_unit = |line, key: &str, value: &str| TomlError::NumberWithUnit {
            file: "bench.toml".to_owned(),
            line,
            key: Some(key.to_owned()),
            value: value.to_owned(),
        };
        for value in [
            "6.0 Hz",
            "20g",
            "95%",
            "20 µm",
            "-6.0e-3m",
            "35kHz   # comment",
        ] {
            let bare = value.split('#').next().unwrap().trim_end();
            assert_eq!(
                failure(&GOOD.replace("35e3", value)),
                with_unit(1, "carrier_hz", bare)
            );
            assert_eq!(
                failure(&GOOD.replace("0.05", value)),
                with_unit(5, "plate.centre_m", bare)
            );
        }
        assert_eq!(
            failure(&GOOD.replace("0.05", "\"50 mm\"")),
            with_unit(5, "plate.centre_m", "50 mm")
        );
        let inline = "carrier_hz = 1\norder = \"fixed\"\nplate = [{ centre_m = 50 mm }]\n";
        assert_eq!(failure(inline), with_unit(3, "plate.centre_m", "50 mm"));
        assert_eq!(
            failure("carrier_hz = 20g\n").to_string(),
            "bench.toml, line 1, key `carrier_hz`: `20g` has a unit; write a number without a unit; \
             the unit is in the key's name"
        );
    }

    #[test]
    fn a_number_with_a_unit_on_a_line_of_its_own_is_found_without_its_key() {
        assert_eq!(
            failure("plate = [\n  1.0,\n  2 m,\n]\n"),
            TomlError::NumberWithUnit {
                file: "bench.toml".to_owned(),
                line: 3,
                key: None,
                value: "2 m".to_owned(),
            }
        );
    }

    #[test]
    fn a_wrong_type_is_an_error_with_the_expected_value() {
        for (written, given_text, expected) in [
            ("carrier_hz = true", "`true`", "a number"),
            ("carrier_hz = \"fast\"", "the text \"fast\"", "a number"),
            ("carrier_hz = [1.0]", "a list", "a number"),
        ] {
            assert_eq!(
                failure(&GOOD.replace("carrier_hz = 35e3", written)),
                TomlError::WrongType {
                    file: "bench.toml".to_owned(),
                    line: 1,
                    key: Some("carrier_hz".to_owned()),
                    given_text: given_text.to_owned(),
                    expected: expected.to_owned(),
                }
            );
        }
        #[derive(Debug, Deserialize)]
        struct Rate {
            #[expect(dead_code, reason = "only its type is looked at")]
            rate_hz: u32,
        }
        for (written, found) in [("-1", "`-1`"), ("6.5", "`6.5`")] {
            let error = parse::<Rate>(&format!("rate_hz = {written}"), "bench.toml").unwrap_err();
            assert_eq!(
                error.to_string(),
                format!(
                    "bench.toml, line 1, key `rate_hz`: {found} is not allowed; \
                     write a whole number from 0 to 4294967295"
                )
            );
        }
        for written in ["1e999", "99999999999999999999"] {
            let error = failure(&GOOD.replace("35e3", written));
            assert_eq!(
                error.to_string(),
                "bench.toml, line 1, key `carrier_hz`: the number is too large"
            );
        }
    }

    #[test]
    fn a_word_without_quotes_and_a_missing_value_are_named() {
        let invalid = |text: &str| match failure(text) {
            TomlError::Invalid {
                line, key, message, ..
            } => (line, key, message),
            other => panic!("{other:?}"),
        };
        let (line, key, message) = invalid(&GOOD.replace("\"fixed\"", "fixed"));
        assert_eq!((line, key.as_deref()), (2, Some("order")));
        assert!(message.starts_with("`fixed` is neither"), "{message}");
        let (line, key, message) = invalid(&GOOD.replace("0.05", ""));
        assert_eq!((line, key.as_deref()), (5, Some("plate.centre_m")));
        assert_eq!(message, "the value is missing");
    }

    #[test]
    fn text_that_is_not_toml_is_an_error_with_its_line() {
        let error = failure("carrier_hz = 1\norder = = 2\n");
        assert!(
            matches!(&error, TomlError::Invalid { line: 2, .. }),
            "{error:?}"
        );
    }

    /// Words of the parser and of serde that no user should read.
    const FOREIGN: [&str; 8] = [
        "expected",
        "unexpected",
        "invalid",
        "mantissa",
        "missing opening",
        "unquoted",
        "literal",
        "escape code",
    ];

    #[test]
    fn slips_of_typing_are_named_with_their_remedy() {
        for (from, to, line, words) in [
            ("35e3", "35000,5", 1, "write 35000.5"),
            ("0.05", "0,05", 5, "write 0.05"),
            ("0.05", "\"0,05\"", 5, "write 0.05"),
            ("0.05", ".05", 5, "write 0.05"),
            ("0.05", "5.", 5, "write 5.0"),
            ("0.05", "-.5", 5, "write -0.5"),
            ("0.05", "00.05", 5, "write 0.05"),
            ("35e3", "35'000", 1, "without groups"),
            ("35e3", "\u{a0}35e3", 1, "U+00A0 (no-break space)"),
            ("35e3", "35e3\u{200b}", 1, "U+200B (zero-width space)"),
            ("0.05", "\u{2212}0.05", 5, "U+2212 (minus sign)"),
            ("0.05", "\u{2013}0.05", 5, "U+2013 (dash)"),
            ("\"fixed\"", "“fixed”", 2, "U+201C (typographic quotes)"),
            ("\"fixed\"", "„fixed“", 2, "typographic quotes"),
            (
                "\"fixed\"",
                "\"C:\\Users\\lab\"",
                2,
                "'C:\\Users\\lab' between single quotes",
            ),
            (
                "\"fixed\"",
                "\"D:\\test\\new\"",
                2,
                "'D:\\test\\new' between single quotes",
            ),
            ("\"fixed\"", "\"fixed", 2, "a quotation mark is not closed"),
            ("[[plate]]", "[[plate", 4, "not closed"),
            ("35e3", "35e3\ncarrier_hz = 1", 2, "keep one of them"),
            ("carrier_hz =", "carrier hz =", 1, "is not TOML"),
            ("= 35e3", "= 35e3 1", 1, "is neither a number"),
        ] {
            let text = GOOD.replace(from, to);
            assert_ne!(text, GOOD, "{from}");
            let error = failure(&text).to_string();
            let place = format!("bench.toml, line {line}");
            assert!(
                error.starts_with(&place) && error.contains(words),
                "{to}: {error}"
            );
            let foreign = FOREIGN.iter().find(|word| error.contains(*word));
            assert_eq!(foreign, None, "{error}");
        }
        let inline = "carrier_hz = 1.0\norder = \"fixed\"\nplate = [{ centre_m = 0,05 }]\n";
        assert!(
            failure(inline).to_string().contains("write 0.05"),
            "{}",
            failure(inline)
        );
    }

    #[test]
    fn a_byte_order_mark_and_line_ends_of_windows_are_read() {
        let text = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
        assert!(parse::<Outer>(&text, "bench.toml").is_ok());
        let error = failure(&GOOD.replace('\n', "\r")).to_string();
        assert!(error.contains("line ends"), "{error}");
    }

    #[test]
    fn a_list_of_another_length_is_named() {
        #[derive(Debug, Deserialize)]
        struct Pair {
            #[expect(dead_code, reason = "only its type is looked at")]
            range_n: [f64; 2],
        }
        let error = parse::<Pair>("range_n = [1.0]", "bench.toml").unwrap_err();
        assert_eq!(
            error.to_string(),
            "bench.toml, line 1, key `range_n`: the list has 1 values; write a list of 2"
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
    fn no_slip_of_a_character_makes_it_panic() {
        let lines = GOOD.replace('\n', "\r\n");
        for text in [GOOD, &lines] {
            for (offset, c) in text.char_indices() {
                for slip in ["", "µ", "\"", "=", "[", "#", ",", "\n", "1 m", "\u{feff}"] {
                    let slipped = format!(
                        "{}{slip}{}",
                        &text[..offset],
                        &text[offset + c.len_utf8()..]
                    );
                    if let Err(error) = parse::<Outer>(&slipped, "bench.toml") {
                        assert!(error.to_string().starts_with("bench.toml"), "{error}");
                    }
                }
            }
        }
    }
}
