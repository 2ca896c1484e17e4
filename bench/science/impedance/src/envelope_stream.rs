//! Frames from complex envelopes, as a lock-in amplifier keeps them, in place of samples.
//!
//! The envelopes pass the second stage of the [`Filter`], which yields value, slope and curvature at the frames' times, as for
//! sampled signals. At less than 3 kHz each envelope has a frame.

use std::collections::VecDeque;

use num_complex::Complex64;

use crate::demodulator::{ChannelEnvelope, EnvelopeFrame};
use crate::filter::Filter;
use crate::kernel;
use crate::mask::Mask;
use crate::noise::NoiseFloor;

/// Fewest envelopes per frame at which the noise beside them can be observed.
const OBSERVED_HOP: u64 = 8;

/// Converts envelopes of drive and pickup at an even rate into frames.
pub struct EnvelopeStream {
    filter: Filter,
    start_s: f64,
    channels: [Channel; 2],
    /// Lost envelopes that frames may still include.
    lost: VecDeque<u64>,
    /// Noise of the frames by that stated of the envelopes, where they are too few to show it.
    stated_noise: [f64; 2],
    count: u64,
    next_frame: u64,
}

struct Channel {
    re: Vec<f64>,
    im: Vec<f64>,
    noise: NoiseFloor,
}

impl EnvelopeStream {
    /// Begins at `start_s` with a filter of [`Filter::for_envelopes`].
    #[must_use]
    pub fn new(filter: Filter, start_s: f64) -> Self {
        let lead = filter.second.lead;
        let channel = || Channel {
            re: vec![0.0; lead],
            im: vec![0.0; lead],
            noise: NoiseFloor::new(&filter),
        };
        Self {
            start_s,
            channels: [channel(), channel()],
            lost: VecDeque::new(),
            stated_noise: [0.0; 2],
            count: 0,
            next_frame: filter.half_support().div_ceil(filter.hop()),
            filter,
        }
    }

    /// States the standard deviation of each part of both envelopes by noise, which counts where they are too few to show theirs.
    #[must_use]
    pub fn with_noise(mut self, envelope_noise: [f64; 2]) -> Self {
        // The noise of an envelope is white up to half its rate.
        let gain = self.filter.noise_gain() / std::f64::consts::SQRT_2;
        self.stated_noise = envelope_noise.map(|noise| noise * gain);
        self
    }

    /// Takes the envelopes of drive and pickup at the next instant, NaN if they were lost, and emits the frame that they complete.
    pub fn push(&mut self, envelopes: [Complex64; 2], emit: &mut impl FnMut(&EnvelopeFrame<2>)) {
        let is_lost = !envelopes.iter().all(|envelope| envelope.is_finite());
        if is_lost {
            self.lost.push_back(self.count);
        }
        for (channel, envelope) in self.channels.iter_mut().zip(envelopes) {
            let value = if is_lost { Complex64::ZERO } else { envelope };
            channel.re.push(value.re);
            channel.im.push(value.im);
        }
        self.count += 1;
        let sample = self.next_frame * self.filter.hop();
        if sample + self.filter.half_support() < self.count {
            self.emit_frame(sample, emit);
            self.next_frame += 1;
        }
    }

