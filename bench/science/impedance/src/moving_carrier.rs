//! Carriers that move within a recording, as those of phase-locked drives: the frequency is read from the drive, and each stretch
//! is demodulated at its own.
//!
//! Impedances are then referred to one frequency ω₀: by the plate's equation of motion (see [`crate::Zm`]) an impedance at ω exceeds that
//! at ω₀ by the plate's reactance X(ω) − X(ω₀), X(ω) = ω m_p − k_p/ω. The contact's own impedance is taken as that at ω.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::demodulator::{Demodulator, DemodulatorError, EnvelopeFrame, InputChannel};
use crate::filter::{Filter, FilterError, samples_per_frame};
use crate::zm::{PlateConstants, ZmFrame};

/// Frames of a stretch with one frequency: 0.1 s.
const STRETCH_FRAMES: u64 = 200;
/// Shortest block of which the frequency is read, s: lines of 48 Hz or less.
const SHORTEST_BLOCK_S: f64 = 0.02;
/// Range of the carrier about the plate's resonance, relative to it.
const REACH: f64 = 0.2;
/// Power of a block relative to the strongest below which its frequency is not used: near a null of the modulation.
const LEAST_POWER: f64 = 0.01;
/// Offset beyond which the drive's rotation within a frame is noise, Hz.
const GREATEST_OFFSET_HZ: f64 = 500.0;

/// Reads the frequency of a drive as it is sampled.
pub struct CarrierTracker {
    rate_hz: f64,
    lines: std::ops::Range<usize>,
    window: Vec<f64>,
    transform: std::sync::Arc<dyn fourier::RealToComplex<f64>>,
    block: Vec<f64>,
    /// Middle of each block in samples, its frequency in Hz, and its power.
    readings: Vec<(f64, f64, f64)>,
    samples: u64,
}

/// Frequency of a drive over time.
#[derive(Clone, Debug, PartialEq)]
pub struct CarrierTrack {
    /// Middle of each block, s, and its frequency, Hz; in order, never empty.
    readings: Vec<(f64, f64)>,
}

/// A drive without a carrier near the plate's resonance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the drive has no carrier from {lowest_hz:.0} to {highest_hz:.0} Hz, within a fifth of the plate's resonance"
)]
pub struct NoCarrier {
    /// Lowest frequency that was looked at, Hz.
    pub lowest_hz: f64,
    /// Highest frequency that was looked at, Hz.
    pub highest_hz: f64,
}

impl CarrierTracker {
    /// Prepares to read a drive sampled at `rate_hz`, with its carrier near `resonance_hz`.
    #[must_use]
    pub fn new(rate_hz: f64, resonance_hz: f64) -> Self {
        let length = ((rate_hz * SHORTEST_BLOCK_S) as usize)
            .next_power_of_two()
            .max(64);
        let line = |hz: f64| (hz / rate_hz * length as f64) as usize;
        // One line to either side of the largest is needed.
        let last = length / 2 - 1;
        let lines = line(resonance_hz * (1.0 - REACH)).clamp(1, last)
            ..line(resonance_hz * (1.0 + REACH)).clamp(1, last);
        let window = (0..length)
            .map(|n| 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / length as f64).cos())
            .collect();
        Self {
            rate_hz,
            lines,
            window,
            transform: fourier::forward(length),
            block: Vec::with_capacity(length),
            readings: Vec::new(),
            samples: 0,
        }
    }

    /// Takes the next samples of the drive; lost ones are NaN.
    pub fn take(&mut self, samples: impl Iterator<Item = f32>) {
        for sample in samples {
            self.block.push(f64::from(sample));
            self.samples += 1;
            if self.block.len() == self.window.len() {
                self.read_block();
                self.block.clear();
            }
        }
    }

    fn read_block(&mut self) {
        let mut windowed: Vec<f64> = self
            .block
            .iter()
            .zip(&self.window)
            .map(|(x, w)| x * w)
            .collect();
        if windowed.iter().any(|x| !x.is_finite()) {
            return;
        }
        let mut spectrum = self.transform.make_output_vec();
        if self
            .transform
            .process(&mut windowed, &mut spectrum)
            .is_err()
        {
            return;
        }
        let power = |line: usize| spectrum[line].norm_sqr();
        let Some(line) = self
            .lines
            .clone()
            .max_by(|a, b| power(*a).total_cmp(&power(*b)))
        else {
            return;
        };
        // A Hann window: for a tone δ lines above the largest, the ratio of the neighbour above to it is (1 + δ)/(2 − δ), and
        // likewise below.
        let [below, middle, above] = [line - 1, line, line + 1].map(|line| power(line).sqrt());
        let (neighbour, sign) = if above > below {
            (above, 1.0)
        } else {
            (below, -1.0)
        };
        let ratio = neighbour / middle;
        let offset = sign * (2.0 * ratio - 1.0) / (1.0 + ratio);
        let length = self.window.len() as f64;
        let frequency_hz = (line as f64 + offset) * self.rate_hz / length;
        if frequency_hz.is_finite() {
            let middle_sample = self.samples as f64 - length / 2.0;
            self.readings
                .push((middle_sample, frequency_hz, power(line)));
        }
    }

    /// Returns the frequency over time.
    ///
    /// # Errors
    /// No block has a carrier.
    pub fn finish(self) -> Result<CarrierTrack, NoCarrier> {
        let greatest = self
            .readings
            .iter()
            .map(|reading| reading.2)
            .fold(0.0, f64::max);
        let readings: Vec<(f64, f64)> = self
            .readings
            .iter()
            .filter(|reading| reading.2 > 0.0 && reading.2 >= LEAST_POWER * greatest)
            .map(|(sample, frequency_hz, _)| (sample / self.rate_hz, *frequency_hz))
            .collect();
        if readings.is_empty() {
            let hz = |line: usize| line as f64 * self.rate_hz / self.window.len() as f64;
            return Err(NoCarrier {
                lowest_hz: hz(self.lines.start),
                highest_hz: hz(self.lines.end),
            });
        }
        Ok(CarrierTrack { readings })
    }
}

