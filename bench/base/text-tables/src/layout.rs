//! Layout of a table of any program, found from its first lines: separator, decimal sign, header, units.

mod cell_words;
mod number_cell;
mod rows;
mod time_cell;
mod unit_text;

use std::borrow::Cow;

use crate::header::stated_separator;
use crate::number::Numbers;
use crate::separator::Separator;
pub use number_cell::{Split, number};
use rows::comment;
pub use rows::is_row;
use time_cell::is_time;
pub use time_cell::{TimeCells, TimeFault, time_s};
pub use unit_text::is_time_name;
use unit_text::{is_unit, name_and_unit, unit_text};

/// Reason why lines have no layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LayoutFault {
    /// No row of numbers is there.
    #[error("text without a table of numbers")]
    NoTable,
    /// Commas separate cells, and seem to be decimal signs.
    #[error(
        "a row of {cells} cells below a header of {header}, in which commas seem to be decimal signs and to separate cells"
    )]
    TwoCommas {
        /// Number of the line, from 1.
        line: usize,
        /// Cells of the row.
        cells: usize,
        /// Cells of the header.
        header: usize,
    },
}

/// Layout of a table.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Separator of cells.
    pub split: Split,
    /// Columns, in order.
    pub columns: Vec<LayoutColumn>,
    /// Index of the first row of numbers among the lines.
    pub first: usize,
    /// Reader of numbers that knows the decimal sign where the lines show it.
    pub numbers: Numbers,
    /// Names and values stated above the table.
    pub stated: Vec<(String, String)>,
}

/// Column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutColumn {
    /// Name in the header, or the column's number.
    pub name: String,
    /// Unit in the header or in a row of units.
    pub unit: Option<String>,
    /// Content of the cells.
    pub kind: ColumnKind,
}

/// Content of a column's cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Numbers.
    Number,
    /// Times of day, or dates with them.
    Time,
    /// Text.
    Text,
}

/// Table under one separator.
struct Candidate {
    split: Split,
    width: usize,
    kinds: Vec<ColumnKind>,
    first: usize,
    /// Rows of numbers in the lines.
    rows: usize,
    /// Whether the line above the numbers has as many cells.
    has_header: bool,
}

impl Candidate {
    fn numeric(&self) -> usize {
        let columns = self.kinds.iter().filter(|kind| **kind != ColumnKind::Text);
        columns.count() * self.rows
    }
}

impl Layout {
    /// Finds the layout from the first lines of a file.
    ///
    /// # Errors
    /// No table of numbers is there, or its commas have two meanings.
    pub fn find(lines: &[String]) -> Result<Self, LayoutFault> {
        let stated = lines.first().and_then(|line| stated_separator(line));
        let splits = match stated {
            Some(separator) => vec![Split::At(separator)],
            None => Split::ALL.to_vec(),
        };
        let candidates = splits
            .into_iter()
            .filter_map(|split| candidate(lines, split));
        let rank = |candidate: &Candidate| (candidate.has_header, candidate.numeric());
        let mut best: Option<Candidate> = None;
        for candidate in candidates {
            // The first of two equal ones is the safer separator.
            let is_better = best.as_ref().is_none_or(|best| {
                rank(&candidate) > rank(best) && candidate.numeric() * 2 > best.numeric()
                    || candidate.numeric() > 2 * best.numeric()
            });
            if is_better {
                best = Some(candidate);
            }
        }
        let Some(best) = best else {
            return Err(LayoutFault::NoTable);
        };
        require_one_comma(lines, &best)?;
        Ok(best.layout(lines))
    }
}