    fn emit_frame(&mut self, sample: u64, emit: &mut impl FnMut(&EnvelopeFrame<2>)) {
        let Self { filter, lost, .. } = self;
        let half = filter.half_support();
        while lost.front().is_some_and(|index| *index + half < sample) {
            lost.pop_front();
        }
        let is_lost = lost.front().is_some_and(|index| *index <= sample + half);
        let second = &filter.second;
        let length = second.lead + 1 + second.half;
        let mut stated_noise = self.stated_noise.into_iter();
        let envelopes = self.channels.each_mut().map(|channel| {
            let stated_noise = stated_noise.next().unwrap_or(0.0);
            // The frame is due, so its window ends at the last envelope.
            let start = channel.re.len() - length;
            let (re, im) = (&channel.re[start..], &channel.im[start..]);
            if !is_lost && filter.hop() >= OBSERVED_HOP {
                channel.noise.observe(filter, re, im);
            }
            let [value, slope_per_s, curvature_per_s2] = if is_lost {
                [Complex64::new(f64::NAN, f64::NAN); 3]
            } else {
                let taps = second.taps.each_ref().map(Vec::as_slice);
                let [re, im] = kernel::inner_products([re, im], taps);
                std::array::from_fn(|i| Complex64::new(re[i], im[i]))
            };
            let noise = match filter.hop() >= OBSERVED_HOP {
                true => channel.noise.quadrature_std(),
                false => stated_noise,
            };
            // The next frame needs none of the envelopes before its window.
            let consumed = (start + filter.hop() as usize).min(channel.re.len());
            let kept = channel.re.len() - consumed;
            if consumed > kept {
                channel.re.drain(..consumed);
                channel.im.drain(..consumed);
            }
            ChannelEnvelope {
                value,
                slope_per_s,
                curvature_per_s2,
                noise,
                clipped: 0,
                mask: if is_lost {
                    Mask::LOST_SAMPLES
                } else {
                    Mask::CLEAR
                },
            }
        });
        emit(&EnvelopeFrame {
            sample,
            time_s: self.start_s + sample as f64 / filter.sample_rate_hz(),
            envelopes,
        });
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A modulated envelope that turns slowly, and its rate of change.
    fn envelope(t: f64) -> (Complex64, Complex64) {
        let amplitude = 1.0 + 0.9 * (TAU * 6.0 * t).sin();
        let rate = 0.9 * TAU * 6.0 * (TAU * 6.0 * t).cos();
        let turn = Complex64::cis(TAU * 3.0 * t);
        let slope = rate + Complex64::I * (TAU * 3.0) * amplitude;
        (amplitude * turn, slope * turn)
    }

    fn frames(rate_hz: f64, lost: Option<u64>) -> Vec<EnvelopeFrame<2>> {
        let filter = Filter::for_envelopes(rate_hz, 35e3).unwrap();
        let mut stream = EnvelopeStream::new(filter, 0.25);
        let mut frames = Vec::new();
        for n in 0..(0.5 * rate_hz) as u64 {
            let (value, _) = envelope(0.25 + n as f64 / rate_hz);
            let value = if lost == Some(n) {
                Complex64::new(f64::NAN, 0.0)
            } else {
                value
            };
            stream.push([value, 2e-6 * value], &mut |frame| frames.push(*frame));
        }
        frames
    }

    #[test]
    fn envelopes_of_any_rate_give_value_and_slope() {
        for rate_hz in [
            1000.0, 2000.0, 2857.0, 4500.0, 10_000.0, 13_333.3, 100_000.0,
        ] {
            let frames = frames(rate_hz, None);
            let frame_rate_hz = (frames[1].time_s - frames[0].time_s).recip();
            assert!(
                (900.0..3000.0).contains(&frame_rate_hz),
                "{rate_hz}: {frame_rate_hz}"
            );
            assert!(
                frames.len() as f64 > 0.45 * frame_rate_hz,
                "{rate_hz}: {}",
                frames.len()
            );
            for frame in &frames {
                let (value, slope) = envelope(frame.time_s);
                let (drive, pickup) = (frame.drive(), frame.pickup());
                assert!((drive.value - value).norm() < 1e-5, "{rate_hz}: {frame:?}");
                assert!(
                    (drive.slope_per_s - slope).norm() < 1e-2,
                    "{rate_hz}: {frame:?}, {slope}"
                );
                assert!((pickup.value / 2e-6 - drive.value).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn a_lost_envelope_masks_the_frames_that_include_it() {
        let frames = frames(10_000.0, Some(2500));
        let is_masked = |frame: &&EnvelopeFrame<2>| frame.mask().contains(Mask::LOST_SAMPLES);
        let masked: Vec<f64> = frames
            .iter()
            .filter(is_masked)
            .map(|frame| frame.time_s)
            .collect();
        assert!((8..12).contains(&masked.len()), "{masked:?}");
        assert!(
            masked.iter().all(|time_s| (time_s - 0.5).abs() < 0.003),
            "{masked:?}"
        );
    }
}
