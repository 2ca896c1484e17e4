//! Slips of typing that make a file no TOML, or TOML that says something else, each with its remedy.

use std::ops::Range;

use crate::character;
use crate::parts::{PartKind, parts};
use crate::place::line_at;

/// Largest number of characters of a line in a message.
const SHOWN: usize = 60;

/// Keys, or their last parts, with the name of a file or a port.
const PATH_KEYS: [&str; 6] = ["file", "path", "port", "folder", "library", "font"];

/// Place of a slip, and its words.
#[derive(Debug, PartialEq)]
pub(crate) struct Slip {
    /// Line, from 1.
    pub(crate) line: usize,
    /// Words, with the remedy.
    pub(crate) words: String,
}

/// Finds a path between double quotes with single backslashes, of which TOML makes tabs, line ends and other characters.
pub(crate) fn path_slip(text: &str) -> Option<Slip> {
    let quoted = parts(text).into_iter();
    let mut quoted = quoted.filter(|(kind, _)| *kind == PartKind::Quoted);
    quoted.find_map(|(_, range)| {
        let inner = inner(&text[range.clone()]);
        let is_path = is_rooted(inner) || is_path_key(text, range.start) && has_single(inner);
        is_path.then(|| backslash(text, range, inner))
    })
}

/// Finds a list of numbers with decimal commas, such as `[5,0, 1,5]`, of which TOML makes twice as many whole numbers: each of its
/// commas without a space between two digits, and each other one before a space.
pub(crate) fn list_slip(text: &str) -> Option<Slip> {
    let bare = parts(text).into_iter();
    let mut bare = bare.filter(|(kind, _)| *kind == PartKind::Bare);
    bare.find_map(|(_, range)| {
        let part = &text[range.clone()];
        part.match_indices('[').find_map(|(open, _)| {
            let inner = part[open + 1..].split(['[', ']']).next()?;
            let words = list_words(inner)?;
            let line = line_at(text, range.start + open);
            Some(Slip { line, words })
        })
    })
}

/// Returns the words for the inner text of a list if all of its values have decimal commas.
fn list_words(inner: &str) -> Option<String> {
    let values: Vec<&str> = separated(inner);
    let corrected: Option<Vec<String>> = values
        .iter()
        .map(|value| has_decimal_comma(value).then(|| value.replace(',', ".")))
        .collect();
    let corrected = corrected.filter(|values| values.len() > 1)?;
    Some(format!(
        "[{}] reads as {} whole numbers, and looks like {} numbers with decimal commas; write [{}], or a space after each comma",
        inner.trim(),
        2 * values.len(),
        values.len(),
        corrected.join(", ")
    ))
}

/// Returns the values of a list between its commas that a space or a line end follows.
fn separated(inner: &str) -> Vec<&str> {
    let mut values = Vec::new();
    let mut start = 0;
    for (at, _) in inner.match_indices(',') {
        if inner[at + 1..].starts_with(char::is_whitespace) {
            values.push(inner[start..at].trim());
            start = at + 1;
        }
    }
    values.push(inner[start..].trim().trim_end_matches(','));
    values.retain(|value| !value.is_empty());
    values
}

fn has_decimal_comma(value: &str) -> bool {
    let digits = value.strip_prefix(['+', '-']).unwrap_or(value);
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    digits
        .split_once(',')
        .is_some_and(|(whole, fraction)| is_digits(whole) && is_digits(fraction))
}

/// Finds the slip on the line of the byte at `offset`, where a parser stopped.
pub(crate) fn slip(text: &str, offset: usize) -> Option<Slip> {
    let offset = floor(text, offset);
    let start = text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[start..]
        .find('\n')
        .map_or(text.len(), |end| start + end);
    let on_line = |range: &Range<usize>| range.start.max(start)..range.end.min(end);
    let parts: Vec<_> = parts(text)
        .into_iter()
        .map(|(kind, range)| (kind, on_line(&range)))
        .filter(|(_, range)| range.start < range.end)
        .collect();
    for (kind, range) in &parts {
        let inner = inner(&text[range.clone()]);
        if *kind == PartKind::Quoted && has_wrong_escape(inner) {
            return Some(backslash(text, range.clone(), inner));
        }
    }
    let line = line_at(text, start);
    let bare = parts.iter().filter(|(kind, _)| *kind == PartKind::Bare);
    for (_, range) in bare.clone() {
        if let Some(words) = text[range.clone()].chars().find_map(character::words) {
            return Some(Slip { line, words });
        }
    }
    let is_group = |(kind, range): &&(PartKind, Range<usize>)| {
        let is_quote = *kind == PartKind::OtherText && text[range.start..].starts_with('\'');
        is_quote && text[..range.start].ends_with(|c: char| c.is_ascii_digit())
    };
    if parts.iter().any(|part| is_group(&part)) {
        let words =
            "the mark ' does not group the digits of a number; write it without groups".to_owned();
        return Some(Slip { line, words });
    }
    let words = bare
        .filter_map(|(_, range)| text.get(range.clone()))
        .find_map(number_words)?;
    Some(Slip { line, words })
}

