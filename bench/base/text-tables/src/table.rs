//! Tables read whole.

use crate::cells::cells;
use crate::fault::TableFault;
use crate::header::{Columns, Header, stated_separator};
use crate::lines::{content, places};
use crate::number::{NumberFault, Numbers};
use crate::separator::Separator;
use crate::unit::unit;
use crate::units_row::units_row;

/// Table with a header, read whole.
#[derive(Debug, Clone)]
pub struct Table {
    /// Rows, without blank ones and the row of units.
    pub rows: Vec<TableRow>,
}

/// Row of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableRow {
    /// Number of its line, from 1.
    pub line: usize,
    texts: Vec<String>,
    numbers: Vec<Option<f64>>,
}

impl TableRow {
    /// Returns the cell of a column, by its index among the columns that are read; empty if the column is absent.
    #[must_use]
    pub fn text(&self, column: usize) -> &str {
        self.texts.get(column).map_or("", String::as_str)
    }

    /// Returns the number of a column, by its index among the columns that are read; `None` for an empty cell of an
    /// optional column, and for an absent one.
    #[must_use]
    pub fn number(&self, column: usize) -> Option<f64> {
        self.numbers.get(column).copied().flatten()
    }
}

impl Table {
    /// Reads the table in `text`.
    ///
    /// # Errors
    /// [`TableFault`] names line and column; a number that is not finite is refused.
    pub fn parse(text: &str, columns: &Columns) -> Result<Self, TableFault> {
        let lines = places(text).map(|(number, place)| (number, content(&text[place])));
        let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
        let empty = || TableFault::Empty {
            columns: columns.required.iter().map(ToString::to_string).collect(),
        };
        let (_, first) = lines.next().ok_or_else(empty)?;
        let stated = stated_separator(first);
        let line = match stated {
            Some(_) => lines.next().ok_or_else(empty)?.1,
            None => first,
        };
        let header = Header::read(line, stated, columns)?;
        let mut numbers = Numbers::new(header.separator);
        let mut rows: Vec<TableRow> = Vec::new();
        let mut is_first = true;
        for (line, text) in lines {
            let cells = cells(text, header.separator);
            if cells.iter().all(|cell| cell.is_empty()) {
                continue;
            }
            if std::mem::take(&mut is_first) && units_row(&cells, line, &header)? {
                continue;
            }
            require_width(&cells, line, &header)?;
            rows.push(row(&cells, line, &header, columns, &mut numbers)?);
        }
        Ok(Self { rows })
    }
}

/// Requires that a line has no more cells than the header, apart from empty ones.
fn require_width(
    cells: &[impl AsRef<str>],
    line: usize,
    header: &Header,
) -> Result<(), TableFault> {
    let Header {
        separator, width, ..
    } = *header;
    let is_empty = |cell: &&_| AsRef::<str>::as_ref(*cell).is_empty();
    let trailing = cells.iter().rev().take_while(is_empty).count();
    let count = cells.len() - trailing;
    if count <= width {
        return Ok(());
    }
    Err(match separator {
        Separator::Comma => TableFault::DecimalCommas {
            line,
            cells: count,
            columns: width,
        },
        _ => TableFault::Cells {
            line,
            cells: count,
            columns: width,
            separator,
        },
    })
}

