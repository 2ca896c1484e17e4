//! Reads the rows of `force.csv` and `position.csv` as a stream.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use bounded_files::{BoundedLines, as_text};
use text_tables::{Header, Numbers, Separator, TableFault, cells, stated_separator, units_row};

use crate::csv_rows::CsvRow;
use crate::read_error::{
    MAX_ROW_BYTES, MAX_ROWS_PER_S, MEAN_ROW_BYTES, OUTSIDE_S, ReadError, Warning,
};
use crate::row_order::{ParsedRow, RowOrder, Tally};
use crate::table_source::{TableSource, table_path};

/// Bytes per read.
const BUFFER_BYTES: usize = 1 << 16;
/// Number of lines below the header that may show that no line can be read.
const PROBED_LINES: u64 = 3;

/// Rows of a CSV file in file order, with increasing times.
///
/// Unreadable rows and rows with a time that does not increase, jumps ahead of the following rows or lies outside the
/// recording are omitted and counted; after the last row, [`warnings`](Self::warnings) reports them. Memory use does not
/// depend on the length of the file.
#[derive(Debug)]
pub struct RowReader<R> {
    file: &'static str,
    path: PathBuf,
    lines: BoundedLines<BufReader<TableSource>>,
    header: Header,
    /// Place of each column in a line.
    columns: Vec<usize>,
    numbers: Numbers,
    /// Number of lines below the header, without blank ones.
    below_header: u64,
    /// Length of the audio, s.
    duration_s: f64,
    limit_rows: u64,
    /// Number of the last line read, from 1.
    line: u64,
    unreadable_rows: Tally,
    first_unreadable: String,
    /// Rows with NUL characters.
    zeroed_rows: Tally,
    order: RowOrder<R>,
}

impl<R: CsvRow> RowReader<R> {
    /// Opens the rows of a recording of `duration_s`.
    pub(crate) fn open(
        folder: &Path,
        file: &'static str,
        duration_s: f64,
    ) -> Result<Self, ReadError> {
        let path = table_path(folder, file);
        let io_error = |reason| ReadError::Io {
            path: path.clone(),
            reason,
        };
        let source = bounded_files::open(&path).map_err(io_error)?;
        let source = BufReader::with_capacity(BUFFER_BYTES, TableSource::new(&path, source));
        let mut lines = BoundedLines::new(source, MAX_ROW_BYTES);
        let limit_rows = ((duration_s + OUTSIDE_S) * MAX_ROWS_PER_S as f64) as u64;
        let table_error = |fault| ReadError::Table {
            path: path.clone(),
            fault,
        };
        let (mut line, mut stated, mut header) = (0, None, String::new());
        while header.is_empty() {
            let limit_bytes = limit_rows.saturating_mul(MEAN_ROW_BYTES);
            let bytes_left = limit_bytes.saturating_sub(lines.read_bytes());
            let Some(next) = lines.next_line(bytes_left).map_err(io_error)? else {
                break;
            };
            line += 1;
            let text = as_text(next.bytes).map_err(|refusal| io_error(refusal.into()))?;
            match stated_separator(text) {
                Some(separator) => stated = Some(separator),
                None => header = text.trim_matches(['\u{feff}', ' ']).to_owned(),
            }
        }
        if header.is_empty() {
            let columns = R::COLUMNS.names().map(str::to_owned).collect();
            return Err(table_error(TableFault::Empty { columns }));
        }
        let header = Header::read(&header, stated, &R::COLUMNS).map_err(table_error)?;
        let columns = header.places().filter_map(|(_, place)| place).collect();
        Ok(Self {
            file,
            lines,
            numbers: Numbers::new(header.separator),
            header,
            columns,
            below_header: 0,
            duration_s,
            limit_rows,
            line,
            unreadable_rows: Tally::default(),
            first_unreadable: String::new(),
            zeroed_rows: Tally::default(),
            order: RowOrder::new(file, duration_s),
            path,
        })
    }

    /// Returns the defects of the rows so far; complete once the iterator has ended.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let file = self.file;
        let mut warnings = Vec::new();
        let Tally { rows, first_line } = self.unreadable_rows;
        if rows > 0 {
            warnings.push(Warning::UnreadableRows {
                file,
                rows,
                first_line,
                first: self.first_unreadable.clone(),
            });
        }
        let Tally { rows, first_line } = self.zeroed_rows;
        if rows > 0 {
            warnings.push(Warning::ZeroedRows { file, first_line });
        }
        warnings.extend(self.order.warnings());
        warnings
    }

    /// Reads the next line with a valid row; `None` at the end of the file.
    fn read_row(&mut self) -> Result<Option<ParsedRow<R>>, ReadError> {
        loop {
            if self.line > self.limit_rows {
                return Err(ReadError::TooManyRows {
                    path: self.path.clone(),
                    limit_rows: self.limit_rows,
                    duration_s: self.duration_s,
                });
            }
            let limit_bytes = self.limit_rows.saturating_mul(MEAN_ROW_BYTES);
            let bytes_left = limit_bytes.saturating_sub(self.lines.read_bytes());
            let line = self
                .lines
                .next_line(bytes_left)
                .map_err(|reason| ReadError::Io {
                    path: self.path.clone(),
                    reason,
                })?;
            let Some(line) = line else {
                if bytes_left > 0 {
                    return Ok(None);
                }
                return Err(ReadError::RowsTooLong {
                    path: self.path.clone(),
                    limit_bytes,
                    duration_s: self.duration_s,
                });
            };
            self.line += 1;
            let text = line.bytes.trim_ascii();
            let separator = self.header.separator.byte();
            let is_blank = text
                .iter()
                .all(|byte| *byte == separator || byte.is_ascii_whitespace());
            if is_blank && !line.cut {
                continue;
            }
            let is_complete = line.ended && !line.cut;
            self.below_header += 1;
            let row = match fast_row(text, &self.header, &self.columns, &mut self.numbers) {
                None => careful_row(text, &self.header, &self.columns, &mut self.numbers),
                row => row,
            };
            match row.filter(|_| is_complete) {
                Some((row, is_finite)) => {
                    return Ok(Some(ParsedRow {
                        row,
                        line: self.line,
                        is_finite,
                    }));
                }
                None if text.contains(&0) => self.zeroed_rows.count(self.line),
                None => {
                    let is_probed = self.below_header <= PROBED_LINES;
                    let is_first = self.below_header == 1;
                    if is_probed
                        && is_units(text, self.line, &self.header, is_first).map_err(|fault| {
                            ReadError::Table {
                                path: self.path.clone(),
                                fault,
                            }
                        })?
                    {
                        continue;
                    }
                    if self.unreadable_rows.rows == 0 {
                        self.first_unreadable = beginning(text);
                    }
                    self.unreadable_rows.count(self.line);
                }
            }
        }
    }
}

