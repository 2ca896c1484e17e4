//! Tables as text: CSV, TSV and TXT of instruments, spreadsheets and statistics programs, read by stretches of lines.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::sync::Arc;

use text_lines::{Lines, TextForm};
use text_tables::layout::{
    ColumnKind, Layout, LayoutFault, TimeCells, TimeFault, is_row, is_time_name, number,
};

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::{SourceError, SourceFault};
use crate::format::{ArrayReader, Format, Place, Values};

/// Bytes and lines from which the layout is found.
const HEAD_BYTES: u64 = 1 << 18;
const HEAD_LINES: usize = 1000;

/// Rows between two offsets of the index.
const BLOCK_ROWS: u64 = 1024;

/// Rows at the end that may be words of the program that wrote the file.
const MOST_FOOTER_ROWS: u64 = 16;

/// Reader of a table as text.
pub(crate) struct TextReader {
    file: Arc<File>,
    form: TextForm,
    layout: Layout,
    index: Index,
    /// Readers of the times of each column.
    times: Vec<TimeCells>,
    arrays: Vec<ArrayInfo>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
}

/// Rows of a table, and where each thousandth of them begins.
#[derive(Debug, Clone, Default)]
struct Index {
    /// Offset and number of the line at the start of each block.
    blocks: Vec<(u64, u64)>,
    rows: u64,
    /// Offset at which the rows end.
    limit: u64,
    /// Whether all lines are UTF-8.
    is_utf8: bool,
}

impl TextReader {
    /// Opens a text file.
    pub(crate) fn open(file: File, head: &[u8]) -> Result<Box<dyn ArrayReader>, SourceError> {
        let form = TextForm::find(head);
        let file = Arc::new(file);
        let file_bytes = file.metadata()?.len();
        let (texts, offsets, is_utf8) = first_lines(&file, form)?;
        let layout = Layout::find(&texts).map_err(refusal)?;
        let start = offsets[layout.first];
        let number = layout.first as u64 + 1;
        let lines = Lines::new(Arc::clone(&file), form, start, number, file_bytes);
        let mut index = Index::scan(lines, file_bytes)?;
        index.is_utf8 &= is_utf8;
        let mut reader = Self {
            file,
            form,
            layout,
            index,
            times: Vec::new(),
            arrays: Vec::new(),
            attributes: BTreeMap::new(),
            notes: Vec::new(),
        };
        reader.cut_footer()?;
        reader.list()?;
        Ok(Box::new(reader))
    }

    /// Returns the lines from the start of a block on.
    fn lines(&self, block: usize) -> Lines {
        let (offset, number) = self.index.blocks[block];
        Lines::new(
            Arc::clone(&self.file),
            self.form,
            offset,
            number,
            self.index.limit,
        )
    }

    /// Calls `visitor` with the number and text of the rows `range`.
    fn visit_rows(
        &self,
        range: Range<u64>,
        mut visitor: impl FnMut(u64, &str) -> Result<(), SourceError>,
    ) -> Result<(), SourceError> {
        let block = (range.start / BLOCK_ROWS) as usize;
        if range.is_empty() || block >= self.index.blocks.len() {
            return Ok(());
        }
        let mut row = block as u64 * BLOCK_ROWS;
        let mut lines = self.lines(block);
        while row < range.end
            && let Some(line) = lines.next_line()?
        {
            if !is_row(line.text) {
                continue;
            }
            if row >= range.start {
                visitor(line.number, line.text)?;
            }
            row += 1;
        }
        Ok(())
    }

