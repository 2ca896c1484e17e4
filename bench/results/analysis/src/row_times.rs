//! Reads the rows of force and position that an analysis needs, and checks the times of all rows.

use std::borrow::Cow;

use plausibility::Implausible;
use recording::reader::{ReadError, Warning};

use crate::findings::RecordingError;
use crate::flaw::Flaw;
use crate::measurements::{LONGEST_GAP_S, MARGIN_S};
use crate::spans::Spans;

/// Largest number of rows of a file within the intervals, which limits their duration at a little over 10 kHz.
const MAX_ROWS: usize = 20_000_000;
/// Number of rows with intervals that are checked.
const STEPS: usize = 1_000_000;

/// Returns the rows needed to smooth the spans, and the times of all `rows`, which increase.
pub(super) fn read_rows<R>(
    spans: &Spans,
    file: &'static str,
    rows: impl Iterator<Item = Result<R, ReadError>>,
    time_s: impl Fn(&R) -> f64,
) -> Result<(Vec<R>, RowTimes), RecordingError> {
    let (mut needed_rows, mut times) = (Vec::new(), RowTimes::new(file));
    for row in rows {
        let row = row?;
        times.take(time_s(&row));
        // One row more on each side changes nothing, but one less might.
        if spans.contain(time_s(&row), 2.0 * MARGIN_S) {
            if needed_rows.len() == MAX_ROWS {
                return Err(RecordingError::TooManyRows {
                    file,
                    limit: MAX_ROWS,
                });
            }
            needed_rows.push(row);
        }
    }
    Ok((needed_rows, times))
}

/// Times of the rows of a file.
pub(super) struct RowTimes {
    file: &'static str,
    ends_s: Option<(f64, f64)>,
    steps_s: Vec<f64>,
    rows: u64,
}

impl RowTimes {
    fn new(file: &'static str) -> Self {
        Self {
            file,
            ends_s: None,
            steps_s: Vec::new(),
            rows: 0,
        }
    }

    fn take(&mut self, time_s: f64) {
        let (first_s, last_s) = self.ends_s.unwrap_or((time_s, time_s));
        if time_s > last_s && self.steps_s.len() < STEPS {
            self.steps_s.push(time_s - last_s);
        }
        self.ends_s = Some((first_s, time_s));
        self.rows += 1;
    }

    /// Returns the flaws of a file: those found by its reader, and readings outside the recording or too far apart.
    pub(super) fn flaws(mut self, warnings: Vec<Warning>, duration_s: f64) -> Vec<Flaw> {
        let file = self.file;
        let time_flaw = |from_s, to_s| Flaw::ElsewhereInTime {
            file,
            from_s,
            to_s,
            duration_s,
        };
        let mut flaws: Vec<Flaw> = Vec::new();
        for warning in warnings {
            if let Warning::TimeDisorder { rows, .. } = warning
                && rows > self.rows
            {
                let rounded = Implausible::RoundedTimes {
                    file: Cow::Borrowed(file),
                    lost: rows,
                    rows: rows + self.rows,
                };
                flaws.push(rounded.into());
            }
            flaws.push(match (&warning, self.ends_s) {
                (Warning::OutsideRecording { from_s, to_s, .. }, None) => time_flaw(*from_s, *to_s),
                _ => warning.into(),
            });
        }
        let Some((from_s, to_s)) = self.ends_s else {
            return flaws;
        };
        if to_s < 0.0 || from_s > duration_s {
            flaws.push(time_flaw(from_s, to_s));
            return flaws;
        }
        self.steps_s.sort_by(f64::total_cmp);
        let step_s = self.steps_s.get(self.steps_s.len() / 2).copied();
        flaws.extend(
            step_s
                .filter(|step_s| *step_s > LONGEST_GAP_S)
                .map(|step_s| Flaw::Sparse { file, step_s }),
        );
        flaws
    }
}
