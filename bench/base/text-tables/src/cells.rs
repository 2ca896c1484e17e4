//! Cells of a line.

use std::borrow::Cow;
use std::ops::Range;

use crate::separator::Separator;

const QUOTE: char = '"';

/// Returns the cells of a line without the blanks around them, and without the quotation marks of RFC 4180.
///
/// Marks are literal in a cell that does not begin with one, that has text after the closing one, or that lacks a closing
/// one on its line.
#[must_use]
pub fn cells(line: &str, separator: Separator) -> Vec<Cow<'_, str>> {
    let scanned = scan(line, separator).into_iter();
    scanned.map(|(cell, _)| cell).collect()
}

/// Returns the cells of a line, each with its place in the line, blanks and quotation marks included.
pub(crate) fn scan(line: &str, separator: Separator) -> Vec<(Cow<'_, str>, Range<usize>)> {
    let mut scanned = Vec::new();
    let mut start = 0;
    loop {
        let rest = &line[start..];
        let (cell, length) = quoted(rest, separator).unwrap_or_else(|| {
            let length = rest.find(separator.character()).unwrap_or(rest.len());
            (Cow::Borrowed(rest[..length].trim()), length)
        });
        scanned.push((cell, start..start + length));
        start += length + 1;
        if start > line.len() {
            return scanned;
        }
    }
}

/// Returns the content of the quoted cell that `text` begins with, and the length of the cell up to its separator.
fn quoted(text: &str, separator: Separator) -> Option<(Cow<'_, str>, usize)> {
    let is_blank = |c: char| c.is_whitespace() && c != separator.character();
    let inner = text.trim_start_matches(is_blank).strip_prefix(QUOTE)?;
    let mut end = 0;
    let mut is_doubled = false;
    loop {
        end += inner[end..].find(QUOTE)?;
        if !inner[end + 1..].starts_with(QUOTE) {
            break;
        }
        is_doubled = true;
        end += 2;
    }
    let after = inner[end + 1..].trim_start_matches(is_blank);
    if !after.is_empty() && !after.starts_with(separator.character()) {
        return None;
    }
    let content = inner[..end].trim();
    let content = if is_doubled {
        Cow::Owned(content.replace("\"\"", "\""))
    } else {
        Cow::Borrowed(content)
    };
    Some((content, text.len() - after.len()))
}

/// Returns a text as a cell of a table with tabs: in quotation marks if it begins with one. The text has neither tabs nor
/// line ends.
#[must_use]
pub fn tab_cell(text: &str) -> Cow<'_, str> {
    if text.starts_with(QUOTE) {
        Cow::Owned(format!("\"{}\"", text.replace(QUOTE, "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn quotation_marks_enclose_separators_and_double_within() {
        for (line, expected) in [
            ("a,b", vec!["a", "b"]),
            (" a , b ,", vec!["a", "b", ""]),
            ("", vec![""]),
            ("\"x,y\",2", vec!["x,y", "2"]),
            (" \"x\" , \"\" ", vec!["x", ""]),
            ("\"say \"\"yes\"\"\",1", vec!["say \"yes\"", "1"]),
            // Literal marks.
            ("5\" disk,1", vec!["5\" disk", "1"]),
            ("\"open,1", vec!["\"open", "1"]),
            ("\"x\"y,1", vec!["\"x\"y", "1"]),
        ] {
            assert_eq!(cells(line, Separator::Comma), expected, "{line:?}");
        }
        assert_eq!(cells("\t\"a\t1\"\t ", Separator::Tab), ["", "a\t1", ""]);
    }

    proptest! {
        #[test]
        fn a_written_cell_reads_back(text in "[^\\t\\r\\n\\s][^\\t\\r\\n]{0,8}") {
            let text = text.trim();
            let line = format!("1\t{}\t2", tab_cell(text));
            prop_assert_eq!(cells(&line, Separator::Tab), ["1", text, "2"]);
        }

        #[test]
        fn places_are_apart_by_one_separator(line in "[ab\" ,;\\tµ]*") {
            for separator in Separator::ALL {
                let mut end = None;
                for (_, place) in scan(&line, separator) {
                    prop_assert_eq!(place.start, end.map_or(0, |end: usize| end + 1));
                    end = Some(place.end);
                }
                prop_assert_eq!(end, Some(line.len()));
            }
        }
    }
}
