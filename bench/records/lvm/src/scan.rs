//! Places of the samples of all segments.

use std::fs::File;
use std::sync::Arc;

use text_lines::{Lines, TextForm};
use text_tables::Numbers;
use text_tables::Separator;
use text_tables::layout::{Split, number};

use crate::error::LvmError;
use crate::header::{END, FileHeader, SPECIAL, SegmentColumn, X_NAME, segment_columns};

/// Rows between two offsets of the index.
pub(crate) const BLOCK_ROWS: u64 = 1024;

/// Rows that follow one another.
#[derive(Debug, Clone, Default)]
pub(crate) struct Piece {
    pub(crate) rows: u64,
    /// Offset and number of the line at the start of each block.
    pub(crate) blocks: Vec<(u64, u64)>,
    /// Rows up to the last one in which each cell is filled.
    filled: Vec<u64>,
}

impl Piece {
    /// Returns the number of cells of its rows, without the comment.
    pub(crate) fn width(&self) -> usize {
        self.filled.len()
    }
}

/// Samples of a column in one piece.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) piece: usize,
    /// Index of the first sample among those of the column.
    pub(crate) first: u64,
    pub(crate) count: u64,
    /// The column as the segment's header describes it.
    pub(crate) column: Arc<SegmentColumn>,
    /// Whether the segment has no header of its own.
    pub(crate) is_continued: bool,
}

/// Headers and places of the samples of a file.
#[derive(Debug, Clone)]
pub(crate) struct Scan {
    pub(crate) header: FileHeader,
    pub(crate) pieces: Vec<Piece>,
    /// Runs of each column, in the order of the columns.
    pub(crate) columns: Vec<Vec<Run>>,
    /// Tags and values of the first segment's header.
    pub(crate) first_header: Vec<String>,
    pub(crate) numbers: Numbers,
    pub(crate) notes: Vec<String>,
}

/// Section to which the next line belongs.
enum State {
    FileHeader,
    SegmentHeader,
    Names,
    Rows,
    Special,
}

/// Returns whether a row has a value in any of the first `width` cells.
pub(crate) fn has_values(split: Split, text: &str, width: usize) -> bool {
    let cells = split.cells(text);
    cells.iter().take(width).any(|cell| !cell.is_empty())
}

impl Scan {
    /// Reads all lines of a file.
    ///
    /// # Errors
    /// [`LvmError`] for a file without a segment, and for a form that is not read.
    pub(crate) fn read(file: &Arc<File>, form: TextForm, bytes: u64) -> Result<Self, LvmError> {
        let mut scanner = Scanner::default();
        let mut state = State::FileHeader;
        let mut lines = Lines::new(Arc::clone(file), form, 0, 1, bytes);
        let mut line_number = 0;
        while let Some(line) = lines.next_line()? {
            line_number = line.number;
            scanner.is_utf8 &= line.is_utf8;
            state =
                scanner.next_state(state, line.text, (line.offset, line.number, line.is_ended))?;
        }
        scanner.finish(&state, line_number)
    }
}

/// Headers and pieces found so far.
struct Scanner {
    header: Option<FileHeader>,
    lines: Vec<String>,
    first_header: Vec<String>,
    /// Columns of each header, and the first piece below it.
    segments: Vec<(Vec<Arc<SegmentColumn>>, usize)>,
    pieces: Vec<Piece>,
    numbers: Numbers,
    /// Whether the last row ended before its line did, and the number of its line.
    unended: Option<u64>,
    widths: [usize; 2],
    is_utf8: bool,
}

impl Default for Scanner {
    fn default() -> Self {
        Self {
            header: None,
            lines: Vec::new(),
            first_header: Vec::new(),
            segments: Vec::new(),
            pieces: Vec::new(),
            numbers: Numbers::new(Separator::Tab),
            unended: None,
            widths: [0; 2],
            is_utf8: true,
        }
    }
}

impl Scanner {
    fn next_state(
        &mut self,
        state: State,
        text: &str,
        place: (u64, u64, bool),
    ) -> Result<State, LvmError> {
        let tag = text.split(['\t', ',', ';']).next().unwrap_or("").trim();
        Ok(match state {
            State::FileHeader if tag == END => {
                let header = FileHeader::read(&std::mem::take(&mut self.lines))?;
                self.numbers = header.split.numbers();
                match header.has_commas {
                    Some(true) => self.numbers.assume_commas(),
                    Some(false) => self.numbers.assume_points(),
                    None => {}
                }
                self.header = Some(header);
                State::SegmentHeader
            }
            State::Special if tag == SPECIAL[1] => {
                self.pieces.push(Piece::default());
                State::Rows
            }
            State::Special => State::Special,
            State::SegmentHeader if tag == END => State::Names,
            State::SegmentHeader if tag != X_NAME => {
                // A special block may stand before a header, too.
                if !SPECIAL.contains(&tag) && !text.trim().is_empty() {
                    self.lines.push(text.to_owned());
                }
                State::SegmentHeader
            }
            State::FileHeader => {
                self.lines.push(text.to_owned());
                State::FileHeader
            }
            State::SegmentHeader | State::Names => {
                self.begin_segment(text);
                State::Rows
            }
            State::Rows if tag == SPECIAL[0] => State::Special,
            State::Rows => return self.row(text, place),
        })
    }