impl CarrierTrack {
    /// Returns the mean frequency, Hz.
    #[must_use]
    pub fn mean_hz(&self) -> f64 {
        let sum: f64 = self.readings.iter().map(|(_, hz)| hz).sum();
        sum / self.readings.len() as f64
    }

    /// Returns the lowest and the highest frequency, Hz.
    #[must_use]
    pub fn range_hz(&self) -> (f64, f64) {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        self.readings
            .iter()
            .fold(ends, |(lowest, highest), (_, hz)| {
                (lowest.min(*hz), highest.max(*hz))
            })
    }

    /// Returns the mean frequency from `start_s` to `end_s`, Hz; interpolated where no block could be read.
    fn mean_within_hz(&self, start_s: f64, end_s: f64) -> f64 {
        let from = self
            .readings
            .partition_point(|(time_s, _)| *time_s < start_s);
        let to = self
            .readings
            .partition_point(|(time_s, _)| *time_s <= end_s);
        if from < to {
            let inside = &self.readings[from..to];
            return inside.iter().map(|(_, hz)| hz).sum::<f64>() / inside.len() as f64;
        }
        let middle_s = f64::midpoint(start_s, end_s);
        match (
            from.checked_sub(1).map(|index| self.readings[index]),
            self.readings.get(from),
        ) {
            (Some(before), Some(after)) => {
                let share = (middle_s - before.0) / (after.0 - before.0);
                before.1 + share * (after.1 - before.1)
            }
            (Some(before), None) => before.1,
            (None, reading) => reading.map_or(f64::NAN, |reading| reading.1),
        }
    }
}

/// Demodulates drive and pickup at a carrier that moves, stretch by stretch.
pub struct MovingDemodulator {
    track: CarrierTrack,
    sample_rate_hz: f64,
    hop: u32,
    stream_channels: usize,
    inputs: [InputChannel; 2],
    /// Interleaved samples from `first` on that a stretch still needs.
    samples: Vec<f32>,
    first: u64,
    stretch: u64,
    /// Demodulator of the current stretch.
    current: Demodulator<2>,
}

impl MovingDemodulator {
    /// Creates a demodulator of a stream of interleaved channels, with a carrier along `track`.
    ///
    /// # Errors
    /// A filter cannot be designed for the sampling rate and the first carrier, or an input's channel does not exist.
    pub fn new(
        track: CarrierTrack,
        sample_rate_hz: f64,
        stream_channels: usize,
        inputs: [InputChannel; 2],
    ) -> Result<Self, MovingCarrierError> {
        let hop = samples_per_frame(sample_rate_hz);
        let stretch_s = (STRETCH_FRAMES * u64::from(hop)) as f64 / sample_rate_hz;
        let carrier_hz = track.mean_within_hz(0.0, stretch_s);
        let filter = Filter::with_hop(sample_rate_hz, carrier_hz, hop)?;
        let current = Demodulator::new(filter, stream_channels, inputs)?;
        Ok(Self {
            track,
            sample_rate_hz,
            hop,
            stream_channels,
            inputs,
            samples: Vec::new(),
            first: 0,
            stretch: 0,
            current,
        })
    }

    /// Demodulates a block and emits the frames of the stretches that it completes, each with the filter of its carrier.
    ///
    /// # Errors
    /// The block does not hold whole frames, or a filter cannot be designed for the carrier of a stretch.
    pub fn push(
        &mut self,
        interleaved: &[f32],
        emit: impl FnMut(&EnvelopeFrame<2>, &Filter),
    ) -> Result<(), MovingCarrierError> {
        self.samples.extend_from_slice(interleaved);
        self.advance(false, emit)
    }

