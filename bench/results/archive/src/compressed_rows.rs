//! Forces and positions of an archive: rounded, at most at the rate that the estimates need, compressed by gzip.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use recording::disk::OnPath;
use recording::reader::{ReadError, RowReader, Warning, force_rows, position_rows};
use recording::{COMPRESSED_FORCE_FILE, COMPRESSED_POSITION_FILE, CsvRow, ForceRow, PositionRow};
use statistics::median;

use crate::archive_error::ArchiveError;
use crate::rounding::{DecimalStep, decimal, noise};

/// Least rate of rows that are means of several, Hz: at 2 kHz, σ_t of `trial` was off by 0.3 %.
const LEAST_RATE_HZ: f64 = 4500.0;
/// Rows from which rate and noise are read.
const FIRST_ROWS: usize = 50_000;
/// Digits of a time: microseconds.
const TIME_DIGITS: usize = 6;
/// Distance between rows, in the usual one, from which a mean does not include both.
const GAP_STEPS: f64 = 1.5;

/// Writes the forces, if there are any; returns the name of the file and the warnings of their rows.
pub(crate) fn write_forces(
    source: &Path,
    target: &Path,
    duration_s: f64,
) -> Result<Option<Written>, ArchiveError> {
    let open = || force_rows(source, duration_s);
    let values = |row: &ForceRow| [row.time_s, row.normal_n, row.lateral_n];
    write(open, values, &target.join(COMPRESSED_FORCE_FILE), true)
}

/// Writes the positions, if there are any; returns the name of the file and the warnings of their rows.
pub(crate) fn write_positions(
    source: &Path,
    target: &Path,
    duration_s: f64,
) -> Result<Option<Written>, ArchiveError> {
    let open = || position_rows(source, duration_s);
    let values = |row: &PositionRow| [row.time_s, row.position_m];
    // The steps of an encoder are no noise.
    write(open, values, &target.join(COMPRESSED_POSITION_FILE), false)
}

/// Warnings of the rows of a written file that do not follow from the file.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub(crate) warnings: Vec<String>,
}

fn write<R: CsvRow, const N: usize>(
    open: impl Fn() -> Result<RowReader<R>, ReadError>,
    values: impl Fn(&R) -> [f64; N],
    target: &Path,
    is_noisy: bool,
) -> Result<Option<Written>, ArchiveError> {
    let first = match open() {
        Err(ReadError::Absent { .. }) => return Ok(None),
        rows => rows?.take(FIRST_ROWS),
    };
    let first = first
        .map(|row| Ok(values(&row?)))
        .collect::<Result<Vec<_>, ReadError>>()?;
    let mut means = Means::for_rows(&first);
    let mut first_means = Vec::new();
    for row in &first {
        first_means.extend(means.take(row));
    }
    means.sum = Vec::new();
    let step_of = |column: usize| {
        let column: Vec<f64> = first_means
            .iter()
            .map(|row: &[f64; N]| row[column])
            .collect();
        is_noisy
            .then(|| DecimalStep::for_noise(noise(&column)))
            .flatten()
    };
    let steps: Vec<Option<DecimalStep>> = (1..N).map(step_of).collect();

    let file = File::create(target).with_path("create", target)?;
    let mut out = GzEncoder::new(
        BufWriter::with_capacity(1 << 16, file),
        Compression::default(),
    );
    let mut rows = open()?;
    let mut line = R::COLUMNS.required.join(",") + "\n";
    out.write_all(line.as_bytes()).with_path("write", target)?;
    let mut write_row = |row: [f64; N]| {
        line.clear();
        line.push_str(&decimal(row[0], TIME_DIGITS));
        for (value, step) in row[1..].iter().zip(&steps) {
            line.push(',');
            match step {
                Some(step) => line.push_str(&step.text(*value)),
                None => line.push_str(&(*value as f32).to_string()),
            }
        }
        line.push('\n');
        out.write_all(line.as_bytes()).with_path("write", target)
    };
    for row in rows.by_ref() {
        for row in means.take(&values(&row?)) {
            write_row(row)?;
        }
    }
    if let Some(row) = means.flush() {
        write_row(row)?;
    }
    let file = out.finish().with_path("write", target)?;
    let file = file
        .into_inner()
        .map_err(|error| error.into_error())
        .with_path("write", target)?;
    file.sync_data().with_path("sync", target)?;
    let warnings = rows.warnings().into_iter();
    let warnings = warnings.filter(|warning| {
        // The rows of the archive show these too.
        !matches!(
            warning,
            Warning::EndsEarly { .. } | Warning::NoRows { .. } | Warning::NotFinite { .. }
        )
    });
    Ok(Some(Written {
        warnings: warnings.map(|warning| warning.to_string()).collect(),
    }))
}

