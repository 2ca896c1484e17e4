//! Rows of a sensor in the order of their times, of a file or in memory.

use std::collections::VecDeque;

use crate::csv_rows::CsvRow;
use crate::read_error::{EARLY_END_S, OUTSIDE_S, Warning};

/// Step in time between rows that later rows must confirm, s.
const LEAP_S: f64 = 0.1;
/// Number of rows that confirm a jump in time.
const CONFIRMING_ROWS: usize = 64;

/// Row with a finite time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ParsedRow<R> {
    pub(crate) row: R,
    /// Its line in the file, from 1.
    pub(crate) line: u64,
    pub(crate) is_finite: bool,
}

/// Number of rows with a defect, and the line of the first one.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Tally {
    pub(crate) rows: u64,
    pub(crate) first_line: u64,
}

impl Tally {
    pub(crate) fn count(&mut self, line: u64) {
        if self.rows == 0 {
            self.first_line = line;
        }
        self.rows += 1;
    }
}

/// Rows in the order in which they were taken, without those with a time that does not increase, jumps ahead of the following
/// rows or lies outside the recording.
#[derive(Debug)]
pub(crate) struct RowOrder<R> {
    file: &'static str,
    /// Length of the audio, s.
    duration_s: f64,
    is_at_end: bool,
    last_time_s: f64,
    /// Rows after a jump in time, until enough rows confirm it.
    pending_rows: VecDeque<ParsedRow<R>>,
    is_confirmed: bool,
    rows: u64,
    disordered_rows: Tally,
    leap_rows: Tally,
    outside_rows: Tally,
    outside_from_s: f64,
    outside_to_s: f64,
    not_finite_rows: Tally,
}

impl<R: CsvRow> RowOrder<R> {
    /// Creates the order of the rows of a recording of `duration_s`; `file` names them in warnings.
    pub(crate) fn new(file: &'static str, duration_s: f64) -> Self {
        Self {
            file,
            duration_s,
            is_at_end: false,
            last_time_s: f64::NEG_INFINITY,
            pending_rows: VecDeque::new(),
            is_confirmed: false,
            rows: 0,
            disordered_rows: Tally::default(),
            leap_rows: Tally::default(),
            outside_rows: Tally::default(),
            outside_from_s: f64::INFINITY,
            outside_to_s: f64::NEG_INFINITY,
            not_finite_rows: Tally::default(),
        }
    }

    /// Returns the defects of the rows so far; complete once the rows have ended.
    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let file = self.file;
        let mut warnings = Vec::new();
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

    /// Returns whether the rows have ended.
    pub(crate) fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// Ends the rows: those that wait for a confirmation are confirmed.
    pub(crate) fn end(&mut self) {
        self.is_at_end = true;
    }

    /// Ends the rows without those that wait for a confirmation.
    pub(crate) fn abandon(&mut self) {
        self.is_at_end = true;
        self.pending_rows.clear();
    }

    /// Takes a row, or counts the reason to omit it.
    pub(crate) fn take(&mut self, next: ParsedRow<R>) {
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
    pub(crate) fn confirmed_row(&mut self) -> Option<R> {
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
