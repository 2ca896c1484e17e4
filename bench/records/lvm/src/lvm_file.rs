//! Channels of a file and their samples.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::sync::Arc;

use text_lines::{Lines, TextForm};
use text_tables::layout::number;

use crate::error::LvmError;
use crate::header::{X_NAME, XColumns};
use crate::scan::{BLOCK_ROWS, Run, Scan, has_values};
use crate::timing::{Timing, rate_hz, start_s};

/// Greatest relative difference of `Delta_X` and of the interval of the column of x.
const SAME_INTERVAL: f64 = 1e-3;

/// Measurement file of LabVIEW.
pub struct LvmFile {
    file: Arc<File>,
    form: TextForm,
    bytes: u64,
    scan: Scan,
    columns: Vec<LvmColumn>,
    notes: Vec<String>,
}

/// Column of a file: a channel, or x.
#[derive(Debug, Clone)]
pub struct LvmColumn {
    /// Name.
    pub name: String,
    /// Number of samples in all segments.
    pub length: u64,
    /// Unit.
    pub unit: Option<String>,
    /// Rate of the samples, Hz.
    pub rate_hz: Option<f64>,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Whether it is one of x.
    pub is_x: bool,
    /// Index of its runs in the scan.
    runs: usize,
    /// Whether its values follow from the headers.
    is_computed: bool,
}

impl LvmFile {
    /// Opens a file, reads its headers and counts its rows.
    ///
    /// # Errors
    /// [`LvmError`] for a file without a segment, and for a form that is not read.
    pub fn open(file: File, form: TextForm) -> Result<Self, LvmError> {
        let bytes = file
            .metadata()
            .map_err(text_lines::TextLineError::from)?
            .len();
        let file = Arc::new(file);
        let scan = Scan::read(&file, form, bytes)?;
        let mut opened = Self {
            notes: scan.notes.clone(),
            file,
            form,
            bytes,
            scan,
            columns: Vec::new(),
        };
        opened.list()?;
        Ok(opened)
    }

    /// Returns the columns, in the order of the file.
    #[must_use]
    pub fn columns(&self) -> &[LvmColumn] {
        &self.columns
    }

    /// Returns tags with their values: those of the file's header, and the first values of the first segment's.
    #[must_use]
    pub fn tags(&self) -> BTreeMap<String, String> {
        let mut tags = self.scan.header.tags.clone();
        for line in &self.scan.first_header {
            if let [tag, value, ..] = self.scan.header.split.cells(line).as_slice()
                && !value.is_empty()
            {
                tags.insert(tag.to_string(), value.to_string());
            }
        }
        tags
    }

    /// Returns sentences for a user about the content.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Appends the values `range` of a column.
    ///
    /// # Errors
    /// A cell is not a number, or the file cannot be read there.
    pub fn read(
        &self,
        column: usize,
        range: Range<u64>,
        values: &mut Vec<f64>,
    ) -> Result<(), LvmError> {
        let Some(column) = self.columns.get(column) else {
            return Ok(());
        };
        let runs = &self.scan.columns[column.runs];
        for run in runs {
            let start = range.start.max(run.first);
            let end = range.end.min(run.first + run.count);
            if start >= end {
                continue;
            }
            let rows = start - run.first..end - run.first;
            match (column.is_computed, run.column.interval_s) {
                (true, Some(interval_s)) => {
                    let start_s = column.start_s + start_s(runs, run).unwrap_or(0.0);
                    values.extend(rows.map(|row| start_s + row as f64 * interval_s));
                }
                _ => self.read_run(&column.name, run, rows, values)?,
            }
        }
        Ok(())
    }