/// Returns the table in the lines under a separator.
fn candidate(lines: &[String], split: Split) -> Option<Candidate> {
    let cells: Vec<Vec<Cow<'_, str>>> = lines
        .iter()
        .map(|line| match is_row(line) {
            true => trimmed(split.cells(line)),
            false => Vec::new(),
        })
        .collect();
    let mut numbers = split.numbers();
    let mut is_number = |cell: &str| !cell.is_empty() && number(cell, &mut numbers).is_ok();
    // Width of most lines with a number.
    let mut widths = std::collections::BTreeMap::new();
    for cells in &cells {
        if cells.iter().any(|cell| is_number(cell)) {
            *widths.entry(cells.len()).or_insert(0usize) += cells.len();
        }
    }
    let (&usual, _) = widths.iter().max_by_key(|(_, weight)| **weight)?;
    let width = widest(&cells, usual, &mut is_number);
    let rows: Vec<usize> = (0..cells.len())
        .filter(|i| cells[*i].len() <= width && cells[*i].iter().any(|cell| is_number(cell)))
        .filter(|i| cells[*i].len() == width || width > usual)
        .collect();
    // The second half of the lines is beyond headers, and decides what each column has.
    let sample = &rows[rows.len() / 2..];
    let kinds: Vec<ColumnKind> = (0..width)
        .map(|column| {
            let filled = |rows: &[usize]| {
                let cells = rows.iter().filter_map(|row| cells[*row].get(column));
                cells
                    .filter(|cell| !cell.is_empty())
                    .map(ToString::to_string)
                    .collect::<Vec<_>>()
            };
            let late = filled(sample);
            let filled = if late.is_empty() { filled(&rows) } else { late };
            let column = || filled.iter().map(String::as_str);
            if filled.is_empty() {
                return ColumnKind::Text;
            }
            let count = column().count();
            let numeric = column().filter(|cell| {
                number(cell, &mut split.numbers()).is_ok() || is_decimal_group(cell, split)
            });
            if numeric.count() == count {
                ColumnKind::Number
            } else if column().all(is_time) {
                ColumnKind::Time
            } else {
                ColumnKind::Text
            }
        })
        .collect();
    let is_data = |i: usize| {
        let cells = &cells[i];
        let fits = |(column, cell): (usize, &Cow<'_, str>)| match kinds[column] {
            ColumnKind::Number => {
                number(cell, &mut split.numbers()).is_ok() || is_decimal_group(cell, split)
            }
            ColumnKind::Time => is_time(cell),
            ColumnKind::Text => true,
        };
        !cells.is_empty()
            && cells.len() <= width
            && cells.iter().enumerate().all(fits)
            && cells.iter().any(|cell| has_value(cell))
    };
    let data: Vec<usize> = (0..cells.len()).filter(|i| is_data(*i)).collect();
    let has_numbers = kinds.iter().any(|kind| *kind != ColumnKind::Text);
    let is_wide = |i: usize| cells[i].len() >= usual || split.cells(&lines[i]).len() >= width;
    let first = first_of_table(&data, &cells, is_wide)?;
    let first = with_flawed_rows(first, &cells, width, |column, cell| {
        match kinds.get(column)? {
            ColumnKind::Number => {
                Some(number(cell, &mut split.numbers()).is_ok() || is_decimal_group(cell, split))
            }
            ColumnKind::Time => Some(is_time(cell)),
            ColumnKind::Text => None,
        }
    });
    let above = cells[..first].iter().rev().find(|cells| !cells.is_empty());
    let commented = lines[..first].iter().rev().find_map(|line| comment(line));
    let is_header = |cells: &Vec<Cow<'_, str>>| match split {
        Split::At(_) => cells.len() >= width,
        Split::Blanks => cells.len() == width,
    };
    let has_header = above.is_some_and(is_header)
        || commented.is_some_and(|text| trimmed(split.cells(text)).len() == width);
    has_numbers.then_some(Candidate {
        split,
        width,
        kinds,
        first,
        rows: data.iter().filter(|row| **row >= first).count(),
        has_header,
    })
}

/// Returns the number of columns: more than most rows have if the header has as many, or if there is none. Rows with words,
/// as above a table, do not count.
fn widest(
    cells: &[Vec<Cow<'_, str>>],
    usual: usize,
    is_number: &mut impl FnMut(&str) -> bool,
) -> usize {
    let mut is_bare = |cells: &Vec<Cow<'_, str>>| {
        !cells.is_empty() && cells.iter().all(|cell| cell.is_empty() || is_number(cell))
    };
    let bare: Vec<usize> = (0..cells.len()).filter(|i| is_bare(&cells[*i])).collect();
    let widest = bare.iter().map(|i| cells[*i].len()).max().unwrap_or(usual);
    let first = bare.first().copied().unwrap_or(0);
    let above = cells[..first].iter().rev().find(|cells| !cells.is_empty());
    match above {
        Some(header) if header.len() < widest => usual,
        _ => widest.max(usual),
    }
}