    /// Emits the frames of the last stretch, which is shorter than the others.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn finish(
        &mut self,
        emit: impl FnMut(&EnvelopeFrame<2>, &Filter),
    ) -> Result<(), MovingCarrierError> {
        self.advance(true, emit)
    }

    fn advance(
        &mut self,
        is_last: bool,
        mut emit: impl FnMut(&EnvelopeFrame<2>, &Filter),
    ) -> Result<(), MovingCarrierError> {
        let stretch_samples = STRETCH_FRAMES * u64::from(self.hop);
        loop {
            let start = self.stretch * stretch_samples;
            let end = start + stretch_samples;
            let stored = self.first + (self.samples.len() / self.stream_channels) as u64;
            let half = self.current.filter().half_support();
            let is_complete = stored > end + half;
            if !is_complete && (!is_last || stored <= start) {
                return Ok(());
            }
            self.tune(start, end)?;
            // Frames lie on multiples of the hop, so that the demodulator begins on one.
            let hop = u64::from(self.hop);
            let lead_in = half.next_multiple_of(hop).min(start - self.first);
            let begin = start - lead_in;
            let samples = &self.samples[(begin - self.first) as usize * self.stream_channels..];
            let needed = (lead_in + stretch_samples + half + 1) as usize * self.stream_channels;
            let samples = &samples[..needed.min(samples.len())];
            let filter = self.current.filter().clone();
            let rate_hz = self.sample_rate_hz;
            self.current.push(samples, |frame| {
                let sample = frame.sample + begin;
                if (start..end).contains(&sample) {
                    let time_s = sample as f64 / rate_hz;
                    let frame = EnvelopeFrame {
                        sample,
                        time_s,
                        ..*frame
                    };
                    emit(&frame, &filter);
                }
            })?;
            self.stretch += 1;
            let next_begin = end
                .saturating_sub(half.next_multiple_of(hop))
                .max(self.first);
            let consumed = (next_begin - self.first) as usize * self.stream_channels;
            self.samples.drain(..consumed.min(self.samples.len()));
            self.first = next_begin;
        }
    }

    fn tune(&mut self, start: u64, end: u64) -> Result<(), MovingCarrierError> {
        let time_s = |sample: u64| sample as f64 / self.sample_rate_hz;
        let carrier_hz = self.track.mean_within_hz(time_s(start), time_s(end));
        let filter = Filter::with_hop(self.sample_rate_hz, carrier_hz, self.hop)?;
        self.current = Demodulator::new(filter, self.stream_channels, self.inputs)?;
        Ok(())
    }
}

