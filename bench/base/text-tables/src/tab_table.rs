//! Tables with tabs between cells, which people edit and the program continues.

use std::ops::Range;

use crate::cells::{cells, scan, tab_cell};
use crate::fault::TableFault;
use crate::lines::{TableLine, content, table_lines};
use crate::separator::Separator;

/// Cell without a value.
const NO_VALUE: &str = "n/a";

/// Table with tabs between cells, in memory. A change keeps every byte that it does not concern: order of columns, line
/// ends, quotation marks, byte-order mark.
#[derive(Debug, Clone)]
pub struct TabTable {
    text: String,
    header: TableLine,
    rows: Vec<TableLine>,
}

impl TabTable {
    /// Reads the table in `text`, which has the column `key`.
    ///
    /// # Errors
    /// The table is empty, its cells are separated by something else, or the column is missing or there twice.
    pub fn parse(text: String, key: &str) -> Result<Self, TableFault> {
        let mut lines = table_lines(&text).into_iter();
        let header = lines.next().ok_or_else(|| TableFault::Empty {
            columns: vec![key.to_owned()],
        })?;
        match header.cells.iter().filter(|cell| *cell == key).count() {
            0 => return Err(without_key(&text, &header, key)),
            1 => {}
            _ => {
                let column = key.to_owned();
                return Err(TableFault::Twice { column });
            }
        }
        let rows = lines.collect();
        Ok(Self { text, header, rows })
    }

    /// Returns the text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the rows, without blank ones.
    #[must_use]
    pub fn rows(&self) -> &[TableLine] {
        &self.rows
    }

    /// Returns the names of the columns.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.header.cells
    }

    /// Returns the index of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.header.cells.iter().position(|cell| cell == name)
    }

    /// Returns the fault of the first row with another number of cells than the header.
    #[must_use]
    pub fn uneven_row(&self) -> Option<TableFault> {
        let columns = self.header.cells.len();
        let row = self.rows.iter().find(|row| row.cells.len() != columns)?;
        Some(TableFault::Cells {
            line: row.number,
            cells: row.cells.len(),
            columns,
            separator: Separator::Tab,
        })
    }

    /// Adds a row with a value for some columns; columns that the table lacks are left out, and the others have no value.
    pub fn add_row(&mut self, values: &[(&str, &str)]) {
        let value = |column: &String| {
            let found = values.iter().find(|(name, _)| name == column);
            tab_cell(found.map_or(NO_VALUE, |(_, value)| value)).into_owned()
        };
        let line: Vec<String> = self.header.cells.iter().map(value).collect();
        let line_end = self.line_end();
        let mut text = std::mem::take(&mut self.text);
        if !text.ends_with(['\r', '\n']) {
            text += line_end;
        }
        text += &line.join("\t");
        text += line_end;
        self.replace(text);
    }

    /// Sets the cell of a row, by their indices; a shorter row is filled up.
    pub fn set(&mut self, row: usize, column: usize, value: &str) {
        let mut text = self.text.clone();
        let end = self.fill(&mut text, row, column + 1);
        let start = self.rows[row].place.start;
        let scanned = scan(content(&text[start..end]), Separator::Tab);
        let Some(place) = scanned.get(column).map(|(_, place)| place.clone()) else {
            return;
        };
        text.replace_range(start + place.start..start + place.end, &tab_cell(value));
        self.replace(text);
    }

    /// Adds a column without values after the last one; returns its index.
    pub fn add_column(&mut self, name: &str) -> usize {
        let width = self.header.cells.len();
        let mut text = self.text.clone();
        // From the end, so that the places before stay.
        for row in (0..self.rows.len()).rev() {
            self.fill(&mut text, row, width + 1);
        }
        let end = end_of_content(&text, &self.header.place);
        text.insert_str(end, &format!("\t{name}"));
        self.replace(text);
        width
    }

    /// Fills a row of `text` up to `width` cells; returns the end of its line.
    fn fill(&self, text: &mut String, row: usize, width: usize) -> usize {
        let row = &self.rows[row];
        let missing = width.saturating_sub(row.cells.len());
        let filler = format!("\t{NO_VALUE}").repeat(missing);
        text.insert_str(end_of_content(text, &row.place), &filler);
        row.place.end + filler.len()
    }

    fn line_end(&self) -> &'static str {
        let header = &self.text[self.header.place.clone()];
        let ends = ["\r\n", "\r", "\n"];
        ends.into_iter()
            .find(|end| header.ends_with(end))
            .unwrap_or("\n")
    }

    fn replace(&mut self, text: String) {
        let mut lines = table_lines(&text).into_iter();
        if let Some(header) = lines.next() {
            self.header = header;
        }
        self.rows = lines.collect();
        self.text = text;
    }
}