/// Returns the line of the byte at `offset` for a message, with invisible characters as names.
pub(crate) fn shown_line(text: &str, offset: usize) -> String {
    let offset = floor(text, offset);
    let start = text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[start..].lines().next().unwrap_or_default().trim();
    let shown: String = line.chars().take(SHOWN).collect();
    character::visible(&shown)
}

fn floor(text: &str, offset: usize) -> usize {
    text.floor_char_boundary(offset.min(text.len()))
}

/// Returns the text between the quotes of a quoted part, which may lack its end.
fn inner(quoted: &str) -> &str {
    let inner = quoted.strip_prefix('"').unwrap_or(quoted);
    inner.strip_suffix('"').unwrap_or(inner)
}

/// Returns whether a text begins as a path of Windows with single backslashes: `D:\a`, `\\server`, `\\.\COM12`.
fn is_rooted(inner: &str) -> bool {
    let bytes = inner.as_bytes();
    let drive = matches!(bytes, [letter, b':', b'\\', rest @ ..]
        if letter.is_ascii_alphabetic() && rest.first() != Some(&b'\\'));
    let share = matches!(bytes, [b'\\', b'\\', next, ..] if *next != b'\\');
    drive || share
}

/// Returns whether the value at `offset` has a key for the name of a file or a port.
fn is_path_key(text: &str, offset: usize) -> bool {
    let head = &text[..offset];
    let line = head.rsplit('\n').next().unwrap_or_default();
    let Some((key, _)) = line.rsplit_once('=') else {
        return false;
    };
    let key = key
        .trim()
        .rsplit(['.', ' ', '{', ','])
        .next()
        .unwrap_or_default();
    let last = key.rsplit('_').next().unwrap_or_default();
    PATH_KEYS.contains(&last)
}

/// Returns whether a text has a backslash that is not doubled and does not precede a quotation mark.
fn has_single(inner: &str) -> bool {
    escapes(inner).any(|(escape, _)| !matches!(escape, '\\' | '"'))
}

/// Returns whether a text has a backslash that begins no escape of TOML.
fn has_wrong_escape(inner: &str) -> bool {
    escapes(inner).any(|(escape, rest)| {
        let has_digits = |count: usize| {
            let digits = rest.chars().take(count);
            digits.filter(char::is_ascii_hexdigit).count() == count
        };
        match escape {
            'b' | 't' | 'n' | 'f' | 'r' | 'e' | '"' | '\\' => false,
            'x' => !has_digits(2),
            'u' => !has_digits(4),
            'U' => !has_digits(8),
            _ => true,
        }
    })
}

/// Returns the character after each backslash that begins an escape, with the text after it. A backslash at the end precedes
/// the closing quotation mark.
fn escapes(inner: &str) -> impl Iterator<Item = (char, &str)> {
    let mut rest = inner;
    std::iter::from_fn(move || {
        let (_, after) = rest.split_once('\\')?;
        let mut chars = after.chars();
        let escape = chars.next().unwrap_or('"');
        rest = chars.as_str();
        Some((escape, rest))
    })
}

fn backslash(text: &str, range: Range<usize>, inner: &str) -> Slip {
    let inner = inner.trim_end_matches('"');
    Slip {
        line: line_at(text, range.start),
        words: format!(
            "the backslash in \"{inner}\" begins an escape, such as \\t for a tab; write '{inner}' between single quotes, or \
             / or \\\\ for each backslash"
        ),
    }
}

/// Returns the words for a number that is written in another way than TOML's, after a sign of equality or within a list.
fn number_words(bare: &str) -> Option<String> {
    let mut rest = bare;
    while let Some(at) = rest.find(['=', '[', ',']) {
        let is_value = rest.as_bytes()[at] == b'=';
        rest = &rest[at + 1..];
        let value = rest.trim_start();
        let is_digit = |c: char| c.is_ascii_digit() || "+-._eE".contains(c) || is_value && c == ',';
        let end = value.find(|c| !is_digit(c)).unwrap_or(value.len());
        let number = value[..end].trim_end_matches(',');
        if let Some(corrected) = corrected(number) {
            return Some(format!(
                "`{number}` is not a number of TOML, whose decimal sign is a point with a digit on both sides; write {corrected}"
            ));
        }
    }
    None
}

