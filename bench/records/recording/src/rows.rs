//! Reads the rows of `force.csv` and `position.csv` as a stream.

use std::collections::VecDeque;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use bounded_files::{BoundedLines, as_text};
use text_tables::{Header, Numbers, Separator, TableFault, cells, stated_separator, units_row};

use crate::csv_rows::CsvRow;
use crate::read_error::{
    EARLY_END_S, MAX_ROW_BYTES, MAX_ROWS_PER_S, MEAN_ROW_BYTES, OUTSIDE_S, ReadError, Warning,
};
use crate::table_source::{TableSource, table_path};

/// Bytes per read.
const BUFFER_BYTES: usize = 1 << 16;
/// Step in time between rows that later rows must confirm, s.
const LEAP_S: f64 = 0.1;
/// Number of lines below the header that may show that no line can be read.
const PROBED_LINES: u64 = 3;
/// Number of rows that confirm a jump in time.
const CONFIRMING_ROWS: usize = 64;

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
    is_at_end: bool,
    last_time_s: f64,
    /// Rows after a jump in time, until enough rows confirm it.
    pending_rows: VecDeque<ParsedRow<R>>,
    is_confirmed: bool,
    rows: u64,
    unreadable_rows: Tally,
    first_unreadable: String,
    /// Rows with NUL characters.
    zeroed_rows: Tally,
    disordered_rows: Tally,
    leap_rows: Tally,
    outside_rows: Tally,
    outside_from_s: f64,
    outside_to_s: f64,
    not_finite_rows: Tally,
}

#[derive(Debug, Clone, Copy)]
struct ParsedRow<R> {
    row: R,
    line: u64,
    is_finite: bool,
}

#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    rows: u64,
    first_line: u64,
}

impl Tally {
    fn count(&mut self, line: u64) {
        if self.rows == 0 {
            self.first_line = line;
        }
        self.rows += 1;
    }
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
            is_at_end: false,
            last_time_s: f64::NEG_INFINITY,
            pending_rows: VecDeque::new(),
            is_confirmed: false,
            rows: 0,
            unreadable_rows: Tally::default(),
            first_unreadable: String::new(),
            zeroed_rows: Tally::default(),
            disordered_rows: Tally::default(),
            leap_rows: Tally::default(),
            outside_rows: Tally::default(),
            outside_from_s: f64::INFINITY,
            outside_to_s: f64::NEG_INFINITY,
            not_finite_rows: Tally::default(),
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
        let Tally { rows, first_line } = self.disordered_rows;
        if rows > 0 {
            warnings.push(Warning::TimeDisorder {
                file,
                rows,
                first_line,
            });
        }
        let Tally { rows, first_line } = self.leap_rows;
        if rows > 0 {
            warnings.push(Warning::TimeLeap {
                file,
                rows,
                first_line,
            });
        }
        let Tally { rows, first_line } = self.outside_rows;
        if rows > 0 {
            warnings.push(Warning::OutsideRecording {
                file,
                rows,
                first_line,
                from_s: self.outside_from_s,
                to_s: self.outside_to_s,
                duration_s: self.duration_s,
            });
        }
        let Tally { rows, first_line } = self.not_finite_rows;
        if rows > 0 {
            warnings.push(Warning::NotFinite {
                file,
                rows,
                first_line,
            });
        }
        if self.rows == 0 && self.outside_rows.rows == 0 {
            warnings.push(Warning::NoRows { file });
        }
        let (last_s, duration_s) = (self.last_time_s, self.duration_s);
        let is_early = duration_s.is_finite() && duration_s - last_s > EARLY_END_S;
        if self.is_at_end && last_s >= 0.0 && is_early {
            warnings.push(Warning::EndsEarly {
                file,
                last_s,
                duration_s,
            });
        }
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

    /// Accepts a row, or counts the reason to omit it.
    fn accept(&mut self, next: ParsedRow<R>) {
        let time_s = next.row.time_s();
        if !(-OUTSIDE_S..=self.duration_s + OUTSIDE_S).contains(&time_s) {
            self.outside_rows.count(next.line);
            self.outside_from_s = self.outside_from_s.min(time_s);
            self.outside_to_s = self.outside_to_s.max(time_s);
            return;
        }
        if time_s <= self.last_time_s {
            self.disordered_rows.count(next.line);
            return;
        }
        let ends = self.pending_rows.front().zip(self.pending_rows.back());
        match ends.map(|(first, last)| (first.row.time_s(), last.row.time_s())) {
            Some((first_s, _)) if time_s < first_s => {
                // The time returns to before the jump: the held rows are wrong, not the following ones.
                for row in self.pending_rows.drain(..) {
                    self.leap_rows.count(row.line);
                }
            }
            Some((_, last_s)) if time_s <= last_s => {
                self.disordered_rows.count(next.line);
                return;
            }
            _ => {}
        }
        let is_leap = time_s - self.last_time_s.max(0.0) > LEAP_S;
        self.pending_rows.push_back(next);
        self.is_confirmed = !is_leap || self.pending_rows.len() > CONFIRMING_ROWS;
    }

    /// Returns the next row with a confirmed time.
    fn confirmed_row(&mut self) -> Option<R> {
        if !self.is_confirmed && !self.is_at_end {
            return None;
        }
        let Some(ParsedRow {
            row,
            line,
            is_finite,
        }) = self.pending_rows.pop_front()
        else {
            self.is_confirmed = false;
            return None;
        };
        if !is_finite {
            self.not_finite_rows.count(line);
        }
        self.last_time_s = row.time_s();
        self.rows += 1;
        Some(row)
    }
}

impl<R: CsvRow> Iterator for RowReader<R> {
    type Item = Result<R, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(row) = self.confirmed_row() {
                return Some(Ok(row));
            }
            if self.is_at_end {
                return None;
            }
            match self.read_row() {
                Ok(Some(row)) => self.accept(row),
                Ok(None) => self.is_at_end = true,
                Err(error) => {
                    self.is_at_end = true;
                    self.pending_rows.clear();
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
