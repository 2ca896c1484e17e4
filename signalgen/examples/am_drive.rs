//! Renders an amplitude-modulated drive, prints its statistics, and optionally writes it to a WAV file.
//!
//! ```text
//! cargo run -p signalgen --example am_drive -- mean_v=40 modulation_index=0.95 wav=am_drive.wav
//! ```
//!
//! Every parameter of [`Drive`] can be given as `name=value`; by default it is the drive of Huloux 2021, section IV (35 kHz, 6
//! Hz, 95 %), at an assumed amplitude, limit and full scale. A drive that exceeds the limit, the converter's full scale or the
//! capacity of the sampling rate is refused, never clamped.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command")]

use std::{path::PathBuf, process::ExitCode};

use hound::{SampleFormat, WavSpec, WavWriter};
use signalgen::{DriveCommand, DriveConfig, DriveSettings, Generator, ProgramError, Waveform};
use thiserror::Error;

/// Frames per rendered block.
const BLOCK_FRAMES: usize = 4_096;
/// Longest drive, s.
const LONGEST_S: f64 = 3_600.0;

/// Parameters of the drive, in volts peak across the actuators.
#[derive(Clone, Debug, PartialEq)]
struct Drive {
    carrier_hz: f64,
    modulation_hz: f64,
    modulation_index: f64,
    mean_v: f64,
    ramp_s: f64,
    /// Time at full amplitude, between the ramps.
    duration_s: f64,
    sample_rate_hz: f64,
    /// Volts across the actuators at full scale of the output, amplifier included.
    volts_per_unit: f64,
    limit_v: f64,
    wav: Option<PathBuf>,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            carrier_hz: 35_000.0,
            modulation_hz: 6.0,
            modulation_index: 0.95,
            mean_v: 40.0,
            ramp_s: 0.05,
            duration_s: 2.0,
            sample_rate_hz: 192_000.0,
            volts_per_unit: 100.0,
            limit_v: 80.0,
            wav: None,
        }
    }
}

/// Reason why the drive is refused.
#[derive(Debug, Error)]
enum Refusal {
    #[error("{argument:?} is not name=value with one of the names {NAMES}")]
    Unknown { argument: String },
    #[error("{name} = {value:?} is not a number")]
    NotANumber { name: String, value: String },
    #[error("duration_s = {value} must be above 0 and at most {LONGEST_S} s")]
    Duration { value: f64 },
    #[error("sample_rate_hz = {value} must be a whole number of hertz")]
    Rate { value: f64 },
    #[error(transparent)]
    Program(#[from] ProgramError),
    #[error(transparent)]
    Wav(#[from] hound::Error),
}

const NAMES: &str = "carrier_hz, modulation_hz, modulation_index, mean_v, ramp_s, duration_s, sample_rate_hz, \
                     volts_per_unit, limit_v, wav";

impl Drive {
    fn parse(arguments: impl Iterator<Item = String>) -> Result<Self, Refusal> {
        let mut drive = Self::default();
        for argument in arguments {
            let Some((name, value)) = argument.split_once('=') else {
                return Err(Refusal::Unknown { argument });
            };
            let parameter = match name {
                "carrier_hz" => &mut drive.carrier_hz,
                "modulation_hz" => &mut drive.modulation_hz,
                "modulation_index" => &mut drive.modulation_index,
                "mean_v" => &mut drive.mean_v,
                "ramp_s" => &mut drive.ramp_s,
                "duration_s" => &mut drive.duration_s,
                "sample_rate_hz" => &mut drive.sample_rate_hz,
                "volts_per_unit" => &mut drive.volts_per_unit,
                "limit_v" => &mut drive.limit_v,
                "wav" => {
                    drive.wav = Some(value.into());
                    continue;
                }
                _ => return Err(Refusal::Unknown { argument }),
            };
            *parameter = value.parse().map_err(|_| Refusal::NotANumber {
                name: name.to_owned(),
                value: value.to_owned(),
            })?;
        }
        Ok(drive)
    }

    /// Renders ramp in, drive and ramp out; passes each block to `sink`.
    fn render(
        &self,
        mut sink: impl FnMut(&[f32]) -> Result<(), Refusal>,
    ) -> Result<Statistics, Refusal> {
        if !(self.duration_s > 0.0 && self.duration_s <= LONGEST_S) {
            let value = self.duration_s;
            return Err(Refusal::Duration { value });
        }
        let settings = DriveSettings::new(DriveConfig {
            sample_rate_hz: self.whole_rate_hz()?,
            volts_per_unit: self.volts_per_unit,
            limit_v: self.limit_v,
            ramp_s: self.ramp_s,
        })?;
        let program = settings.admit(Waveform::Modulated {
            carrier_hz: self.carrier_hz,
            mean_amplitude_v: self.mean_v,
            modulation_hz: self.modulation_hz,
            modulation_index: self.modulation_index,
            start_phase_rad: 0.0,
        })?;

        let mut generator = Generator::new(settings);
        let mut block = [0.0_f32; BLOCK_FRAMES];
        let mut statistics = Statistics::default();
        let ramp_frames = u64::from(settings.ramp_frames());
        let steady_frames = (self.duration_s * self.sample_rate_hz).round() as u64;
        for (command, frames, is_steady) in [
            (Some(DriveCommand::Start(program)), ramp_frames, false),
            (None, steady_frames, true),
            (Some(DriveCommand::Stop), ramp_frames, false),
        ] {
            if let Some(command) = command {
                generator.apply(command);
            }
            let mut remaining = frames;
            while remaining > 0 {
                let frames = remaining.min(BLOCK_FRAMES as u64);
                let block = &mut block[..frames as usize];
                generator.fill(block);
                statistics.add(block, self.volts_per_unit, is_steady);
                sink(block)?;
                remaining -= frames;
            }
        }
        Ok(statistics)
    }

    fn whole_rate_hz(&self) -> Result<u32, Refusal> {
        let value = self.sample_rate_hz;
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            Ok(value as u32)
        } else {
            Err(Refusal::Rate { value })
        }
    }

    /// Returns the closed form of the RMS over whole periods of the modulation, V.
    fn rms_v(&self) -> f64 {
        let m = self.modulation_index;
        self.mean_v * ((1.0 + 0.5 * m * m) / 2.0).sqrt()
    }
}

/// Statistics of the rendered drive.
#[derive(Clone, Copy, Debug, Default)]
struct Statistics {
    frames: u64,
    peak_v: f64,
    steady_frames: u64,
    steady_sum_v2: f64,
}

impl Statistics {
    fn add(&mut self, block: &[f32], volts_per_unit: f64, is_steady: bool) {
        self.frames += block.len() as u64;
        for &sample in block {
            let volts = f64::from(sample) * volts_per_unit;
            self.peak_v = self.peak_v.max(volts.abs());
            if is_steady {
                self.steady_frames += 1;
                self.steady_sum_v2 += volts * volts;
            }
        }
    }

