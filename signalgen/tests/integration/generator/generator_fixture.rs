//! Fixture: a generator at 192 kHz, its waveforms, and its samples in volts.

use std::f64::consts::TAU;

use signalgen::{
    DEFAULT_RAMP_S, DriveCommand, DriveConfig, DriveSettings, Generator, Program, Waveform,
};

pub const RATE_HZ: u32 = 192_000;
pub const FULL_SCALE_V: f64 = 200.0;

pub fn settings_at(sample_rate_hz: u32, limit_v: f64) -> DriveSettings {
    DriveSettings::new(DriveConfig {
        sample_rate_hz,
        volts_per_unit: FULL_SCALE_V,
        limit_v,
        ramp_s: DEFAULT_RAMP_S,
    })
    .unwrap()
}

pub fn settings() -> DriveSettings {
    settings_at(RATE_HZ, 100.0)
}

pub fn admit(waveform: Waveform) -> Program {
    settings().admit(waveform).unwrap()
}

/// The published drive: 35 kHz, 6 Hz, 95 %.
pub fn modulated_waveform(mean_amplitude_v: f64, start_phase_rad: f64) -> Waveform {
    Waveform::Modulated {
        carrier_hz: 35_000.0,
        mean_amplitude_v,
        modulation_hz: 6.0,
        modulation_index: 0.95,
        start_phase_rad,
    }
}

pub fn tone(carrier_hz: f64, amplitude_v: f64) -> Waveform {
    Waveform::Tone {
        carrier_hz,
        amplitude_v,
    }
}

pub fn running_generator(waveform: Waveform) -> Generator {
    let mut generator = Generator::new(settings());
    generator.apply(DriveCommand::Start(admit(waveform)));
    generator
}

/// Returns the next frames, V.
pub fn volts(generator: &mut Generator, frames: usize) -> Vec<f64> {
    let mut samples = vec![0.0_f32; frames];
    generator.fill(&mut samples);
    samples
        .iter()
        .map(|&s| f64::from(s) * FULL_SCALE_V)
        .collect()
}

/// Returns 2π · frequency · frame / rate for whole frequencies, reduced in integers.
pub fn angle(frequency_hz: u64, frame: u64) -> f64 {
    let rate = u64::from(RATE_HZ);
    TAU * ((frequency_hz * frame) % rate) as f64 / rate as f64
}

/// f32 samples at a full scale of 200 V.
pub const QUANTISATION_V: f64 = 1e-5;
