//! Lines of a table.

use std::ops::Range;

use crate::cells::cells;
use crate::separator::Separator;

/// Mark with which spreadsheets begin UTF-8 files.
pub(crate) const BYTE_ORDER_MARK: char = '\u{feff}';

/// Line of a table with tabs between cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableLine {
    /// Number of the line in its file, from 1.
    pub number: usize,
    /// Place in the text, with the line's end.
    pub place: Range<usize>,
    /// Cells, without the spaces and quotation marks around them.
    pub cells: Vec<String>,
}

/// Returns the lines of a table with tabs between cells, in order; the first one is the header.
///
/// Lines may end in any way and differ in their number of cells. A byte-order mark and blank lines are skipped.
#[must_use]
pub fn table_lines(text: &str) -> Vec<TableLine> {
    let with_cells = |(number, place): (usize, Range<usize>)| TableLine {
        number,
        cells: cells(content(&text[place.clone()]), Separator::Tab)
            .into_iter()
            .map(String::from)
            .collect(),
        place,
    };
    places(text)
        .map(with_cells)
        .filter(|line| line.cells.iter().any(|cell| !cell.is_empty()))
        .collect()
}

/// Returns `text` without the lines of its table that `is_removed` selects; every other byte is kept.
#[must_use]
pub fn without_lines(text: &str, is_removed: impl Fn(&TableLine) -> bool) -> String {
    let (mut rest, mut start) = (String::new(), 0);
    for TableLine { place, .. } in table_lines(text).into_iter().filter(is_removed) {
        rest += &text[start..place.start];
        start = place.end;
    }
    rest + &text[start..]
}

/// Returns number and place of every line, the blank ones included; a byte-order mark is in none.
pub(crate) fn places(text: &str) -> impl Iterator<Item = (usize, Range<usize>)> {
    let mut start = text.len() - text.trim_start_matches(BYTE_ORDER_MARK).len();
    let mut number = 0;
    std::iter::from_fn(move || {
        let rest = &text[start..];
        if rest.is_empty() {
            return None;
        }
        let length = match rest.find(['\r', '\n']) {
            Some(end) if rest[end..].starts_with("\r\n") => end + 2,
            Some(end) => end + 1,
            None => rest.len(),
        };
        let place = start..start + length;
        start = place.end;
        number += 1;
        Some((number, place))
    })
}

/// Returns a line without its end.
pub(crate) fn content(line: &str) -> &str {
    line.trim_end_matches(['\r', '\n'])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cells_by_number(text: &str) -> Vec<(usize, String)> {
        let lines = table_lines(text).into_iter();
        lines
            .map(|line| (line.number, line.cells.join("|")))
            .collect()
    }

    #[test]
    fn a_table_reads_the_same_with_any_line_end() {
        let lines = [
            "\u{feff}id\tage ",
            "",
            "sub-01\t 30",
            " \t",
            "\"sub-02\"",
            "sub-03\t\t\"x\";y",
        ];
        for end in ["\n", "\r\n", "\r"] {
            for last_end in ["", end] {
                let text = lines.join(end) + last_end;
                let expected = [
                    (1, "id|age"),
                    (3, "sub-01|30"),
                    (5, "sub-02"),
                    (6, "sub-03||\"x\";y"),
                ];
                assert_eq!(
                    cells_by_number(&text),
                    expected.map(|(number, cells)| (number, cells.to_owned())),
                    "{text:?}"
                );
            }
        }
        assert_eq!(table_lines(""), []);
        assert_eq!(table_lines("\u{feff}\r\n\n"), []);
    }

    #[test]
    fn the_removal_of_a_line_keeps_all_other_bytes() {
        let is_removed = |line: &TableLine| line.cells[0] == "sub-01";
        for (text, rest) in [
            ("id\nsub-01\nsub-02\n", "id\nsub-02\n"),
            (
                "\u{feff}id\r\n\r\nsub-01\tx\r\nsub-02 \r\n",
                "\u{feff}id\r\n\r\nsub-02 \r\n",
            ),
            ("id\rsub-01\rsub-02", "id\rsub-02"),
            ("id\n sub-01", "id\n"),
            ("id\nsub-010\n", "id\nsub-010\n"),
        ] {
            assert_eq!(without_lines(text, is_removed), rest, "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn the_places_of_lines_follow_one_another_to_the_end(text in "\u{feff}?[ab\"\\t\\r\\n \u{a0}é]*") {
            let mut end = text.len() - text.trim_start_matches(BYTE_ORDER_MARK).len();
            for (_, place) in places(&text) {
                prop_assert_eq!(place.start, end);
                prop_assert!(place.start < place.end);
                end = place.end;
            }
            prop_assert_eq!(end, text.len());
        }
    }
}