    /// Leaves out rows at the end that are no data: words, and a last line that is cut off.
    fn cut_footer(&mut self) -> Result<(), SourceError> {
        let first = self.index.rows.saturating_sub(MOST_FOOTER_ROWS + 1);
        let block = (first / BLOCK_ROWS) as usize;
        if self.index.blocks.is_empty() {
            return Ok(());
        }
        // Offset, number, number of cells, whether it has numbers, whether its line has an end.
        let mut tail: Vec<(u64, u64, usize, bool, bool)> = Vec::new();
        let mut lines = self.lines(block);
        while let Some(line) = lines.next_line()? {
            if !is_row(line.text) {
                continue;
            }
            let cells = self.layout.split.cells(line.text);
            let mut numbers = self.layout.numbers.clone();
            let columns = self.layout.columns.iter().zip(&cells);
            let mut filled = columns
                .filter(|(column, cell)| column.kind != ColumnKind::Text && !cell.is_empty());
            let has_numbers = filled.any(|(column, cell)| match column.kind {
                ColumnKind::Time => TimeCells::default().read(cell) != Err(TimeFault::NotTime),
                _ => number(cell, &mut numbers).is_ok(),
            });
            tail.push((
                line.offset,
                line.number,
                cells.len(),
                has_numbers,
                line.is_ended,
            ));
        }
        let mut n_words = 0;
        while tail.len() > 1 && n_words < MOST_FOOTER_ROWS && tail.last().is_some_and(|row| !row.3)
        {
            let (offset, ..) = tail.pop().unwrap_or_default();
            self.index.limit = offset;
            self.index.rows -= 1;
            n_words += 1;
        }
        if n_words > 0 {
            self.notes.push(format!(
                "the last {n_words} lines have no numbers and are left out"
            ));
        }
        if let [.., before, last] = tail.as_slice()
            && n_words == 0
            && !last.4
            && last.2 < before.2
        {
            self.index.limit = last.0;
            self.index.rows -= 1;
            self.notes.push(format!(
                "line {}: the last line is cut off, and is left out",
                last.1
            ));
        }
        let blocks = self.index.rows.div_ceil(BLOCK_ROWS) as usize;
        self.index.blocks.truncate(blocks);
        Ok(())
    }

    /// Lists the columns as arrays.
    fn list(&mut self) -> Result<(), SourceError> {
        let mut arrays = Vec::new();
        for (i, column) in self.layout.columns.iter().enumerate() {
            let (element, rows) = match column.kind {
                ColumnKind::Number => (Element::Float { bits: 64 }, self.filled_rows(i)?),
                ColumnKind::Time => (Element::Time, self.filled_rows(i)?),
                ColumnKind::Text => (Element::Text, self.index.rows),
            };
            self.times.push(match column.kind {
                ColumnKind::Time => self.dates(i)?,
                ColumnKind::Number | ColumnKind::Text => TimeCells::default(),
            });
            arrays.push(ArrayInfo {
                unit: column.unit.clone(),
                ..ArrayInfo::new(&column.name, element, vec![rows])
            });
        }
        self.arrays = arrays;
        for (name, value) in &self.layout.stated {
            let attribute = Attribute::of_cell(value.clone());
            self.attributes.insert(format!("@{name}"), attribute);
        }
        if self.layout.numbers.has_commas() {
            self.notes
                .push("its numbers have decimal commas".to_owned());
        }
        if !self.index.is_utf8 {
            self.notes
                .push("its text is not UTF-8, and is read as that of Western Europe".to_owned());
        }
        let times: Vec<String> = self
            .layout
            .columns
            .iter()
            .filter(|column| column.kind != ColumnKind::Text && is_time_name(&column.name))
            .map(|column| format!("`{}`", column.name))
            .collect();
        if times.len() > 1 {
            self.notes.push(format!(
                "{} columns seem to be times: {}; state for each stream which one is its `time`",
                times.len(),
                times.join(", ")
            ));
        }
        self.notes.insert(
            0,
            format!("its cells are separated by {}", self.layout.split.name()),
        );
        Ok(())
    }

    /// Returns the refusal of a cell.
    fn at(&self, line: u64, column: usize, fault: SourceFault) -> SourceError {
        let name = &self.layout.columns[column].name;
        SourceError::at(format!("line {line}, column `{name}`"), fault)
    }

    /// Returns the reader of a column's times, for whose dates the first day above 12 decides.
    fn dates(&self, column: usize) -> Result<TimeCells, SourceError> {
        let mut times = TimeCells::default();
        for start in (0..self.index.rows).step_by(BLOCK_ROWS as usize) {
            let (mut is_decided, mut is_ambiguous) = (false, false);
            self.visit_rows(start..start + BLOCK_ROWS, |_, text| {
                let cell = self.layout.split.cell(text, column).unwrap_or_default();
                is_decided = times.decide(&cell);
                is_ambiguous |= matches!(times.read(&cell), Err(TimeFault::Ambiguous { .. }));
                Ok(())
            })?;
            if is_decided || !is_ambiguous {
                break;
            }
        }
        Ok(times)
    }

    /// Returns the number of rows up to the last one in which a column has a cell.
    fn filled_rows(&self, column: usize) -> Result<u64, SourceError> {
        for block in (0..self.index.blocks.len() as u64).rev() {
            let start = block * BLOCK_ROWS;
            let end = (start + BLOCK_ROWS).min(self.index.rows);
            let mut filled = None;
            let mut row = start;
            self.visit_rows(start..end, |_, text| {
                let cell = self.layout.split.cell(text, column);
                row += 1;
                if cell.is_some_and(|cell| !cell.is_empty()) {
                    filled = Some(row);
                }
                Ok(())
            })?;
            if let Some(rows) = filled {
                return Ok(rows);
            }
        }
        Ok(0)
    }
}