impl<R: CsvRow> Iterator for RowReader<R> {
    type Item = Result<R, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(row) = self.order.confirmed_row() {
                return Some(Ok(row));
            }
            if self.order.is_at_end() {
                return None;
            }
            match self.read_row() {
                Ok(Some(row)) => self.order.take(row),
                Ok(None) => self.order.end(),
                Err(error) => {
                    self.order.abandon();
                    return Some(Err(error));
                }
            }
        }
    }
}

/// Returns the row in a line of plain numbers with decimal points, and whether all its values are finite; `None` if it is
/// not such a line, which [`careful_row`] reads.
fn fast_row<R: CsvRow>(
    line: &[u8],
    header: &Header,
    columns: &[usize],
    numbers: &mut Numbers,
) -> Option<(R, bool)> {
    if numbers.has_commas() || line.contains(&b'"') {
        return None;
    }
    let separator = header.separator.byte();
    let fields = || {
        line.split(|byte| *byte == separator)
            .map(<[u8]>::trim_ascii)
    };
    if !fields().skip(header.width).all(<[u8]>::is_empty) {
        return None;
    }
    let row = row(columns, |values| {
        let mut n_missing = columns.len();
        for (index, field) in fields().enumerate() {
            for (value, _) in values
                .iter_mut()
                .zip(columns)
                .filter(|(_, column)| **column == index)
            {
                *value = std::str::from_utf8(field).ok()?.parse().ok()?;
                n_missing -= 1;
            }
        }
        (n_missing == 0).then_some(())
    });
    if row.is_some() && numbers.is_undecided() && line.contains(&b'.') {
        numbers.assume_points();
    }
    row
}

/// Returns the row in a line, with quotation marks, decimal commas and missing values, and whether all its values are
/// finite; `None` if it is not a row with a finite time.
fn careful_row<R: CsvRow>(
    line: &[u8],
    header: &Header,
    columns: &[usize],
    numbers: &mut Numbers,
) -> Option<(R, bool)> {
    let cells = cells(std::str::from_utf8(line).ok()?, header.separator);
    if !cells.iter().skip(header.width).all(|cell| cell.is_empty()) {
        return None;
    }
    row(columns, |values| {
        for (value, column) in values.iter_mut().zip(columns) {
            *value = numbers.read(cells.get(*column)?).ok()?;
        }
        Some(())
    })
}

/// Returns the row of the values that `fill` finds, and whether all are finite; `None` without a finite time.
fn row<R: CsvRow>(
    columns: &[usize],
    fill: impl FnOnce(&mut [f64]) -> Option<()>,
) -> Option<(R, bool)> {
    let mut values = [0.0; 4];
    let values = values.get_mut(..columns.len())?;
    fill(values)?;
    let row = R::from_fields(values)?;
    let is_finite = values.iter().all(|value| value.is_finite());
    row.time_s().is_finite().then_some((row, is_finite))
}

/// Returns whether a line that is no row is the row of units, which may be the first one below the header.
///
/// # Errors
/// The units are others than those in the columns' names, or commas are separators and decimal signs in one.
fn is_units(line: &[u8], number: u64, header: &Header, is_first: bool) -> Result<bool, TableFault> {
    let text = String::from_utf8_lossy(line);
    let cells = cells(&text, header.separator);
    let line = usize::try_from(number).unwrap_or(usize::MAX);
    if is_first && units_row(&cells, line, header)? {
        return Ok(true);
    }
    let is_part = |cell: &str| !cell.contains('.') && cell.parse::<f64>().is_ok();
    let is_cut_up = cells.len() > header.width && cells.iter().all(|cell| is_part(cell));
    if header.separator == Separator::Comma && is_cut_up {
        return Err(TableFault::DecimalCommas {
            line,
            cells: cells.len(),
            columns: header.width,
        });
    }
    Ok(false)
}

/// Returns the first 80 characters of a line, for messages.
fn beginning(line: &[u8]) -> String {
    String::from_utf8_lossy(line)
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(80)
        .collect()
}
