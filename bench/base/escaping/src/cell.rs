//! Text in table cells that a spreadsheet may open.

/// First characters that make a spreadsheet read a cell as a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];
/// Prefix that keeps a cell from being read as a formula, as in spreadsheets.
const MARK: char = '\'';

/// Returns a text as a cell that no spreadsheet reads as a formula: with an apostrophe in front where needed. Numbers
/// are unchanged. [`from_cell`] restores the text.
///
/// ```
/// use escaping::{from_cell, to_cell};
///
/// assert_eq!(to_cell("=HYPERLINK(\"http://x\")"), "'=HYPERLINK(\"http://x\")");
/// assert_eq!(to_cell("-1.5e-3"), "-1.5e-3");
/// for text in ["=1+1", "'=1+1", "''", "- a dash", "plain", "-1"] {
///     assert_eq!(from_cell(&to_cell(text)), text);
/// }
/// ```
#[must_use]
pub fn to_cell(text: &str) -> String {
    if is_obeyed(text) || is_marked(text) {
        format!("{MARK}{text}")
    } else {
        text.to_owned()
    }
}

/// Returns the text of a cell made by [`to_cell`].
#[must_use]
pub fn from_cell(cell: &str) -> &str {
    match cell.strip_prefix(MARK) {
        Some(text) if is_obeyed(text) || is_marked(text) => text,
        _ => cell,
    }
}

fn is_obeyed(text: &str) -> bool {
    // Digits only: spreadsheets do not know `-inf`.
    let is_number = || text.parse::<f64>().is_ok_and(f64::is_finite);
    text.starts_with(FORMULA) && !is_number()
}

/// Returns whether a text would be read as marked, so that it needs a second mark.
fn is_marked(text: &str) -> bool {
    text.strip_prefix(MARK)
        .is_some_and(|rest| is_obeyed(rest) || is_marked(rest))
}
