//! Errors of the command line in the program's words.

use std::path::Path;

/// Dashes of word processors and web pages.
const DASHES: [char; 5] = ['\u{2010}', '\u{2011}', '\u{2013}', '\u{2014}', '\u{2212}'];

/// Words of the library that parses numbers, with ours.
const NUMBERS: [(&str, &str); 4] = [
    (
        "invalid float literal",
        "write a number with a point and without a unit, such as 1013.25",
    ),
    (
        "invalid digit found in string",
        "write a whole number without a unit",
    ),
    (
        "cannot parse integer from empty string",
        "write a whole number",
    ),
    ("cannot parse float from empty string", "write a number"),
];

/// Returns the error of an argument that is an option with a dash which is no hyphen, unless a file has that name.
#[must_use]
pub fn pasted_dash(argument: &str) -> Option<String> {
    let name = argument.trim_start_matches(DASHES);
    let option = name.split('=').next().unwrap_or_default();
    let is_letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    let is_option =
        option.starts_with(|c: char| c.is_ascii_lowercase()) && option.chars().all(is_letter);
    (name.len() < argument.len() && is_option && !Path::new(argument).exists()).then(|| {
        let hyphens = if option.len() > 1 { "--" } else { "-" };
        format!(
            "error: {argument} begins with a dash that is no hyphen, as word processors and web pages make of two: type {hyphens}{name}\n"
        )
    })
}

/// Replaces the words of the library that parses numbers by ours; returns whether there were any.
pub fn replace_words(text: &mut String) -> bool {
    let is_of_number = NUMBERS.iter().any(|(words, _)| text.contains(words));
    for (words, ours) in NUMBERS {
        *text = text.replace(words, ours);
    }
    is_of_number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pasted_dash_is_named_and_a_text_that_begins_with_one_is_not() {
        for (argument, option) in [
            ("\u{2013}json", "type --json"),
            ("\u{2014}study=a b", "type --study=a b"),
            ("\u{2212}q", "type -q"),
        ] {
            let error = pasted_dash(argument).unwrap();
            assert!(error.contains(option), "{error}");
        }
        for text in [
            "--json",
            "\u{2013} tired",
            "\u{2014}Nina",
            "study",
            "\u{2013}",
        ] {
            assert_eq!(pasted_dash(text), None, "{text}");
        }
    }

    #[test]
    fn words_of_the_library_are_replaced() {
        let mut text = "invalid value '1013 hPa': invalid float literal".to_owned();
        assert!(
            replace_words(&mut text) && text.contains("without a unit"),
            "{text}"
        );
        assert!(!replace_words(&mut text));
    }
}
