//! Rows of `force.csv` and `position.csv`.

use std::io::Write;

use text_tables::Columns;

/// Reading of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceRow {
    /// Time on the audio clock, seconds from sample 0 of the recording.
    pub time_s: f64,
    /// Normal force, N; NaN if lost.
    pub normal_n: f64,
    /// Lateral force, N; NaN if lost.
    pub lateral_n: f64,
}

/// Reading of the position sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionRow {
    /// Time on the audio clock, seconds from sample 0 of the recording.
    pub time_s: f64,
    /// Position along the plate, m; NaN if lost.
    pub position_m: f64,
}

/// Reading of the stimulus of a surface, in the unit of its modulator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StimulusRow {
    /// Time on the clock of the forces, s.
    pub time_s: f64,
    /// Stimulus: a voltage, an amplitude, or 0 and 1 for off and on; NaN if lost.
    pub stimulus: f64,
}

/// Row of a CSV file with a fixed header, time first.
///
/// Times are written to 1 ns and values as the shortest decimal of the nearest `f32` (relative error under 1.2e-7).
pub trait CsvRow: Sized + Copy {
    /// Names of the columns; the first one is the time.
    const COLUMNS: Columns;

    /// Returns the time, seconds from sample 0.
    fn time_s(&self) -> f64;

    /// Makes a row from its fields in the order of `COLUMNS`; `None` if their number is wrong.
    fn from_fields(fields: &[f64]) -> Option<Self>;

    /// Appends the row as a line.
    fn write_line(&self, line: &mut Vec<u8>);
}

impl CsvRow for ForceRow {
    const COLUMNS: Columns = Columns {
        required: &["time_s", "normal_n", "lateral_n"],
        optional: &[],
    };

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn from_fields(fields: &[f64]) -> Option<Self> {
        let &[time_s, normal_n, lateral_n] = fields else {
            return None;
        };
        Some(Self {
            time_s,
            normal_n,
            lateral_n,
        })
    }

    fn write_line(&self, line: &mut Vec<u8>) {
        write_line(line, self.time_s, &[self.normal_n, self.lateral_n]);
    }
}

impl CsvRow for PositionRow {
    const COLUMNS: Columns = Columns {
        required: &["time_s", "position_m"],
        optional: &[],
    };

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn from_fields(fields: &[f64]) -> Option<Self> {
        let &[time_s, position_m] = fields else {
            return None;
        };
        Some(Self { time_s, position_m })
    }

    fn write_line(&self, line: &mut Vec<u8>) {
        write_line(line, self.time_s, &[self.position_m]);
    }
}

impl CsvRow for StimulusRow {
    const COLUMNS: Columns = Columns {
        required: &["time_s", "stimulus"],
        optional: &[],
    };

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn from_fields(fields: &[f64]) -> Option<Self> {
        let &[time_s, stimulus] = fields else {
            return None;
        };
        Some(Self { time_s, stimulus })
    }

    fn write_line(&self, line: &mut Vec<u8>) {
        write_line(line, self.time_s, &[self.stimulus]);
    }
}

fn write_line(line: &mut Vec<u8>, time_s: f64, values: &[f64]) {
    let nanoseconds = (time_s * 1e9).round() as i64;
    let sign = if nanoseconds < 0 { "-" } else { "" };
    let nanoseconds = nanoseconds.unsigned_abs();
    let (seconds, fraction) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
    // Writing to a `Vec` cannot fail.
    let _ = write!(line, "{sign}{seconds}.{fraction:09}");
    for value in values {
        let _ = write!(line, ",{}", *value as f32);
    }
    line.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn line(row: &impl CsvRow) -> String {
        let mut line = Vec::new();
        row.write_line(&mut line);
        String::from_utf8(line).unwrap()
    }

    #[test]
    fn times_have_nanoseconds_and_values_their_shortest_digits() {
        let row = ForceRow {
            time_s: 12.3456789012,
            normal_n: 0.65,
            lateral_n: -0.001_186_95,
        };
        assert_eq!(line(&row), "12.345678901,0.65,-0.00118695\n");
        let row = PositionRow {
            time_s: -0.000_000_25,
            position_m: 0.0525,
        };
        assert_eq!(line(&row), "-0.000000250,0.0525\n");
    }

    #[test]
    fn lost_values_are_nan() {
        let row = PositionRow {
            time_s: 1.0,
            position_m: f64::NAN,
        };
        assert_eq!(line(&row), "1.000000000,NaN\n");
    }

    proptest! {
        #[test]
        fn a_row_reads_back_to_a_nanosecond_and_single_precision(
            time_s in -10.0..10_000.0,
            normal_n in -100.0..100.0,
            lateral_n in -1e-6..1e-6,
        ) {
            let text = line(&ForceRow { time_s, normal_n, lateral_n });
            let fields: Vec<f64> = text.trim().split(',').map(|f| f.parse().unwrap()).collect();
            let row = ForceRow::from_fields(&fields).unwrap();
            prop_assert!((row.time_s - time_s).abs() <= 0.6e-9);
            prop_assert!((row.normal_n - normal_n).abs() <= 1.2e-7 * normal_n.abs());
            prop_assert!((row.lateral_n - lateral_n).abs() <= 1.2e-7 * lateral_n.abs());
        }
    }
}
