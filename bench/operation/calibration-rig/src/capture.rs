//! Captures of a calibration: samples, forces and an instrument's readings of one step, with the frames of its tones.

use std::ops::Range;

use anyhow::bail;
use metrology::tone::{SteadyTone, ToneError};
use signalgen::Waveform;
use sources::TimedForce;

/// A tone within a capture, at full amplitude throughout.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// Frequency, Hz.
    pub carrier_hz: f64,
    /// Frames of the capture that contain the tone.
    pub frames: Range<usize>,
}

/// Everything that was acquired during one step.
#[derive(Debug, Clone, Default)]
pub struct Capture {
    /// Samples of all channels, interleaved.
    pub samples: Vec<f32>,
    /// Number of channels of the stream.
    pub channels: usize,
    /// Frames per second, Hz.
    pub rate_hz: f64,
    /// Tones in the order in which they sounded.
    pub dwells: Vec<Dwell>,
    /// Start of the capture on the audio clock, s.
    pub from_s: f64,
    /// Normal forces, N.
    pub normal_n: Vec<f64>,
    /// Lateral forces, N.
    pub lateral_n: Vec<f64>,
    /// Number of forces at the end of their range, normal and lateral.
    pub force_saturated: [usize; 2],
    /// Frames at which the instrument's readings arrived, and the readings, m.
    pub known_m: Vec<(usize, f64)>,
    /// Number of frames acquired when the generator was first seen to play; `None` before that.
    pub began: Option<usize>,
}

impl Capture {
    /// Adds a reading of the force sensor.
    pub(super) fn take_force(&mut self, force: &TimedForce) {
        self.normal_n.push(force.normal_n);
        self.lateral_n.push(force.lateral_n);
        let [normal, lateral] = &mut self.force_saturated;
        *normal += usize::from(force.normal_saturated);
        *lateral += usize::from(force.lateral_saturated);
    }

    /// Reads `channel` during the tone of `dwell`, from `settle_s` after its start.
    ///
    /// # Errors
    /// If the rest of the tone is too short.
    pub fn tone(
        &self,
        dwell: &Dwell,
        channel: u16,
        settle_s: f64,
    ) -> Result<SteadyTone, ToneError> {
        let window = self.settled(dwell, settle_s);
        SteadyTone::read(
            &self.samples[window.start * self.channels..window.end * self.channels],
            self.channels,
            usize::from(channel),
            dwell.carrier_hz,
            self.rate_hz,
        )
    }

    /// Returns the frames of `dwell` from `settle_s` on.
    #[must_use]
    pub fn settled(&self, dwell: &Dwell, settle_s: f64) -> Range<usize> {
        let settle = (settle_s * self.rate_hz) as usize;
        (dwell.frames.start + settle).min(dwell.frames.end)..dwell.frames.end
    }

    /// Returns the length of the capture, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        (self.samples.len() / self.channels) as f64 / self.rate_hz
    }

    /// Drops the first `frames` frames, and an equal share of the forces.
    pub(super) fn forget(&mut self, frames: usize) {
        let length = self.samples.len() / self.channels;
        let share = |len: usize| len * frames / length.max(1);
        self.from_s += frames as f64 / self.rate_hz;
        self.samples.drain(..frames * self.channels);
        self.normal_n.drain(..share(self.normal_n.len()));
        self.lateral_n.drain(..share(self.lateral_n.len()));
        self.known_m.retain_mut(|(frame, _)| {
            let is_kept = *frame >= frames;
            *frame = frame.saturating_sub(frames);
            is_kept
        });
    }

    /// Returns the readings of an axis, normal or lateral, N.
    #[must_use]
    pub fn force_n(&self, axis: usize) -> &[f64] {
        [&self.normal_n, &self.lateral_n][axis]
    }

    /// Returns the means of normal and lateral force, N; `None` without a sensor.
    #[must_use]
    pub fn mean_force_n(&self) -> Option<(f64, f64)> {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        (!self.normal_n.is_empty()).then(|| (mean(&self.normal_n), mean(&self.lateral_n)))
    }
}

/// Length of the pieces in which the onset of a tone is sought, s.
const ONSET_S: f64 = 5e-4;
/// Smallest ratio of a tone's level to that of the silence before it.
const LEAST_RISE: f64 = 4.0;
/// Level below which the tone is not on the drive's input, as a share of the loudest input's level.
const MISPLACED: f64 = 0.01;

/// Returns the last `frames` frames of a held tone.
pub(super) fn last_tone(capture: &Capture, waveform: &Waveform, frames: usize) -> Vec<Dwell> {
    let Waveform::Tone { carrier_hz, .. } = *waveform else {
        return Vec::new();
    };
    let length = capture.samples.len() / capture.channels;
    vec![Dwell {
        carrier_hz,
        frames: length.saturating_sub(frames)..length,
    }]
}

