//! Envelopes at an even rate, with NaN in gaps.

use std::path::{Path, PathBuf};

use num_complex::Complex64;

use crate::{EnvelopeError, EnvelopeReader, EnvelopeRow};

/// Rows of a read.
const BLOCK_ROWS: usize = 1 << 14;
/// Rows from which the rate is read.
const RATE_ROWS: usize = 10_000;
/// Largest distance of a time from its place at an even rate, in intervals.
const TOLERANCE: f64 = 0.25;
/// Longest gap, s.
const LONGEST_GAP_S: f64 = 600.0;

/// Rows of `envelopes.parquet` at an even rate; gaps of whole intervals are filled with NaN.
#[derive(Debug)]
pub struct EvenRows {
    path: PathBuf,
    reader: EnvelopeReader,
    start_s: f64,
    rate_hz: f64,
    block: Vec<EnvelopeRow>,
    /// Rows of the file that were read, and rows at the even rate that were returned.
    read: u64,
    given: u64,
    /// First of the rows that are still to be placed.
    anchor: (u64, f64),
}

impl EvenRows {
    /// Opens the file and reads its rate.
    ///
    /// # Errors
    /// The file or a column is missing, or it has no rows.
    pub fn open(path: &Path) -> Result<Self, EnvelopeError> {
        let mut rate_reader = EnvelopeReader::open(path)?;
        let mut rows = Vec::new();
        while rows.len() < RATE_ROWS {
            let mut block = Vec::new();
            if rate_reader.read(RATE_ROWS - rows.len(), &mut block)? == 0 {
                break;
            }
            rows.append(&mut block);
        }
        let mut steps_s: Vec<f64> = rows
            .windows(2)
            .map(|pair| pair[1].time_s - pair[0].time_s)
            .filter(|step_s| step_s.is_finite() && *step_s > 0.0)
            .collect();
        steps_s.sort_by(f64::total_cmp);
        let (Some(first), Some(step_s)) = (rows.first(), steps_s.get(steps_s.len() / 2)) else {
            return Err(EnvelopeError::TooFewRows {
                path: path.to_owned(),
            });
        };
        // Over many rows the mean interval is more exact than the median, unless there is a gap.
        let intervals: Vec<&f64> = steps_s
            .iter()
            .filter(|other_s| (*other_s / step_s - 1.0).abs() < TOLERANCE)
            .collect();
        let mean_s = intervals.iter().copied().sum::<f64>() / intervals.len() as f64;
        Ok(Self {
            path: path.to_owned(),
            reader: EnvelopeReader::open(path)?,
            start_s: first.time_s,
            rate_hz: mean_s.recip(),
            block: Vec::new(),
            read: 0,
            given: 0,
            anchor: (0, first.time_s),
        })
    }

    /// Returns the time of the first row, s.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.start_s
    }

    /// Returns the rate of the rows, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Returns the time of the last row that was read, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.anchor.1
    }

    /// Appends the envelopes of drive and pickup of the next rows; returns their number, 0 at the end.
    ///
    /// # Errors
    /// The file cannot be read, or its times are uneven.
    pub fn read(&mut self, envelopes: &mut Vec<[Complex64; 2]>) -> Result<usize, EnvelopeError> {
        self.block.clear();
        let n_read = self.reader.read(BLOCK_ROWS, &mut self.block)?;
        let before = envelopes.len();
        for row in &self.block {
            self.read += 1;
            // Each row is placed after the one before it, so that an inexact rate does not add up.
            let (anchor, anchor_s) = self.anchor;
            let steps = (row.time_s - anchor_s) * self.rate_hz;
            let whole = steps.round();
            let is_first = self.given == 0;
            let is_next = whole >= 1.0 || (is_first && whole == 0.0);
            let is_near = (steps - whole).abs() <= TOLERANCE;
            if !(is_next && is_near && whole / self.rate_hz <= LONGEST_GAP_S) {
                return Err(EnvelopeError::Uneven {
                    path: self.path.clone(),
                    row: self.read,
                    time_s: row.time_s,
                    expected_s: anchor_s + if is_first { 0.0 } else { self.rate_hz.recip() },
                    rate_hz: self.rate_hz,
                });
            }
            let place = anchor + whole as u64;
            while self.given < place {
                envelopes.push([Complex64::new(f64::NAN, f64::NAN); 2]);
                self.given += 1;
            }
            envelopes.push([row.drive_v, row.pickup_m]);
            self.given += 1;
            self.anchor = (place, row.time_s);
        }
        // A block of rows never gives fewer envelopes.
        Ok(if n_read == 0 {
            0
        } else {
            envelopes.len() - before
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EnvelopeWriter;

    fn rows(times_s: impl Iterator<Item = f64>) -> Vec<EnvelopeRow> {
        let row = |time_s| EnvelopeRow {
            time_s,
            drive_v: Complex64::new(time_s, 1.0),
            pickup_m: Complex64::new(0.0, 1e-6 * time_s),
        };
        times_s.map(row).collect()
    }

    fn read(rows: &[EnvelopeRow]) -> Result<(EvenRows, Vec<[Complex64; 2]>), EnvelopeError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("envelopes.parquet");
        let mut writer = EnvelopeWriter::create(&path).unwrap();
        for block in rows.chunks(1000) {
            writer.write(block).unwrap();
        }
        writer.finish().unwrap();
        let mut even_rows = EvenRows::open(&path)?;
        let mut envelopes = Vec::new();
        while even_rows.read(&mut envelopes)? > 0 {}
        Ok((even_rows, envelopes))
    }

    #[test]
    fn gaps_are_filled_and_the_rate_is_that_of_the_times() {
        let time_s = |n: u64| 0.1 + n as f64 / 3333.0;
        let rows = rows(
            (0..50_000)
                .filter(|n| !(20_000..20_010).contains(n))
                .map(time_s),
        );
        let (even_rows, envelopes) = read(&rows).unwrap();
        assert!((even_rows.rate_hz() - 3333.0).abs() < 1e-6);
        assert_eq!(even_rows.start_s(), 0.1);
        assert_eq!(envelopes.len(), 50_000);
        assert!(envelopes[20_005][0].is_nan());
        assert_eq!(envelopes[49_999][0].re, time_s(49_999));
    }

    #[test]
    fn uneven_times_are_named_with_their_row() {
        let mut jittered = rows((0..3000).map(|n| f64::from(n) / 2000.0));
        jittered[1234].time_s += 0.4 / 2000.0;
        let error = read(&jittered).unwrap_err().to_string();
        assert!(error.contains("row 1235"), "{error}");
        let mut backwards = rows((0..3000).map(|n| f64::from(n) / 2000.0));
        backwards[7].time_s = 0.0;
        assert!(matches!(
            read(&backwards),
            Err(EnvelopeError::Uneven { row: 8, .. })
        ));
        assert!(matches!(
            read(&rows([0.0].into_iter())),
            Err(EnvelopeError::TooFewRows { .. })
        ));
    }
}