/// Returns a cell as messages show it.
fn shown(cell: &str) -> String {
    cell.chars().take(40).collect()
}

/// Returns the first lines of a file, their offsets, and whether all are UTF-8.
fn first_lines(
    file: &Arc<File>,
    form: TextForm,
) -> Result<(Vec<String>, Vec<u64>, bool), SourceError> {
    let (mut texts, mut offsets, mut is_utf8) = (Vec::new(), Vec::new(), true);
    let mut lines = Lines::new(Arc::clone(file), form, 0, 1, HEAD_BYTES);
    while texts.len() < HEAD_LINES
        && let Some(line) = lines.next_line()?
    {
        texts.push(line.text.to_owned());
        offsets.push(line.offset);
        is_utf8 &= line.is_utf8;
    }
    Ok((texts, offsets, is_utf8))
}

/// Returns the refusal of lines without a layout.
fn refusal(fault: LayoutFault) -> SourceError {
    match fault {
        LayoutFault::NoTable => SourceFault::Foreign {
            kind: fault.to_string(),
            remedy: "name a file with columns of numbers",
        }
        .into(),
        LayoutFault::TwoCommas { line, .. } => SourceError::at(
            format!("line {line}"),
            SourceFault::Unread {
                content: fault.to_string(),
                remedy: "save it with semicolons or tabs between cells",
            },
        ),
    }
}

impl Index {
    /// Counts the rows, and notes where each block begins.
    fn scan(mut lines: Lines, file_bytes: u64) -> Result<Self, SourceError> {
        let mut index = Self {
            limit: file_bytes,
            is_utf8: true,
            ..Self::default()
        };
        while let Some(line) = lines.next_line()? {
            index.is_utf8 &= line.is_utf8;
            if !is_row(line.text) {
                continue;
            }
            if index.rows.is_multiple_of(BLOCK_ROWS) {
                index.blocks.push((line.offset, line.number));
            }
            index.rows += 1;
        }
        Ok(index)
    }
}

impl ArrayReader for TextReader {
    fn format(&self) -> Format {
        Format::Text
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn stated_rate_hz(&self) -> Option<f64> {
        // LabVIEW states the interval of its samples.
        match self.attributes.get("@Delta_X") {
            Some(Attribute::Number(interval_s)) if *interval_s > 0.0 => Some(1.0 / interval_s),
            _ => None,
        }
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn first_text(&self, index: usize) -> Result<Option<SourceError>, SourceError> {
        let (mut first, mut has_numbers) = (None, false);
        let mut numbers = self.layout.numbers.clone();
        let rows = self.index.rows.min(HEAD_LINES as u64);
        self.visit_rows(0..rows, |line, text| {
            let cell = self.layout.split.cell(text, index).unwrap_or_default();
            match number(&cell, &mut numbers) {
                Ok(_) => has_numbers |= !cell.is_empty(),
                Err(reason) if first.is_none() => {
                    has_numbers |= cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
                    let cell = shown(&cell);
                    first = Some(self.at(line, index, SourceFault::Cell { cell, reason }));
                }
                Err(_) => {}
            }
            Ok(())
        })?;
        Ok(first.filter(|_| has_numbers))
    }

    fn text(&mut self, index: usize) -> Result<Option<String>, SourceError> {
        let mut text = None;
        if self.index.rows == 1 {
            self.visit_rows(0..1, |_, row| {
                text = self
                    .layout
                    .split
                    .cell(row, index)
                    .map(|cell| cell.into_owned());
                Ok(())
            })?;
        }
        Ok(text)
    }

    fn read(
        &mut self,
        index: usize,
        _place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let Some(column) = self.layout.columns.get(index) else {
            return Ok(());
        };
        let mut numbers = self.layout.numbers.clone();
        self.visit_rows(range, |line, text| {
            let cell = self.layout.split.cell(text, index).unwrap_or_default();
            let fault = |reason: String| SourceFault::Cell {
                cell: shown(&cell),
                reason,
            };
            let value = match column.kind {
                ColumnKind::Time => self.times[index].read(&cell).map_err(|time| match time {
                    TimeFault::NotTime => fault("is not a time".to_owned()),
                    TimeFault::Ambiguous { numbers } => SourceFault::TwoDates {
                        cell: shown(&cell),
                        numbers,
                    },
                }),
                _ => number(&cell, &mut numbers).map_err(fault),
            };
            values.push(value.map_err(|fault| self.at(line, index, fault))?);
            Ok(())
        })
    }
}
