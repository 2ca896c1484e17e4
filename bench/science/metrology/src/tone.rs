//! A steady tone in a stretch of samples, as a calibration reads it from each dwell.

use num_complex::Complex64;
use statistics::significant;
use std::f64::consts::TAU;

/// Complex envelope X̃ of the tone in one channel: x(t) = Re[X̃ exp(+iωt)], t from the first sample of the stretch,
/// under a Hann window, and the remainder of the channel without it.
///
/// ```
/// use metrology::tone::SteadyTone;
/// use std::f64::consts::TAU;
///
/// let samples: Vec<f32> = (0..9_600)
///     .map(|n| (0.1 + 0.5 * (TAU * 35e3 * f64::from(n) / 192e3).cos()) as f32)
///     .collect();
/// let tone = SteadyTone::read(&samples, 1, 0, 35e3, 192e3)?;
/// assert!((tone.value - 0.5).norm() < 1e-6);
/// # Ok::<(), metrology::tone::ToneError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyTone {
    /// X̃ in sample units, peak.
    pub value: Complex64,
    /// Largest |sample|.
    pub peak: f64,
    /// Root mean square of the samples without the tone and without their mean.
    pub rest_rms: f64,
}

/// Reasons why no tone can be read in a stretch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ToneError {
    /// Too short to separate the tone from its mirror image and from DC.
    #[error("{frames} frames hold {cycles:.1} cycles of {} Hz, at least {least} wanted", significant(*.carrier_hz))]
    TooShort {
        /// Frames in the stretch.
        frames: usize,
        /// Cycles of the tone in it.
        cycles: f64,
        /// Frequency of the tone, Hz.
        carrier_hz: f64,
        /// Fewest cycles accepted.
        least: f64,
    },
    /// The tone lies at or above half the sample rate.
    #[error("{} Hz is not below half the sample rate of {} Hz", significant(*.carrier_hz), significant(*.sample_rate_hz))]
    AboveNyquist {
        /// Frequency of the tone, Hz.
        carrier_hz: f64,
        /// Sample rate, Hz.
        sample_rate_hz: f64,
    },
    /// A sample is lost.
    #[error("sample {frame} of channel {channel} is lost")]
    Lost {
        /// Frame within the stretch.
        frame: usize,
        /// Channel.
        channel: usize,
    },
}

/// Cycles from which on the Hann window's sidelobes keep the tone's mirror image and DC under 1e-5.
const LEAST_CYCLES: f64 = 50.0;

impl SteadyTone {
    /// Reads the tone at `carrier_hz` in `channel` of an interleaved stretch of `stream_channels` channels.
    ///
    /// DC, mains hum and the tone's own mirror image are rejected as the cube of their distance in cycles per stretch:
    /// a 50 ms stretch at 35 kHz reads a clean tone to 1e-8 of full scale (`a_tone_is_read_beside_hum_and_offset`).
    ///
    /// # Errors
    /// When the stretch is too short, the tone above half the sample rate, or a sample lost.
    pub fn read(
        interleaved: &[f32],
        stream_channels: usize,
        channel: usize,
        carrier_hz: f64,
        sample_rate_hz: f64,
    ) -> Result<Self, ToneError> {
        let frames = interleaved.len() / stream_channels;
        if carrier_hz >= sample_rate_hz / 2.0 {
            return Err(ToneError::AboveNyquist {
                carrier_hz,
                sample_rate_hz,
            });
        }
        let cycles = frames as f64 * carrier_hz / sample_rate_hz;
        if cycles < LEAST_CYCLES {
            return Err(ToneError::TooShort {
                frames,
                cycles,
                carrier_hz,
                least: LEAST_CYCLES,
            });
        }
        let samples = || {
            interleaved
                .iter()
                .skip(channel)
                .step_by(stream_channels)
                .map(|&sample| f64::from(sample))
        };
        if let Some(frame) = samples().position(|sample| !sample.is_finite()) {
            return Err(ToneError::Lost { frame, channel });
        }
        // X̃ = 2 Σ w_n (x_n − x̄) e^{−iωn/rate}/Σ w_n with the Hann window w_n = ½ − ½ cos(2π(n + ½)/N): 2, because half of a
        // real tone's power lies at −ω.
        let mean = samples().sum::<f64>() / frames as f64;
        let turn = TAU * carrier_hz / sample_rate_hz;
        let bell = TAU / frames as f64;
        let (mut sum, mut weights) = (Complex64::ZERO, 0.0);
        for (n, sample) in samples().enumerate() {
            let n = n as f64;
            let weight = 0.5 - 0.5 * (bell * (n + 0.5)).cos();
            sum += Complex64::cis(-turn * n) * (weight * (sample - mean));
            weights += weight;
        }
        let value = 2.0 * sum / weights;
        let (mut squares, mut peak) = (0.0, 0.0f64);
        for (n, sample) in samples().enumerate() {
            let tone = (value * Complex64::cis(turn * n as f64)).re;
            squares += (sample - mean - tone).powi(2);
            peak = peak.max(sample.abs());
        }
        Ok(Self {
            value,
            peak,
            rest_rms: (squares / frames as f64).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_is_read_beside_hum_and_offset() {
        let (rate, carrier) = (192_000.0, 35_012.7);
        let truth = Complex64::from_polar(0.3, -2.1);
        let samples: Vec<f32> = (0..9_600)
            .flat_map(|n| {
                let t = f64::from(n) / rate;
                let tone = (truth * Complex64::cis(TAU * carrier * t)).re;
                [0.0, (tone + 0.2 + 0.1 * (TAU * 50.0 * t).sin()) as f32]
            })
            .collect();
        let tone = SteadyTone::read(&samples, 2, 1, carrier, rate).unwrap();
        assert!((tone.value - truth).norm() < 1e-8, "{}", tone.value - truth);
        assert!((tone.rest_rms - 0.1 / 2f64.sqrt()).abs() < 2e-3);
        assert!((0.5..0.601).contains(&tone.peak));
    }

    #[test]
    fn unreadable_tones_are_refused() {
        let read = |samples: &[f32], hz| SteadyTone::read(samples, 1, 0, hz, 192_000.0);
        assert!(matches!(
            read(&[0.0; 100], 35e3),
            Err(ToneError::TooShort { .. })
        ));
        assert!(matches!(
            read(&[0.0; 9_600], 96e3),
            Err(ToneError::AboveNyquist { .. })
        ));
        let mut lost = [0.0; 9_600];
        lost[77] = f32::NAN;
        assert_eq!(
            read(&lost, 35e3),
            Err(ToneError::Lost {
                frame: 77,
                channel: 0
            })
        );
    }
}
