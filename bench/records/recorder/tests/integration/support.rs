//! Helpers of the tests of the recorder.

use std::path::Path;

use recording::manifest::{
    Carrier, FORMAT, Manifest, Modulation, Participant, RecordedChannels, RecordedContact,
    RecordedDrive, RecordedPickup, RecordedPlate, RecordedSignals, Software, Streams, Trial,
};
use recording::{AudioFormat, ForceRow, PositionRow, RecordingReader};

pub const FORMAT_2: AudioFormat = AudioFormat {
    sample_rate_hz: 192_000,
    channels: 2,
};

pub fn manifest() -> Manifest {
    Manifest {
        format: FORMAT,
        streams: Streams::Signals(RecordedSignals {
            carrier: Carrier::Steady(35_000.0),
            modulation: Modulation {
                frequency_hz: 6.0,
                index: 0.95,
            },
            channels: RecordedChannels {
                rate_hz: None,
                drive: RecordedDrive {
                    index: 0,
                    volts_per_unit: 100.0,
                    clip_units: None,
                },
                pickup: RecordedPickup {
                    index: 1,
                    metres_per_unit: 2e-6,
                    phase_rad: 0.1,
                    clip_units: None,
                },
            },
            plate: RecordedPlate {
                resonance_hz: 35_000.0,
                modal_mass_kg: 0.008,
                force_factor_n_per_v: 0.13,
                centre_m: 0.0525,
                profile: None,
                across: None,
            },
        }),
        contact: RecordedContact::default(),
        standard_errors: None,
        room: None,
        intervals: Vec::new(),
        participant: Some(Participant {
            id: "sub-01".to_owned(),
            session: 1,
        }),
        trial: Some(Trial {
            number: 3,
            attempt: 1,
            practice: false,
            condition: "6 Hz".to_owned(),
            protocol: "huloux2021".to_owned(),
            protocol_file: Some("huloux2021.toml".to_owned()),
            seed: 42,
            end: None,
            interruption: None,
        }),
        hardware: None,
        software: Some(Software {
            name: "friction-bench".to_owned(),
            version: "0.1.0".to_owned(),
        }),
        origin: None,
        clocks: Vec::new(),
        events: Vec::new(),
    }
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
