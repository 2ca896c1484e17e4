//! Helpers of the tests of the recorder.

use std::path::Path;

use recording::manifest::{MINIMAL, Manifest};
use recording::{AudioFormat, ForceRow, PositionRow, RecordingReader};

pub const FORMAT_2: AudioFormat = AudioFormat {
    sample_rate_hz: 192_000,
    channels: 2,
};

/// Trial to which the recordings belong.
const TRIAL: &str = r#"
[trial]
number = 3
attempt = 1
practice = false
condition = "6 Hz"
protocol = "huloux2021"
seed = 42
"#;

pub fn manifest() -> Manifest {
    Manifest::parse(&format!("{MINIMAL}{TRIAL}"), "recording.toml").unwrap()
}

/// Returns frames with `n` on the drive and `-n` on the pickup in frame `n`.
pub fn ramp(from: usize, frames: usize) -> Vec<f32> {
    (from..from + frames)
        .flat_map(|n| [n as f32, -(n as f32)])
        .collect()
}

pub fn force_rows(from: u32, rows: u32) -> Vec<ForceRow> {
    (from..from + rows)
        .map(|n| ForceRow {
            time_s: f64::from(n) * 1e-4,
            normal_n: 0.65,
            lateral_n: -0.5,
        })
        .collect()
}

pub fn position_rows(from: u32, rows: u32) -> Vec<PositionRow> {
    (from..from + rows)
        .map(|n| PositionRow {
            time_s: f64::from(n) * 1e-3,
            position_m: 0.01 + f64::from(n) * 5e-5,
        })
        .collect()
}

pub fn read_all(folder: &Path) -> (RecordingReader, Vec<f32>) {
    let mut reader = RecordingReader::open(folder).unwrap();
    let (mut all, mut block) = (Vec::new(), Vec::new());
    while reader.read_block(333, &mut block).unwrap() > 0 {
        all.extend_from_slice(&block);
    }
    (reader, all)
}