    fn begin_segment(&mut self, names: &str) {
        let lines = std::mem::take(&mut self.lines);
        let Some(header) = &self.header else {
            return;
        };
        let columns = segment_columns(header, &lines, names);
        let columns = columns.into_iter().map(Arc::new).collect();
        if self.segments.is_empty() {
            self.first_header = lines;
        }
        self.segments.push((columns, self.pieces.len()));
        self.pieces.push(Piece::default());
        self.widths = [0; 2];
    }

    /// Adds a row, or begins the header of the next segment.
    fn row(
        &mut self,
        text: &str,
        (offset, number_of_line, is_ended): (u64, u64, bool),
    ) -> Result<State, LvmError> {
        let Some(split) = self.header.as_ref().map(|header| header.split) else {
            return Ok(State::Rows);
        };
        let cells = split.cells(text);
        let columns = self.segments.last().map(|(columns, _)| columns.as_slice());
        let last_cell = columns
            .and_then(|columns| columns.last())
            .map_or(0, |column| column.cell);
        let first = cells.first().map_or("", |cell| cell.as_ref());
        if !first.is_empty() && number(first, &mut self.numbers.clone()).is_err() {
            self.lines.push(text.to_owned());
            return Ok(State::SegmentHeader);
        }
        let width = last_cell + 1;
        let Some(piece) = self.pieces.last_mut() else {
            return Ok(State::Rows);
        };
        if cells.iter().take(width).all(|cell| cell.is_empty()) {
            return Ok(State::Rows);
        }
        if piece.rows.is_multiple_of(BLOCK_ROWS) {
            piece.blocks.push((offset, number_of_line));
        }
        piece.rows += 1;
        piece.filled.resize(width, 0);
        for (filled, cell) in piece.filled.iter_mut().zip(&cells) {
            if !cell.is_empty() {
                *filled = piece.rows;
                // The first numbers show the decimal sign where no tag states it.
                if self.numbers.is_undecided() {
                    let _ = number(cell, &mut self.numbers);
                }
            }
        }
        self.widths = [self.widths[1], cells.len().min(width)];
        self.unended = (!is_ended).then_some(number_of_line);
        Ok(State::Rows)
    }

    fn finish(mut self, state: &State, last_line: u64) -> Result<Scan, LvmError> {
        let damaged = |defect: &str| LvmError::Damaged {
            line: last_line,
            defect: defect.to_owned(),
        };
        let header = self
            .header
            .take()
            .ok_or_else(|| damaged("the file's header does not end"))?;
        let mut notes = vec![format!(
            "its cells are separated by {}",
            header.split.name()
        )];
        if self.numbers.has_commas() {
            notes.push("its numbers have decimal commas".to_owned());
        }
        if !self.is_utf8 {
            notes.push("its text is not UTF-8, and is read as that of Western Europe".to_owned());
        }
        if self.segments.is_empty() {
            return Err(damaged("the header of the first segment does not end"));
        }
        if matches!(state, State::SegmentHeader | State::Names) && !self.lines.is_empty() {
            notes.push(
                "the file ends within the header of a segment: those before are read".to_owned(),
            );
        }
        self.cut_last_row(&mut notes);
        let columns = self.runs(&mut notes);
        Ok(Scan {
            header,
            pieces: self.pieces,
            columns,
            first_header: self.first_header,
            numbers: self.numbers,
            notes,
        })
    }

    /// Leaves out a last row without a line end that has fewer cells than the one before.
    fn cut_last_row(&mut self, notes: &mut Vec<String>) {
        let (Some(line), Some(piece)) = (self.unended, self.pieces.last_mut()) else {
            return;
        };
        if piece.rows > 1 && self.widths[1] < self.widths[0] {
            piece.rows -= 1;
            for filled in &mut piece.filled {
                *filled = (*filled).min(piece.rows);
            }
            notes.push(format!(
                "line {line}: the last line is cut off, and is left out"
            ));
        }
    }

    /// Returns the runs of each column: the samples of columns of one name follow one another.
    fn runs(&self, notes: &mut Vec<String>) -> Vec<Vec<Run>> {
        let (mut all, mut short): (Vec<Vec<Run>>, Option<u64>) = (Vec::new(), None);
        for (i, (columns, first)) in self.segments.iter().enumerate() {
            let end = self
                .segments
                .get(i + 1)
                .map_or(self.pieces.len(), |next| next.1);
            for column in columns {
                let place = all
                    .iter()
                    .position(|runs| runs[0].column.name == column.name);
                let place = place.unwrap_or(all.len());
                if place == all.len() {
                    all.push(Vec::new());
                }
                let runs = &mut all[place];
                let mut found = 0;
                for piece in *first..end {
                    let count = self.pieces[piece]
                        .filled
                        .get(column.cell)
                        .copied()
                        .unwrap_or(0);
                    found += count;
                    runs.push(Run {
                        piece,
                        first: runs.last().map_or(0, |run: &Run| run.first + run.count),
                        count,
                        column: Arc::clone(column),
                        is_continued: piece > *first,
                    });
                }
                let stated = column.samples.unwrap_or(found);
                let is_last = i + 1 == self.segments.len();
                if found < stated && is_last && short.is_none() {
                    short = Some(stated);
                    notes.push(format!(
                        "the header states {stated} samples of `{}`, and {found} are there: it is read as far as it goes",
                        column.name
                    ));
                }
            }
        }
        all
    }
}