/// Means over whole numbers of rows.
#[derive(Debug)]
struct Means<const N: usize> {
    rows: usize,
    longest_s: f64,
    sum: Vec<[f64; N]>,
}

impl<const N: usize> Means<N> {
    /// Returns means that keep the rows' rate at [`LEAST_RATE_HZ`] or more.
    fn for_rows(first: &[[f64; N]]) -> Self {
        let steps_s = first.windows(2).map(|pair| pair[1][0] - pair[0][0]);
        let step_s = median(steps_s).unwrap_or(f64::INFINITY);
        let rows = (step_s * LEAST_RATE_HZ).recip().floor();
        Self {
            rows: (rows as usize).max(1),
            longest_s: GAP_STEPS * step_s,
            sum: Vec::new(),
        }
    }

    /// Takes a row and returns the means that it completes. A lost value ends a mean, and stays a row.
    fn take(&mut self, row: &[f64; N]) -> Vec<[f64; N]> {
        let mut complete = Vec::new();
        let is_apart = |last: &[f64; N]| row[0] - last[0] > self.longest_s;
        let is_lost = row.iter().any(|value| !value.is_finite());
        if is_lost || self.sum.last().is_some_and(is_apart) {
            complete.extend(self.flush());
        }
        if is_lost {
            complete.push(*row);
            return complete;
        }
        self.sum.push(*row);
        if self.sum.len() >= self.rows {
            complete.extend(self.flush());
        }
        complete
    }

    fn flush(&mut self) -> Option<[f64; N]> {
        let count = self.sum.len() as f64;
        let rows = std::mem::take(&mut self.sum);
        (!rows.is_empty()).then(|| {
            std::array::from_fn(|column| rows.iter().map(|row| row[column]).sum::<f64>() / count)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn means(rows: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut means = Means::for_rows(rows);
        let mut all: Vec<[f64; 2]> = rows.iter().flat_map(|row| means.take(row)).collect();
        all.extend(means.flush());
        all
    }

    #[test]
    fn fast_rows_become_means_that_do_not_cross_gaps() {
        let time_s = |n: usize| n as f64 * 1e-4 + if n >= 501 { 0.5 } else { 0.0 };
        let mut rows: Vec<[f64; 2]> = (0..1000).map(|n| [time_s(n), n as f64]).collect();
        rows[700][1] = f64::NAN;
        let means = means(&rows);
        assert_eq!(means[0], [0.5e-4, 0.5]);
        // The odd row before the gap stays alone.
        assert!(means.contains(&rows[500]));
        let lost = means.iter().filter(|row| row[1].is_nan());
        assert_eq!(lost.map(|row| row[0]).collect::<Vec<_>>(), [time_s(700)]);
        assert!(means.windows(2).all(|pair| pair[1][0] > pair[0][0]));
    }

    #[test]
    fn slow_rows_stay() {
        let rows: Vec<[f64; 2]> = (0..100)
            .map(|n| [f64::from(n) * 1e-3, f64::from(n)])
            .collect();
        assert_eq!(means(&rows), rows);
    }
}
