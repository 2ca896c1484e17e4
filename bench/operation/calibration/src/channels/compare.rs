//! Comparison of the inputs with their calibration, by silence and one tone at the carrier, with the bench wired for
//! measurements.

use metrology::spectrum::{Spectrum, SpectrumError};
use metrology::tone::{SteadyTone, ToneError};

use super::fault::ChannelsFault;
use super::input_noise::{NOISE_RESOLUTION_HZ, noise_band};

/// Ratio to the calibrated noise above which the noise is a fault.
const NOISIER: f64 = 2.0;
/// Share of the commanded level above which another input carries the drive itself.
const CARRIES: f64 = 0.3;
/// Share of the commanded level below which the drive is not on its input.
const ABSENT: f64 = 0.3;

/// Present readings of a stream's inputs, in the stream's order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Present {
    /// Noise density about the carrier in silence, sample units/√Hz.
    pub noise: Vec<f64>,
    /// Amplitude at the carrier while it plays, sample units.
    pub levels: Vec<f64>,
}

/// Reason why an excerpt cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PresentError {
    /// The silence cannot be read.
    #[error(transparent)]
    Silence(#[from] SpectrumError),
    /// The tone cannot be read.
    #[error(transparent)]
    Tone(#[from] ToneError),
}

impl Present {
    /// Reads all `channels` of two interleaved excerpts: at least 0.1 s of `silence`, and a `tone` at `carrier_hz`.
    ///
    /// # Errors
    /// If an excerpt is too short, or has non-finite samples.
    pub fn read(
        silence: &[f32],
        tone: &[f32],
        channels: usize,
        carrier_hz: f64,
        rate_hz: f64,
    ) -> Result<Self, PresentError> {
        let mut present = Self::default();
        for channel in 0..channels {
            let spectrum =
                Spectrum::read(silence, channels, channel, rate_hz, NOISE_RESOLUTION_HZ)?;
            let [from_hz, to_hz] = noise_band(carrier_hz, rate_hz);
            present.noise.push(spectrum.noise(from_hz, to_hz).value);
            let tone = SteadyTone::read(tone, channels, channel, carrier_hz, rate_hz)?;
            present.levels.push(tone.value.norm());
        }
        Ok(present)
    }
}

/// Compares the inputs with the calibrated ones; the drive is on input `drive` and commanded to `commanded_units` there.
///
/// # Errors
/// The first fault found: the drive on another input, a silent drive, or higher noise.
pub fn compare(
    calibrated: &config::MeasuredChannels,
    drive: u16,
    commanded_units: f64,
    present: &Present,
) -> Result<(), ChannelsFault> {
    let level = |index: u16| present.levels.get(usize::from(index)).copied();
    let drive_level = level(drive).unwrap_or(0.0);
    if drive_level < ABSENT * commanded_units {
        // The pickup reads the plate's response, but the input with the drive's cable reads the drive itself and is the
        // loudest.
        let share = |input: &config::MeasuredInput| {
            let level = level(input.index).unwrap_or(0.0);
            level / (commanded_units * input.gain.value)
        };
        let other_inputs = calibrated
            .inputs
            .iter()
            .filter(|input| input.index != drive);
        let loudest = other_inputs
            .max_by(|a, b| share(a).total_cmp(&share(b)))
            .filter(|input| share(input) >= CARRIES);
        return Err(match loudest {
            Some(input) => ChannelsFault::Swapped {
                expected: drive,
                found: input.index,
            },
            None => ChannelsFault::Path(metrology::signal_path::PathFault::Silent {
                share: drive_level / commanded_units,
            }),
        });
    }
    for input in &calibrated.inputs {
        let Some(&noise) = present.noise.get(usize::from(input.index)) else {
            continue;
        };
        let ratio = noise / input.noise_on_bench.value;
        if ratio > NOISIER {
            return Err(ChannelsFault::NoisierThanCalibrated {
                input: input.index,
                ratio,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::channels_procedure::tests::calibrated;
    use super::*;

    fn present() -> Present {
        Present {
            noise: vec![1.1e-7, 0.9e-7, 1e-7],
            levels: vec![0.033, 0.02, 1e-6],
        }
    }

    #[test]
    fn unchanged_channels_pass() {
        assert_eq!(compare(&calibrated(), 0, 0.0333, &present()), Ok(()));
    }

    #[test]
    fn each_fault_has_its_name() {
        let mut swapped = present();
        swapped.levels.swap(0, 2);
        assert_eq!(
            compare(&calibrated(), 0, 0.0333, &swapped),
            Err(ChannelsFault::Swapped {
                expected: 0,
                found: 2
            })
        );
        let mut silent = present();
        silent.levels.fill(1e-6);
        assert!(matches!(
            compare(&calibrated(), 0, 0.0333, &silent),
            Err(ChannelsFault::Path(
                metrology::signal_path::PathFault::Silent { .. }
            ))
        ));
        let mut noisy = present();
        noisy.noise[1] = 3e-7;
        assert!(matches!(
            compare(&calibrated(), 0, 0.0333, &noisy),
            Err(ChannelsFault::NoisierThanCalibrated { input: 1, .. })
        ));
    }

    #[test]
    fn the_present_is_read_from_samples() {
        let rate_hz = 192e3;
        let tone: Vec<f32> = (0..9_600)
            .flat_map(|n| {
                let sine = (std::f64::consts::TAU * 35e3 * f64::from(n) / rate_hz).sin();
                [0.0, (0.03 * sine) as f32]
            })
            .collect();
        let silence = vec![0.0; 2 * 19_200];
        let present = Present::read(&silence, &tone, 2, 35e3, rate_hz).unwrap();
        assert_eq!(present.noise, [0.0, 0.0]);
        assert!(present.levels[0] < 1e-9 && (present.levels[1] - 0.03).abs() < 1e-6);
    }
}