/// Returns, for each piece of `piece` frames of a channel, the amplitude of a tone with the same root mean square.
fn levels(capture: &Capture, channel: usize, piece: usize) -> Vec<f64> {
    let samples: Vec<f64> = capture
        .samples
        .iter()
        .skip(channel)
        .step_by(capture.channels)
        .map(|&sample| f64::from(sample))
        .collect();
    samples
        .chunks_exact(piece)
        .map(|chunk| {
            let n = chunk.len() as f64;
            let mean = chunk.iter().sum::<f64>() / n;
            let power = chunk.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
            (2.0 * power).sqrt()
        })
        .collect()
}

/// Returns the levels of the drive's input, or those of the loudest input if the drive's is nearly silent.
fn loud_levels(capture: &Capture, drive_channel: usize, piece: usize) -> Vec<f64> {
    let full = |levels: &[f64]| levels.iter().copied().fold(0.0, f64::max);
    let drive = levels(capture, drive_channel, piece);
    let loudest = (0..capture.channels)
        .map(|channel| levels(capture, channel, piece))
        .max_by(|a, b| full(a).total_cmp(&full(b)));
    match loudest {
        Some(loudest) if full(&drive) < MISPLACED * full(&loudest) => loudest,
        _ => drive,
    }
}

/// Returns the frames of each tone, located by the ramp of known length before the first tone: it reaches half its level after
/// half its length. Empty if no tone came back.
pub(super) fn dwells(
    capture: &Capture,
    waveform: &Waveform,
    drive_channel: usize,
    ramp_frames: usize,
) -> anyhow::Result<Vec<Dwell>> {
    let Waveform::SteppedTones { tones, dwell_s, .. } = waveform else {
        return Ok(Vec::new());
    };
    let piece = (ONSET_S * capture.rate_hz) as usize;
    let levels = loud_levels(capture, drive_channel, piece);
    let full = levels.iter().copied().fold(0.0, f64::max);
    let lowest = levels.iter().copied().fold(f64::INFINITY, f64::min);
    if full.is_nan() || full < LEAST_RISE * lowest {
        return Ok(Vec::new());
    }
    let Some(crossing_index) = levels.iter().position(|&level| level >= 0.5 * full) else {
        return Ok(Vec::new());
    };
    // The crossing lies between the centres of two pieces.
    let lower = levels[crossing_index.saturating_sub(1)];
    let share = if levels[crossing_index] > lower {
        (0.5 * full - lower) / (levels[crossing_index] - lower)
    } else {
        1.0
    };
    let crossing = (crossing_index as f64 - 0.5 + share) * piece as f64;
    let first = (crossing + 0.5 * ramp_frames as f64).round() as usize;
    let length = (dwell_s * capture.rate_hz).round() as usize;
    let last = first + length * tones.as_slice().len();
    let frames = capture.samples.len() / capture.channels;
    if last > frames {
        bail!(
            "the capture ended before the tones did: safety.loop_latency_s is shorter than the loop's latency"
        );
    }
    Ok(tones
        .as_slice()
        .iter()
        .enumerate()
        .map(|(i, &carrier_hz)| Dwell {
            carrier_hz,
            frames: first + i * length..first + (i + 1) * length,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use signalgen::ToneList;

    #[test]
    fn dwells_are_found_within_half_a_millisecond() {
        let (rate, ramp, start) = (192_000.0, 9_600, 7_777);
        let waveform = Waveform::SteppedTones {
            tones: ToneList::new(&[34_900.0, 35_100.0]).unwrap(),
            dwell_s: 0.05,
            amplitude_v: 1.0,
        };
        let samples: Vec<f32> = (0..60_000)
            .map(|n: usize| {
                let t = n.saturating_sub(start);
                let end = ramp + 2 * 9_600;
                let envelope = if t < ramp {
                    0.5 - 0.5 * (std::f64::consts::PI * t as f64 / ramp as f64).cos()
                } else if t < end {
                    1.0
                } else {
                    0.0
                };
                (0.2 * envelope * (std::f64::consts::TAU * 35e3 * n as f64 / rate).sin()) as f32
            })
            .collect();
        let capture = Capture {
            samples,
            channels: 1,
            rate_hz: rate,
            ..Capture::default()
        };
        let segments = dwells(&capture, &waveform, 0, ramp).unwrap();
        assert_eq!(segments.len(), 2);
        let error = segments[0].frames.start.abs_diff(start + ramp);
        assert!(error < 96, "{error}");
        assert_eq!(segments[1].frames.start, segments[0].frames.end);
    }
}