fn end_of_content(text: &str, place: &Range<usize>) -> usize {
    place.start + content(&text[place.clone()]).len()
}

/// Explains a header without the column `key`: another separator, or no such column.
fn without_key(text: &str, header: &TableLine, key: &str) -> TableFault {
    let line = content(&text[header.place.clone()]);
    let has_key = |separator: &Separator| cells(line, *separator).iter().any(|cell| cell == key);
    match Separator::ALL.into_iter().find(has_key) {
        Some(separator) => TableFault::NotTabs {
            line: header.number,
            separator,
        },
        None => TableFault::MissingColumn {
            column: key.to_owned(),
            header: line.chars().filter(|c| !c.is_control()).take(80).collect(),
            separator: Separator::Tab,
            nearest: None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> TabTable {
        TabTable::parse(text.to_owned(), "id").unwrap()
    }

    #[test]
    fn a_row_takes_the_files_own_columns_and_line_ends() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["\u{feff}age\t\"id\"\tgroup", "25\tsub-01\twet"].join(end);
            let mut table = table(&text);
            table.add_row(&[("id", "sub-02"), ("date", "2026-01-31"), ("group", "\"x\"")]);
            let expected = format!("{text}{end}n/a\tsub-02\t\"\"\"x\"\"\"{end}");
            assert_eq!(table.text(), expected);
            assert_eq!(table.rows()[1].cells, ["n/a", "sub-02", "\"x\""]);
        }
    }

    #[test]
    fn a_cell_and_a_column_change_no_other_byte() {
        let mut table = table("id\tage\tsex\r\n\r\nsub-01 \t\"n/a\"\tF\r\nsub-02\r\n");
        table.set(0, 1, "31");
        assert_eq!(
            table.text(),
            "id\tage\tsex\r\n\r\nsub-01 \t31\tF\r\nsub-02\r\n"
        );
        table.set(1, 1, "40");
        let column = table.add_column("hand");
        table.set(0, column, "left");
        assert_eq!(
            table.text(),
            "id\tage\tsex\thand\r\n\r\nsub-01 \t31\tF\tleft\r\nsub-02\t40\tn/a\tn/a\r\n"
        );
        assert_eq!(table.uneven_row(), None);
    }

    #[test]
    fn a_table_without_tabs_is_named_by_its_separator() {
        for (text, separator) in [
            ("id,age\nsub-01,25\n", Separator::Comma),
            ("\"id\";\"age\"\nsub-01;25\n", Separator::Semicolon),
        ] {
            let fault = TabTable::parse(text.to_owned(), "id").unwrap_err();
            assert_eq!(fault, TableFault::NotTabs { line: 1, separator });
        }
        let fault = TabTable::parse("name\tage\n".to_owned(), "id").unwrap_err();
        assert!(matches!(fault, TableFault::MissingColumn { .. }), "{fault}");
        let fault = TabTable::parse("\u{feff}\r\n".to_owned(), "id").unwrap_err();
        assert!(matches!(fault, TableFault::Empty { .. }), "{fault}");
        let uneven = table("id\tage\n\nsub-01  25\n").uneven_row();
        assert!(matches!(
            uneven,
            Some(TableFault::Cells {
                line: 3,
                cells: 1,
                ..
            })
        ));
    }
}
