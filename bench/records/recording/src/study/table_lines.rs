//! Lines of the study's tables, which have tabs between cells and which people edit in spreadsheets.

use std::ops::Range;

use csv::{ReaderBuilder, StringRecord, Trim};

/// Mark with which spreadsheets begin UTF-8 files.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Line of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableLine {
    /// Number of the line in its file, from 1.
    pub number: usize,
    /// Place in the text, with the line's end.
    pub place: Range<usize>,
    /// Cells, without the spaces around them.
    pub cells: Vec<String>,
}

/// Returns the lines of a table in order; the first one is the header.
///
/// Lines may end in any way and differ in their number of cells. A byte-order mark and blank lines are skipped. A quotation
/// mark is a character of its cell.
#[must_use]
pub fn table_lines(text: &str) -> Vec<TableLine> {
    let mut reader = ReaderBuilder::new()
        .delimiter(b'\t')
        .has_headers(false)
        .flexible(true)
        .quoting(false)
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut lines = Vec::new();
    // The reader skips the mark.
    let mut end = if text.starts_with(BYTE_ORDER_MARK) {
        BYTE_ORDER_MARK.len_utf8()
    } else {
        0
    };
    let (mut number, mut previous_start) = (1, end);
    let mut record = StringRecord::new();
    // UTF-8 text in memory can always be read.
    while reader
        .read_record(&mut record)
        .is_ok_and(|is_record| is_record)
    {
        // The reader attributes to a line the blank lines before it, and half of the line end `\r\n`.
        let start = end + line_ends(&text[end..]).len();
        end = usize::try_from(reader.position().byte()).unwrap_or(text.len());
        end += usize::from(is_within_line_end(text, end));
        number += count_line_ends(&text[previous_start..start]);
        previous_start = start;
        if record.iter().any(|cell| !cell.is_empty()) {
            lines.push(TableLine {
                number,
                place: start..end,
                cells: record.iter().map(str::to_owned).collect(),
            });
        }
    }
    lines
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

/// Returns the line ends with which a text begins.
fn line_ends(text: &str) -> &str {
    &text[..text.len() - text.trim_start_matches(['\r', '\n']).len()]
}

/// Returns whether `index` lies between the two characters of one line end.
fn is_within_line_end(text: &str, index: usize) -> bool {
    text[..index].ends_with('\r') && text[index..].starts_with('\n')
}

/// Counts the line ends of a text that begins with a line.
fn count_line_ends(text: &str) -> usize {
    let count = |end: &str| text.matches(end).count();
    count("\n") + count("\r") - count("\r\n")
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
            "sub-02",
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
        fn the_places_of_lines_are_apart_and_contain_their_cells(text in "\u{feff}?[ab\"\\t\\r\\n \u{a0}é]*") {
            let mut end = 0;
            for line in table_lines(&text) {
                prop_assert!(end <= line.place.start && line.place.start < line.place.end);
                end = line.place.end;
                let cells = text[line.place].split('\t').map(str::trim);
                prop_assert!(cells.eq(line.cells.iter()));
            }
        }
    }
}
