//! Text in the cell of a table that a spreadsheet may open.

/// First characters by which a spreadsheet takes a cell for a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];
/// What is put before such a text, as spreadsheets themselves do.
const MARK: char = '\'';

/// Returns a text as a cell that no spreadsheet takes for a formula: with an apostrophe before it where one would. Numbers
/// stay as they are. [`from_cell`] gives the text back.
///
/// ```
/// use files::{from_cell, to_cell};
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

/// Returns the text of a cell that [`to_cell`] made.
#[must_use]
pub fn from_cell(cell: &str) -> &str {
    match cell.strip_prefix(MARK) {
        Some(text) if is_obeyed(text) || is_marked(text) => text,
        _ => cell,
    }
}

fn is_obeyed(text: &str) -> bool {
    // Digits: spreadsheets know no `-inf`.
    let is_number = || text.parse::<f64>().is_ok_and(f64::is_finite);
    text.starts_with(FORMULA) && !is_number()
}

/// Returns whether a text would be read as marked, so that it needs a mark of its own.
fn is_marked(text: &str) -> bool {
    text.strip_prefix(MARK)
        .is_some_and(|rest| is_obeyed(rest) || is_marked(rest))
}