/// Reasons why a moving carrier cannot be demodulated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MovingCarrierError {
    /// The drive has no carrier.
    #[error(transparent)]
    NoCarrier(#[from] NoCarrier),
    /// No filter can be designed for the carrier at some time.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// The stream cannot be demodulated.
    #[error(transparent)]
    Demodulator(#[from] DemodulatorError),
}

/// Refers the impedances of a frame, demodulated by `filter`, to `reference_hz`. The plain ratio belongs to the drive's frequency at
/// the frame's time, the corrected one to that of the filter.
#[must_use]
pub fn referred(
    frame: ZmFrame,
    envelopes: &EnvelopeFrame<2>,
    filter: &Filter,
    plate: &PlateConstants,
    reference_hz: f64,
) -> ZmFrame {
    let carrier_hz = filter.carrier_hz();
    let drive = envelopes.drive();
    let offset_hz = (drive.slope_per_s / drive.value).im / TAU;
    let is_read = offset_hz.is_finite() && offset_hz.abs() <= GREATEST_OFFSET_HZ;
    let momentary_hz = carrier_hz + if is_read { offset_hz } else { 0.0 };
    let excess = |hz: f64| Complex64::I * (reactance(plate, hz) - reactance(plate, reference_hz));
    ZmFrame {
        corrected_n_s_per_m: frame.corrected_n_s_per_m - excess(carrier_hz),
        plain_n_s_per_m: frame.plain_n_s_per_m * (carrier_hz / momentary_hz) - excess(momentary_hz),
        ..frame
    }
}

/// Returns the plate's reactance ω m_p − k_p/ω, N·s/m.
fn reactance(plate: &PlateConstants, hz: f64) -> f64 {
    let omega = TAU * hz;
    omega * plate.modal_mass_kg - plate.stiffness_n_per_m() / omega
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::zm::{ChannelScales, Zm};

    const RATE_HZ: f64 = 192_000.0;
    const PLATE: PlateConstants = PlateConstants {
        resonance_hz: 35e3,
        modal_mass_kg: 0.008,
        force_factor_n_per_v: 0.13,
    };
    const DAMPING: f64 = 7.0;

    /// Returns drive and pickup of a free plate under a carrier that moves linearly from `from_hz` to `to_hz`, modulated at 6 Hz.
    fn stream(from_hz: f64, to_hz: f64, seconds: f64) -> Vec<f32> {
        let samples = (seconds * RATE_HZ) as usize;
        let step_s = RATE_HZ.recip();
        // The plate's equation of motion in 16 steps a sample, by the exact propagator of the free oscillator.
        const FINE: usize = 16;
        let h = step_s / FINE as f64;
        let omega0 = TAU * PLATE.resonance_hz;
        let rate = DAMPING / (2.0 * PLATE.modal_mass_kg);
        let damped = (omega0 * omega0 - rate * rate).sqrt();
        let propagator = Complex64::new(-rate, damped) * h;
        let turn = propagator.exp();
        // ẍ + 2r ẋ + ω₀² x = f/m: with z = ẋ + (r + iω_d) x, ż = (−r + iω_d) z + f/m.
        let (mut z, mut phase) = (Complex64::ZERO, 0.0f64);
        let gain = (turn - 1.0) / Complex64::new(-rate, damped);
        let mut interleaved = Vec::with_capacity(2 * samples);
        for n in 0..samples {
            for fine in 0..FINE {
                let t = n as f64 * step_s + fine as f64 * h;
                let hz = from_hz + (to_hz - from_hz) * t / seconds;
                // Force in the middle of the step.
                let envelope = 20.0 * (1.0 + 0.8 * (TAU * 6.0 * t).sin());
                let middle = phase + 0.5 * TAU * hz * h;
                if fine == 0 {
                    interleaved.push((envelope * phase.cos() / 100.0) as f32);
                    interleaved.push((z.im / damped / 2e-6) as f32);
                }
                let force = PLATE.force_factor_n_per_v * envelope * middle.cos();
                z = z * turn + gain * (force / PLATE.modal_mass_kg);
                phase += TAU * hz * h;
            }
        }
        interleaved
    }

    fn frames(stream: &[f32], reference: Option<f64>) -> (CarrierTrack, Vec<ZmFrame>) {
        let mut tracker = CarrierTracker::new(RATE_HZ, PLATE.resonance_hz);
        tracker.take(stream.iter().step_by(2).copied());
        let track = tracker.finish().unwrap();
        let reference_hz = reference.unwrap_or(track.mean_hz());
        let input = |channel| InputChannel {
            channel,
            clip_level: f32::INFINITY,
        };
        let scales = ChannelScales {
            drive_volts_per_unit: 100.0,
            pickup_metres_per_unit: 2e-6,
            pickup_phase_rad: 0.0,
        };
        let mut demodulator =
            MovingDemodulator::new(track.clone(), RATE_HZ, 2, [input(0), input(1)]).unwrap();
        let mut frames = Vec::new();
        let mut take = |envelopes: &EnvelopeFrame<2>, filter: &Filter| {
            let frame = Zm::new(PLATE, scales, filter).unwrap().read(envelopes);
            frames.push(referred(frame, envelopes, filter, &PLATE, reference_hz));
        };
        for block in stream.chunks(2 * 5000) {
            demodulator.push(block, &mut take).unwrap();
        }
        demodulator.finish(&mut take).unwrap();
        (track, frames)
    }

    #[test]
    fn a_plate_under_a_carrier_that_moves_by_300_hz_has_one_impedance() {
        let stream = stream(34_850.0, 35_150.0, 1.0);
        let (track, frames) = frames(&stream, Some(35e3));
        let (lowest_hz, highest_hz) = track.range_hz();
        assert!((lowest_hz - 34_850.0).abs() < 10.0, "{lowest_hz}");
        assert!((highest_hz - 35_150.0).abs() < 10.0, "{highest_hz}");
        // Frames are evenly spaced across the stretches.
        for pair in frames.windows(2) {
            assert_eq!(pair[1].sample - pair[0].sample, 96);
        }
        assert!(frames.len() > 1950, "{}", frames.len());
        for frame in frames.iter().filter(|frame| frame.time_s > 0.05) {
            assert!(frame.mask.is_clear(), "{frame:?}");
            let error = frame.corrected_n_s_per_m - DAMPING;
            assert!(error.norm() < 0.02 * DAMPING, "{} s: {error}", frame.time_s);
        }
    }

    #[test]
    fn a_drive_without_a_carrier_is_named() {
        let mut tracker = CarrierTracker::new(RATE_HZ, PLATE.resonance_hz);
        tracker.take(std::iter::repeat_n(0.0, 100_000));
        let error = tracker.finish().unwrap_err().to_string();
        assert!(
            error.contains("no carrier from 27984 to 42000 Hz"),
            "{error}"
        );
    }
}
