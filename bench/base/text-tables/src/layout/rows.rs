//! Lines of a file that are rows of its table.

/// Marks with which comment lines begin.
const COMMENTS: [&str; 4] = ["#", "%", "//", "!"];

/// Returns a comment line without its mark; `None` for any other line.
pub(crate) fn comment(text: &str) -> Option<&str> {
    let text = text.trim_start();
    let mark = COMMENTS.iter().find(|mark| text.starts_with(**mark))?;
    Some(text.trim_start_matches(mark).trim())
}

/// Returns whether a line is one of a table: neither blank nor a comment.
#[must_use]
pub fn is_row(text: &str) -> bool {
    text.contains(|c: char| !c.is_whitespace() && !matches!(c, ',' | ';' | '"'))
        && comment(text).is_none()
}