/// Returns a number as TOML writes it; `None` for one that TOML reads, and for other text.
pub(crate) fn corrected(text: &str) -> Option<String> {
    let (sign, digits) = match text.strip_prefix(['+', '-']) {
        Some(rest) => (&text[..1], rest),
        None => ("", text),
    };
    let (mantissa, exponent) = match digits.find(['e', 'E']) {
        Some(at) => digits.split_at(at),
        None => (digits, ""),
    };
    let signs = mantissa.matches(['.', ',']).count();
    let is_number = mantissa.starts_with(|c: char| c.is_ascii_digit() || ".,".contains(c))
        && mantissa
            .chars()
            .all(|c| c.is_ascii_digit() || ".,".contains(c))
        && mantissa.bytes().any(|byte| byte.is_ascii_digit());
    if !is_number {
        return None;
    }
    if signs > 1 {
        return Some("it with one point and without groups".to_owned());
    }
    let (whole, fraction) = match mantissa.split_once(['.', ',']) {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (mantissa, None),
    };
    let stripped = whole.trim_start_matches('0');
    let stripped = if stripped.is_empty() { "0" } else { stripped };
    let fraction = match fraction {
        Some("") => ".0".to_owned(),
        Some(fraction) => format!(".{fraction}"),
        None => String::new(),
    };
    let number = format!("{sign}{stripped}{fraction}{exponent}");
    if number == text {
        return None;
    }
    let is_thousand = mantissa.contains(',') && fraction.len() == 4 && stripped != "0";
    Some(if is_thousand {
        format!(
            "{number}, or {sign}{} if the comma groups thousands",
            mantissa.replace(',', "")
        )
    } else {
        number
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_corrected() {
        for (text, expected) in [
            ("55,0", Some("55.0")),
            ("-0,05", Some("-0.05")),
            (".05", Some("0.05")),
            ("-.5e3", Some("-0.5e3")),
            ("5.", Some("5.0")),
            ("5.e3", Some("5.0e3")),
            ("007", Some("7")),
            (",5", Some("0.5")),
            (
                "35,000",
                Some("35.000, or 35000 if the comma groups thousands"),
            ),
            ("1.234,5", Some("it with one point and without groups")),
            ("5.0", None),
            ("35e3", None),
            ("0", None),
            ("e", None),
            ("", None),
            ("-", None),
        ] {
            assert_eq!(corrected(text).as_deref(), expected, "{text}");
        }
    }

    #[test]
    fn decimal_commas_in_a_list_are_found_where_toml_reads_whole_numbers() {
        for (list, written) in [
            ("[5,0, 1,0]", "[5.0, 1.0]"),
            ("[-0,5, 12,25, 3,0,]", "[-0.5, 12.25, 3.0]"),
            ("[\n  1,5,\n  2,5,\n]", "[1.5, 2.5]"),
            ("[[1, 2], [0,5, 1,5]]", "[0.5, 1.5]"),
        ] {
            let slip = list_slip(&format!("a = 1\nb = {list}\n")).unwrap();
            assert!(slip.words.contains(written), "{list}: {}", slip.words);
            assert_eq!(slip.line, 2, "{list}");
        }
        for list in [
            "[5, 0, 1, 0]",
            "[5,0]",
            "[5,0,1,0]",
            "[5,0, 1]",
            "[5.0, 1.0]",
            "['5,0', '1,0']",
            "[]",
        ] {
            assert_eq!(
                list_slip(&format!("a = {list} # [5,0, 1,0]")),
                None,
                "{list}"
            );
        }
    }

    #[test]
    fn a_path_of_windows_is_found_also_where_toml_reads_it() {
        for value in [
            r#""D:\test\new.cal""#,
            r#""C:\Users\lab\FT.cal""#,
            r#""\\.\COM12""#,
            r#""\\nas\temp""#,
        ] {
            let text = format!("a = 1\nname = {value}\n");
            let slip = path_slip(&text).unwrap();
            let plain = value.trim_matches('"');
            assert_eq!(slip.line, 2);
            assert!(slip.words.contains(&format!("'{plain}'")), "{}", slip.words);
        }
        assert!(path_slip("cal_file = \"runs\\new.cal\"\n").is_some());
        assert!(path_slip("[a]\nb = { port = \"x\\tty\" }\n").is_some());
        for text in [
            r#"cal_file = "D:\\test\\new.cal""#,
            r#"cal_file = 'D:\test\new.cal'"#,
            r#"cal_file = "runs/new.cal""#,
            r#"port = "\\\\.\\COM12""#,
            r#"wait = "One moment,\nplease""#,
            r#"# "D:\test""#,
            r#"quote = "say \"a\"""#,
        ] {
            assert_eq!(path_slip(text), None, "{text}");
        }
    }
}