fn row(
    cells: &[impl AsRef<str>],
    line: usize,
    header: &Header,
    columns: &Columns,
    numbers: &mut Numbers,
) -> Result<TableRow, TableFault> {
    let mut row = TableRow {
        line,
        texts: Vec::new(),
        numbers: Vec::new(),
    };
    for (column, place) in header.places() {
        let cell = place.and_then(|place| cells.get(place));
        let cell = cell.map_or("", AsRef::as_ref);
        if cell.is_empty() && columns.required.contains(&column) {
            let column = column.to_owned();
            return Err(TableFault::EmptyCell { line, column });
        }
        let number = match unit(column) {
            Some(_) if !cell.is_empty() => {
                let finite = |number: f64| number.is_finite().then_some(number);
                let number = numbers.read(cell);
                let number = number.and_then(|n| finite(n).ok_or(NumberFault::NotNumber));
                Some(number.map_err(|fault| TableFault::Number {
                    line,
                    column: column.to_owned(),
                    cell: cell.to_owned(),
                    fault,
                })?)
            }
            _ => None,
        };
        row.texts.push(cell.to_owned());
        row.numbers.push(number);
    }
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COLUMNS: Columns = Columns {
        required: &["axis", "mass_g"],
        optional: &["sigma_g"],
    };

    fn rows(text: &str) -> Result<Vec<(String, f64, Option<f64>)>, TableFault> {
        let table = Table::parse(text, &COLUMNS)?;
        let rows = table.rows.iter();
        let cells = |row: &TableRow| {
            let mass_g = row.number(1).unwrap();
            (row.text(0).to_owned(), mass_g, row.number(2))
        };
        Ok(rows.map(cells).collect())
    }

    #[test]
    fn a_table_reads_the_same_from_any_program() {
        let expected = vec![
            ("normal".to_owned(), 20.5, Some(0.25)),
            ("lateral".to_owned(), 50.0, None),
        ];
        for text in [
            "axis,mass_g,sigma_g\nnormal,20.5,0.25\nlateral,50,\n",
            "\u{feff}axis;mass_g;sigma_g\r\nnormal;20,5;0,25\r\nlateral;50;\r\n",
            "sep=;\raxis;mass_g;sigma_g\rnormal;20,5;0,25\rlateral;50\r",
            "axis\tmass_g\tsigma_g\n\tg\tg\nnormal\t20,5\t0,25\nlateral\t50\t\n\t\t\n\n",
            "\"\",\"sigma_g\",\"axis\",\"mass_g\"\n\"1\",0.25,\"normal\",20.5\n\"2\",,\"lateral\",50\n",
            "axis,mass_g,sigma_g\n\"normal\",\"20,5\",\"0,25\"\n\"lateral\",\"50\",\"\",,\n",
        ] {
            assert_eq!(rows(text), Ok(expected.clone()), "{text:?}");
        }
    }

    #[test]
    fn faults_name_their_line() {
        let fault = |text: &str| rows(text).unwrap_err();
        let decimal = fault("axis,mass_g\nnormal,20,5\n");
        assert!(matches!(
            decimal,
            TableFault::DecimalCommas {
                line: 2,
                cells: 3,
                ..
            }
        ));
        let cells = fault("axis\tmass_g\n\nnormal\t20\t5\n");
        assert!(
            matches!(cells, TableFault::Cells { line: 3, .. }),
            "{cells}"
        );
        let number = fault("axis;mass_g\nnormal;20\nlateral;heavy\n");
        assert_eq!(
            number.to_string(),
            "line 3, column `mass_g`: \"heavy\": it is not a number"
        );
        let infinite = fault("axis;mass_g\nnormal;NaN\n");
        assert!(
            matches!(infinite, TableFault::Number { line: 2, .. }),
            "{infinite}"
        );
        let unit = fault("axis;mass_g\n;kg\nnormal;0,02\n");
        assert!(
            matches!(unit, TableFault::UnitsRow { line: 2, .. }),
            "{unit}"
        );
        let cell = fault("axis;mass_g\n;20\n");
        assert!(
            matches!(cell, TableFault::EmptyCell { line: 2, .. }),
            "{cell}"
        );
        for text in ["", "\n\n", "sep=;\n"] {
            assert!(matches!(fault(text), TableFault::Empty { .. }), "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[axis,mg_;\\t\"\\r\\n0-9=\u{feff} ]*") {
            let _ = rows(&text);
            let _ = rows(&format!("axis;mass_g\n{text}"));
        }
    }
}
