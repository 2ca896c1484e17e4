//! Rows of `force.csv` and `position.csv`.

use std::io::Write;

/// One reading of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceRow {
    /// Time on the audio clock, seconds from sample 0 of the recording.
    pub time_s: f64,
    /// Normal force, N; NaN where it was lost.
    pub normal_n: f64,
    /// Lateral force, N; NaN where it was lost.
    pub lateral_n: f64,
}

/// One reading of the position sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionRow {
    /// Time on the audio clock, seconds from sample 0 of the recording.
    pub time_s: f64,
    /// Position along the plate, metres; NaN where it was lost.
    pub position_m: f64,
}

/// A row of a CSV file with a fixed header, time first.
///
/// Times are written to 1 ns and values as the shortest decimal of the nearest `f32` (relative error under 6e-8).
pub trait Row: Sized + Copy {
    /// The columns; the first is the time.
    const COLUMNS: &'static [&'static str];

    /// Time, seconds from sample 0.
    fn time_s(&self) -> f64;

    /// The row of a file from its fields in the order of `COLUMNS`.
    fn from_fields(fields: &[f64]) -> Option<Self>;

    /// Appends the row as a line.
    fn write_line(&self, line: &mut Vec<u8>);
}

impl Row for ForceRow {
    const COLUMNS: &'static [&'static str] = &["time_s", "normal_n", "lateral_n"];

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

impl Row for PositionRow {
    const COLUMNS: &'static [&'static str] = &["time_s", "position_m"];

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

fn write_line(line: &mut Vec<u8>, time_s: f64, values: &[f64]) {
    let nanoseconds = (time_s * 1e9).round() as i64;
    let sign = if nanoseconds < 0 { "-" } else { "" };
    let nanoseconds = nanoseconds.unsigned_abs();
    let (seconds, fraction) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
    // Writing to a Vec cannot fail.
    let _ = write!(line, "{sign}{seconds}.{fraction:09}");
    for value in values {
        let _ = write!(line, ",{}", *value as f32);
    }
    line.push(b'\n');
}