    fn read_run(
        &self,
        name: &str,
        run: &Run,
        rows: Range<u64>,
        values: &mut Vec<f64>,
    ) -> Result<(), LvmError> {
        let piece = &self.scan.pieces[run.piece];
        let block = rows.start / BLOCK_ROWS;
        let Some(&(offset, line)) = piece.blocks.get(block as usize) else {
            return Ok(());
        };
        let split = self.scan.header.split;
        let mut numbers = self.scan.numbers.clone();
        let mut lines = Lines::new(Arc::clone(&self.file), self.form, offset, line, self.bytes);
        let mut row = block * BLOCK_ROWS;
        while row < rows.end
            && let Some(line) = lines.next_line()?
        {
            if !has_values(split, line.text, piece.width()) {
                continue;
            }
            if row >= rows.start {
                let cell = split.cell(line.text, run.column.cell).unwrap_or_default();
                let value = number(&cell, &mut numbers).map_err(|reason| LvmError::Cell {
                    line: line.number,
                    column: name.to_owned(),
                    cell: cell.chars().take(40).collect(),
                    reason,
                })?;
                values.push(value);
            }
            row += 1;
        }
        Ok(())
    }

    /// Lists the columns with samples.
    fn list(&mut self) -> Result<(), LvmError> {
        let mut empty = Vec::new();
        let mut notes: Vec<String> = Vec::new();
        let mut computed: Option<LvmColumn> = None;
        for (i, runs) in self.scan.columns.iter().enumerate() {
            let length = runs.iter().map(|run| run.count).sum();
            let Some(first) = runs.iter().find(|run| run.count > 0) else {
                empty.push(format!("`{}`", runs[0].column.name));
                continue;
            };
            let mut column = LvmColumn {
                name: first.column.name.clone(),
                length,
                unit: first.column.unit.clone(),
                rate_hz: None,
                start_s: first.column.x0_s,
                is_x: first.column.is_x,
                runs: i,
                is_computed: false,
            };
            let timing = match column.is_x {
                true => Timing::Unstated,
                false => self.against_x(Timing::find(runs), first)?,
            };
            match timing {
                Timing::Even {
                    interval_s,
                    notes: found,
                } => {
                    column.rate_hz = Some(rate_hz(interval_s));
                    notes.extend(found);
                }
                Timing::Uneven { reason } => {
                    let is_missing = self.scan.header.x_columns == XColumns::No;
                    let has_starts = runs.iter().all(|run| start_s(runs, run).is_some());
                    let is_longer = computed.as_ref().is_none_or(|x| x.length < length);
                    if is_missing && has_starts && is_longer && first.column.samples != Some(1) {
                        computed = Some(LvmColumn {
                            name: X_NAME.to_owned(),
                            unit: Some("s".to_owned()),
                            is_x: true,
                            is_computed: true,
                            ..column.clone()
                        });
                    }
                    notes.push(format!("{reason}, so that no one rate is stated"));
                }
                Timing::Unstated => {}
            }
            self.columns.push(column);
        }
        if let Some(x) = computed {
            self.columns.insert(0, x);
            notes.push(format!(
                "`{X_NAME}` has the times that the segments' headers state"
            ));
        }
        notes.sort();
        notes.dedup();
        self.notes.extend(notes);
        if !empty.is_empty() {
            let names = empty.join(", ");
            self.notes
                .push(format!("without samples, and left out: {names}"));
        }
        Ok(())
    }

    /// Returns the timing, if the column of x agrees with it in the first segment.
    fn against_x(&self, timing: Timing, run: &Run) -> Result<Timing, LvmError> {
        let Timing::Even { interval_s, .. } = timing else {
            return Ok(timing);
        };
        let cell = match self.scan.header.x_columns {
            XColumns::No => return Ok(timing),
            XColumns::One => 0,
            XColumns::Multi => run.column.cell - 1,
        };
        if run.count < 2 {
            return Ok(timing);
        }
        let mut column = (*run.column).clone();
        column.cell = cell;
        let x = Run {
            column: Arc::new(column),
            ..run.clone()
        };
        let mut ends = Vec::new();
        self.read_run(X_NAME, &x, 0..1, &mut ends)?;
        self.read_run(X_NAME, &x, run.count - 1..run.count, &mut ends)?;
        let [first, last] = ends[..] else {
            return Ok(timing);
        };
        let found_s = (last - first) / (run.count - 1) as f64;
        // A few digits of x are printed.
        let is_same = (found_s - interval_s).abs() <= SAME_INTERVAL * interval_s.max(found_s);
        Ok(match is_same {
            true => timing,
            false => Timing::Uneven {
                reason: format!(
                    "`Delta_X` is {interval_s} s and the mean interval of `{X_NAME}` {found_s:.6} s"
                ),
            },
        })
    }
}
