//! Quoted texts, comments and bare text of a TOML file, also of one that is not valid.

use std::ops::Range;

/// Kind of a part of a TOML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PartKind {
    /// Keys, signs, numbers.
    Bare,
    /// Text between double quotes on one line, in which a backslash begins an escape.
    Quoted,
    /// Text between single or triple quotes.
    OtherText,
    /// A comment.
    Comment,
}

/// Returns the parts of `text` in order, with their quotes. A quoted part without its end goes to the end of its line.
pub(crate) fn parts(text: &str) -> Vec<(PartKind, Range<usize>)> {
    let mut parts = Vec::new();
    let (mut start, mut bare_start) = (0, 0);
    while let Some(offset) = text[start..].find(['#', '"', '\'']) {
        let begin = start + offset;
        let rest = &text[begin..];
        let (kind, length) = match rest.as_bytes()[0] {
            b'#' => (PartKind::Comment, line_length(rest)),
            b'"' if rest.starts_with("\"\"\"") => {
                (PartKind::OtherText, triple_length(rest, "\"\"\""))
            }
            b'\'' if rest.starts_with("'''") => (PartKind::OtherText, triple_length(rest, "'''")),
            b'"' => (PartKind::Quoted, quoted_length(rest)),
            _ => {
                let line = &rest[..line_length(rest)];
                let end = line[1..].find('\'').map_or(line.len(), |end| end + 2);
                (PartKind::OtherText, end)
            }
        };
        parts.push((PartKind::Bare, bare_start..begin));
        parts.push((kind, begin..begin + length));
        start = begin + length;
        bare_start = start;
    }
    parts.push((PartKind::Bare, bare_start..text.len()));
    parts.retain(|(_, range)| !range.is_empty());
    parts
}

fn line_length(text: &str) -> usize {
    text.find(['\r', '\n']).unwrap_or(text.len())
}

/// Returns the length of a text between triple quotes; to the end of the file if they are not closed.
fn triple_length(text: &str, quotes: &str) -> usize {
    let inner = &text[quotes.len()..];
    inner
        .find(quotes)
        .map_or(text.len(), |end| quotes.len() + end + quotes.len())
}

fn quoted_length(text: &str) -> usize {
    let line = &text[..line_length(text)];
    let mut is_escaped = false;
    for (index, c) in line.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return index + 1,
            _ => {}
        }
    }
    line.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_and_comments_are_told_from_bare_text() {
        let text = "a = \"x # y\" # \"no\"\nb = 'C:\\' \nc = \"\"\"\n\"q\" # \"\"\" = \"\\\"\" d\n\"open\\\n";
        let found: Vec<_> = parts(text)
            .into_iter()
            .filter(|(kind, _)| *kind != PartKind::Bare)
            .map(|(kind, range)| (kind, &text[range]))
            .collect();
        assert_eq!(
            found,
            [
                (PartKind::Quoted, "\"x # y\""),
                (PartKind::Comment, "# \"no\""),
                (PartKind::OtherText, "'C:\\'"),
                (PartKind::OtherText, "\"\"\"\n\"q\" # \"\"\""),
                (PartKind::Quoted, "\"\\\"\""),
                (PartKind::Quoted, "\"open\\"),
            ]
        );
    }
}