/// Returns the first row of the table: the first wide one after which only rows of the table or nothing come next.
fn first_of_table(
    data: &[usize],
    cells: &[Vec<Cow<'_, str>>],
    is_wide: impl Fn(usize) -> bool,
) -> Option<usize> {
    let next_line = |row: usize| (row + 1..cells.len()).find(|i| !cells[*i].is_empty());
    data.iter().copied().find(|row| {
        let is_followed = next_line(*row).is_none_or(|next| data.binary_search(&next).is_ok());
        is_wide(*row) && is_followed
    })
}

/// Returns the first row of the table, with those above it that are rows of numbers but for a few cells: `fits` says whether a
/// cell is of its column's kind, and nothing of a column of texts.
fn with_flawed_rows(
    first: usize,
    cells: &[Vec<Cow<'_, str>>],
    width: usize,
    fits: impl Fn(usize, &str) -> Option<bool>,
) -> usize {
    let counts = |row: usize| {
        let filled = cells[row].iter().enumerate();
        let filled = filled.filter(|(_, cell)| !cell.is_empty());
        let fit = filled.filter_map(|(column, cell)| Some((column, cell, fits(column, cell)?)));
        fit.fold(
            (0, 0, true),
            |(good, bad, is_near), (column, cell, is_fit)| {
                // A name of a column is no number, and stands above texts too.
                let is_like =
                    cell.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-'));
                match is_fit {
                    true => (good + 1, bad, is_near),
                    false => (good, bad + 1, is_near && (is_like || column > 0)),
                }
            },
        )
    };
    let is_header = |row: usize| cells[row].len() >= width && counts(row).0 == 0;
    let mut found = first;
    while let Some(row) = (0..found).rev().find(|row| !cells[*row].is_empty()) {
        let (good, bad, is_near) = counts(row);
        let mut above = (0..row).rev().filter(|above| !cells[*above].is_empty());
        let has_header = above
            .next()
            .is_none_or(|above| is_header(above) || counts(above).0 > 0);
        let is_flawed =
            cells[row].len() == width && good >= bad && good > 0 && is_near && has_header;
        if !is_flawed {
            break;
        }
        found = row;
    }
    found
}

/// Returns whether a cell has a digit, or is a missing value of a column of numbers.
fn has_value(cell: &str) -> bool {
    cell.bytes().any(|byte| byte.is_ascii_digit()) || cell.to_ascii_lowercase().ends_with("nan")
}

/// Returns whether a cell is a number that groups thousands or has a decimal comma, where a comma does not separate cells.
fn is_decimal_group(cell: &str, split: Split) -> bool {
    split != Split::At(Separator::Comma)
        && cell.matches(',').count() == 1
        && cell.replace(',', ".").parse::<f64>().is_ok()
}

/// Returns the cells without the empty ones at the end.
fn trimmed(cells: Vec<Cow<'_, str>>) -> Vec<Cow<'_, str>> {
    let mut cells = cells;
    while cells.last().is_some_and(|cell| cell.is_empty()) {
        cells.pop();
    }
    cells
}

/// Refuses a table in which commas separate cells and are decimal signs too.
fn require_one_comma(lines: &[String], best: &Candidate) -> Result<(), LayoutFault> {
    let above = lines[..best.first].iter().rev().find(|line| is_row(line));
    let Some(above) = above.filter(|_| best.split == Split::At(Separator::Comma)) else {
        return Ok(());
    };
    let header = trimmed(best.split.cells(above)).len();
    let is_doubled = header > 1 && best.width == 2 * header
        || header == 1 && best.width == 2 && !above.contains(',');
    if !is_doubled {
        return Ok(());
    }
    Err(LayoutFault::TwoCommas {
        line: best.first + 1,
        cells: best.width,
        header,
    })
}

impl Candidate {
    fn layout(self, lines: &[String]) -> Layout {
        let (names, units) = self.header(lines);
        let mut columns: Vec<LayoutColumn> = Vec::new();
        for (i, kind) in self.kinds.iter().enumerate() {
            let text = names.get(i).map_or("", String::as_str);
            let (_, unit) = name_and_unit(text);
            let below = units.get(i).filter(|unit| !unit.is_empty());
            let name = match text {
                "" => i.to_string(),
                text => text.to_owned(),
            };
            columns.push(LayoutColumn {
                name: unique(name, &columns),
                unit: below.cloned().or(unit.map(str::to_owned)),
                kind: *kind,
            });
        }
        let mut numbers = self.split.numbers();
        for line in lines[self.first..].iter().filter(|line| is_row(line)) {
            for (column, cell) in self.split.cells(line).iter().enumerate() {
                if columns
                    .get(column)
                    .is_some_and(|column| column.kind == ColumnKind::Number)
                {
                    let _ = number(cell, &mut numbers);
                }
            }
        }
        Layout {
            stated: self.stated(lines),
            split: self.split,
            columns,
            first: self.first,
            numbers,
        }
    }

    /// Returns the names of the columns and the row of units.
    fn header(&self, lines: &[String]) -> (Vec<String>, Vec<String>) {
        let owned = |cells: Vec<Cow<'_, str>>| {
            cells
                .into_iter()
                .map(Cow::into_owned)
                .collect::<Vec<String>>()
        };
        let is_wide = |cells: &Vec<String>| self.is_header_width(cells.len());
        let is_words = |cells: &Vec<String>| {
            cells
                .iter()
                .any(|cell| !cell.is_empty() && cell.parse::<f64>().is_err())
        };
        let above = lines[..self.first].iter().rev();
        let rows: Vec<Vec<String>> = above
            .filter(|line| is_row(line))
            .take(2)
            .map(|line| self.header_cells(line))
            .collect();
        let comments = lines[..self.first]
            .iter()
            .rev()
            .filter_map(|line| comment(line));
        let mut comments = comments.map(|text| {
            let cells = owned(trimmed(self.split.cells(text)));
            if cells.len() == self.width {
                cells
            } else {
                owned(Split::Blanks.cells(text))
            }
        });
        let units_of = |cells: &[String]| {
            cells
                .iter()
                .map(|cell| unit_text(cell).to_owned())
                .collect()
        };
        match rows.as_slice() {
            [below, names, ..]
                if is_wide_or_units(below, self.width)
                    && is_units(below)
                    && is_wide(names)
                    && is_words(names) =>
            {
                (names.clone(), units_of(below))
            }
            [names, ..] if is_wide(names) && is_words(names) => (names.clone(), Vec::new()),
            _ => match comments.find(|cells| cells.len() == self.width && is_words(cells)) {
                Some(below) if is_units(&below) => {
                    match comments.find(|cells| cells.len() == self.width) {
                        Some(names) => (names, units_of(&below)),
                        None => (below, Vec::new()),
                    }
                }
                Some(names) => (names, Vec::new()),
                None => (Vec::new(), Vec::new()),
            },
        }
    }

    /// Returns whether a line of so many cells may name the columns: it may name more, which are empty.
    fn is_header_width(&self, cells: usize) -> bool {
        match self.split {
            Split::At(_) => cells >= self.width,
            Split::Blanks => cells == self.width,
        }
    }

    /// Returns the cells of a line above the numbers, with an empty first one where R leaves out that of the rows' names.
    fn header_cells(&self, line: &str) -> Vec<String> {
        let cells = self.split.cells(line);
        let lacks_first = cells.len() + 1 == self.width && self.width > 2;
        let mut cells: Vec<String> = trimmed(cells).into_iter().map(Cow::into_owned).collect();
        if lacks_first && cells.len() + 1 == self.width {
            cells.insert(0, String::new());
        }
        cells
    }

    /// Returns the names and values above the table: `name: value`, `name = value`, or two cells.
    fn stated(&self, lines: &[String]) -> Vec<(String, String)> {
        let pair = |line: &String| {
            let text = comment(line).unwrap_or(line);
            let cells = trimmed(self.split.cells(text));
            if let [name, value] = cells.as_slice() {
                return Some((
                    name.trim_end_matches([':', '=']).trim().to_owned(),
                    value.to_string(),
                ));
            }
            let (name, value) = text.split_once(['=', ':'])?;
            Some((
                name.trim().trim_matches('"').to_owned(),
                value
                    .trim()
                    .trim_matches([',', ';', '\t', '"'])
                    .trim()
                    .to_owned(),
            ))
        };
        let above = lines[..self.first].iter().filter_map(pair);
        above
            .filter(|(name, value)| !name.is_empty() && !value.is_empty())
            .collect()
    }
}

fn is_wide_or_units(cells: &[String], width: usize) -> bool {
    cells.len() <= width
}

fn is_units(cells: &[String]) -> bool {
    cells.iter().any(|cell| !cell.is_empty()) && cells.iter().all(|cell| is_unit(cell))
}

/// Returns a name that no earlier column has: `time.1` for the second `time`.
fn unique(name: String, columns: &[LayoutColumn]) -> String {
    let is_taken = |name: &str| columns.iter().any(|column| column.name == name);
    if !is_taken(&name) {
        return name;
    }
    (1..)
        .map(|n| format!("{name}.{n}"))
        .find(|name| !is_taken(name))
        .unwrap_or(name)
}