    /// Returns the RMS at full amplitude, V.
    fn steady_rms_v(&self) -> f64 {
        (self.steady_sum_v2 / self.steady_frames as f64).sqrt()
    }
}

fn run(arguments: impl Iterator<Item = String>) -> Result<(), Refusal> {
    let drive = Drive::parse(arguments)?;
    // A refused drive leaves no file.
    let statistics = drive.render(|_| Ok(()))?;
    println!(
        "{:.3} s at {} Hz: {} frames",
        statistics.frames as f64 / drive.sample_rate_hz,
        drive.sample_rate_hz,
        statistics.frames
    );
    println!(
        "peak {:.3} V of a limit of {} V, {:.1} % of full scale",
        statistics.peak_v,
        drive.limit_v,
        100.0 * statistics.peak_v / drive.volts_per_unit
    );
    println!(
        "RMS at full amplitude {:.3} V; over whole periods of the modulation {:.3} V",
        statistics.steady_rms_v(),
        drive.rms_v()
    );
    if let Some(path) = &drive.wav {
        let spec = WavSpec {
            channels: 1,
            sample_rate: drive.whole_rate_hz()?,
            bits_per_sample: 32,
            sample_format: SampleFormat::Float,
        };
        let mut writer = WavWriter::create(path, spec)?;
        drive.render(|block| {
            for &sample in block {
                writer.write_sample(sample)?;
            }
            Ok(())
        })?;
        writer.finalize()?;
        println!("written to {}", path.display());
    }
    Ok(())
}

fn main() -> ExitCode {
    match run(std::env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(refusal) => {
            eprintln!("refused: {refusal}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_drive(arguments: &[&str]) -> Result<Drive, Refusal> {
        Drive::parse(arguments.iter().map(|&argument| argument.to_owned()))
    }

    #[test]
    fn statistics_agree_with_the_closed_form() {
        let drive = parse_drive(&["duration_s=1", "mean_v=30", "modulation_index=0.5"]).unwrap();
        let mut samples = Vec::new();
        let statistics = drive
            .render(|block| {
                samples.extend_from_slice(block);
                Ok(())
            })
            .unwrap();
        assert_eq!(statistics.frames, 192_000 + 2 * 9_600);
        assert_eq!(samples.len() as u64, statistics.frames);
        assert!((statistics.steady_rms_v() / drive.rms_v() - 1.0).abs() < 1e-4);
        assert!((statistics.peak_v - 45.0).abs() < 0.01);
        // From silence to silence: the last frame of a raised cosine is below (π/2N)² of the peak.
        assert_eq!(samples[0], 0.0);
        assert!(samples.last().unwrap().abs() < 1e-7);
    }

    #[test]
    fn drives_beyond_a_limit_are_refused() {
        let refusal = |argument: &str| {
            let drive = parse_drive(&[argument]).unwrap();
            drive
                .render(|_| panic!("nothing must be rendered"))
                .unwrap_err()
        };
        assert!(matches!(
            refusal("mean_v=60"),
            Refusal::Program(ProgramError::AboveLimit { limit_v: 80.0, .. })
        ));
        assert!(matches!(
            refusal("limit_v=300"),
            Refusal::Program(ProgramError::Limit(_))
        ));
        assert!(matches!(
            refusal("sample_rate_hz=48000"),
            Refusal::Program(ProgramError::RateTooLow { .. })
        ));
        assert!(matches!(refusal("duration_s=-1"), Refusal::Duration { .. }));
        assert!(matches!(
            refusal("sample_rate_hz=0.5"),
            Refusal::Rate { .. }
        ));
    }

    #[test]
    fn arguments_are_read_strictly() {
        assert_eq!(parse_drive(&[]).unwrap(), Drive::default());
        for argument in ["mean=40", "40"] {
            assert!(matches!(
                parse_drive(&[argument]),
                Err(Refusal::Unknown { argument: a }) if a == argument
            ));
        }
        assert!(matches!(
            parse_drive(&["mean_v=4o"]),
            Err(Refusal::NotANumber { .. })
        ));
    }
}
