//! Streaming IQ demodulation of several channels with a common filter.

use crate::filter::Filter;
use crate::flaws::{ChannelFlaws, Flaws};
use crate::kernel::{self, Deinterleave, MixAndDecimate};
use crate::mask::Mask;
use crate::noise::NoiseFloor;
use num_complex::Complex64;

/// Samples processed at a time, so that memory does not grow with the caller's blocks.
const CHUNK: usize = 4096;

/// One channel of the interleaved stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputChannel {
    /// Index of the channel in the interleaved frame, from 0.
    pub channel: usize,
    /// Magnitude from which on a sample counts as clipped, in sample units: just under 1 for a sound card, infinite
    /// for a recording in volts with an unknown range.
    pub clip_level: f32,
}

/// Complex envelope X̃ of a channel at one instant: x(t) = Re[X̃ exp(+iωt)], peak amplitude, phase relative to sample 0
/// of the stream. NaN where `mask` indicates lost samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelEnvelope {
    /// X̃ in sample units.
    pub value: Complex64,
    /// dX̃/dt in sample units per second.
    pub slope_per_s: Complex64,
    /// d²X̃/dt² in sample units per second squared.
    pub curvature_per_s2: Complex64,
    /// Standard deviation of each quadrature of `value` from noise, in sample units, estimated 4 and 6 kHz (at 2 kHz
    /// output) to either side of the carrier over the last half second. It is the median of the four averages, so that a single
    /// foreign tone is not taken for noise. Infinite before the first estimate.
    pub noise: f64,
    /// Samples at or above the clip level within the filter's window.
    pub clipped: u32,
    /// [`Mask::LOST_SAMPLES`] and [`Mask::CLIPPED`] for this channel.
    pub mask: Mask,
}

/// The envelopes of `N` channels at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvelopeFrame<const N: usize> {
    /// Sample of the stream at the window's centre, the instant of the envelopes.
    pub sample: u64,
    /// Time of that sample, s.
    pub time_s: f64,
    /// Envelopes, in the order of the inputs.
    pub envelopes: [ChannelEnvelope; N],
}

impl<const N: usize> EnvelopeFrame<N> {
    /// Returns the combined reasons of all channels.
    #[must_use]
    pub fn mask(&self) -> Mask {
        self.envelopes
            .iter()
            .fold(Mask::CLEAR, |mask, e| mask | e.mask)
    }
}

impl EnvelopeFrame<2> {
    /// Returns the drive voltage's envelope in a frame of [`Demodulator::drive_and_pickup`].
    #[must_use]
    pub fn drive(&self) -> &ChannelEnvelope {
        &self.envelopes[0]
    }

    /// Returns the pickup's envelope in a frame of [`Demodulator::drive_and_pickup`].
    #[must_use]
    pub fn pickup(&self) -> &ChannelEnvelope {
        &self.envelopes[1]
    }
}

/// Reasons why a stream cannot be demodulated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DemodulatorError {
    /// An input names a channel that the stream does not have.
    #[error("channel {channel} does not exist: the stream has {stream_channels}")]
    NoSuchChannel {
        /// Requested channel, from 0.
        channel: usize,
        /// Channels in the stream.
        stream_channels: usize,
    },
    /// The clip level is not positive.
    #[error("clip level {clip_level} of channel {channel} is not above 0")]
    ClipLevel {
        /// Requested channel.
        channel: usize,
        /// Requested level.
        clip_level: f32,
    },
    /// A block ends in the middle of a frame.
    #[error(
        "a block of {samples} samples is not a whole number of frames of {stream_channels} channels"
    )]
    TornBlock {
        /// Samples in the block.
        samples: usize,
        /// Channels in the stream.
        stream_channels: usize,
    },
}

/// Demodulates `N` channels of an interleaved stream, block by block, into frames at the output rate.
///
/// A frame is emitted for each multiple of the hop with its whole window in the stream. The result does not depend on
/// the division of the stream into blocks. A NaN or infinite sample invalidates only the frames with a window that includes
/// it.
///
/// Measured (`tests/integration/demodulation.rs`): envelopes to 1e-6 of full scale from f32 samples, slopes to 2e-5, curvatures to
/// 3e-4 of those of a 90 Hz sideband. `benches/demodulate.rs` compares its speed with a plain lock-in.
///
/// ```
/// use impedance::{Demodulator, Filter, FilterSettings, InputChannel};
/// use std::f64::consts::TAU;
///
/// let filter = Filter::new(FilterSettings {
///     sample_rate_hz: 192_000,
///     carrier_hz: 35e3,
///     output_rate_hz: 2000,
/// })?;
/// let tone: Vec<f32> = (0..19_200)
///     .map(|n| (0.5 * (TAU * 35e3 * f64::from(n) / 192e3).cos()) as f32)
///     .collect();
/// let input = InputChannel { channel: 0, clip_level: 0.999 };
/// let mut demodulator = Demodulator::new(filter, 1, [input])?;
/// let mut amplitudes = Vec::new();
/// demodulator.push(&tone, |frame| amplitudes.push(frame.envelopes[0].value.norm()))?;
/// assert!(amplitudes.iter().all(|amplitude| (amplitude - 0.5).abs() < 1e-6));
/// # assert!(amplitudes.len() > 180);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Demodulator<const N: usize> {
    filter: Filter,
    stream_channels: usize,
    inputs: [InputChannel; N],
    channels: [ChannelState; N],
    /// Samples taken so far.
    sample_count: u64,
    /// First-stage outputs computed so far; output j is centred on sample j·decimation.
    mixed: u64,
    /// The next frame, in hops.
    next_frame: u64,
}

#[derive(Clone, Debug)]
struct ChannelState {
    /// Samples not yet consumed by the first stage; lost ones are zero here and recorded in `flaws`.
    samples: Vec<f64>,
    /// First-stage outputs, rotated to phase 0 of the stream, not yet consumed by the second.
    re: Vec<f64>,
    im: Vec<f64>,
    flaws: Flaws,
    noise: NoiseFloor,
}

impl Demodulator<2> {
    /// Creates a demodulator of the drive voltage and the pickup, in this order for any channel indices.
    ///
    /// # Errors
    /// Same as [`Demodulator::new`].
    pub fn drive_and_pickup(
        filter: Filter,
        stream_channels: usize,
        drive: InputChannel,
        pickup: InputChannel,
    ) -> Result<Self, DemodulatorError> {
        Self::new(filter, stream_channels, [drive, pickup])
    }
}

impl<const N: usize> Demodulator<N> {
    /// Creates a demodulator of `inputs`, channels of a stream of `stream_channels` interleaved ones.
    ///
    /// # Errors
    /// When an input's channel does not exist or its clip level is not positive.
    pub fn new(
        filter: Filter,
        stream_channels: usize,
        inputs: [InputChannel; N],
    ) -> Result<Self, DemodulatorError> {
        const { assert!(N > 0, "a demodulator needs an input") };
        for InputChannel {
            channel,
            clip_level,
        } in inputs
        {
            if channel >= stream_channels {
                return Err(DemodulatorError::NoSuchChannel {
                    channel,
                    stream_channels,
                });
            }
            if clip_level.is_nan() || clip_level <= 0.0 {
                return Err(DemodulatorError::ClipLevel {
                    channel,
                    clip_level,
                });
            }
        }
        let channel = ChannelState {
            // Silence before the stream lets both stages start at sample 0; no frame's window includes it except with
            // taps of 0.
            samples: vec![0.0; filter.first.lead],
            re: vec![0.0; filter.second.lead],
            im: vec![0.0; filter.second.lead],
            flaws: Flaws::default(),
            noise: NoiseFloor::new(&filter),
        };
        Ok(Self {
            stream_channels,
            inputs,
            channels: std::array::from_fn(|_| channel.clone()),
            sample_count: 0,
            mixed: 0,
            next_frame: filter.half_support().div_ceil(filter.hop()),
            filter,
        })
    }

    /// Returns the filter common to all channels.
    #[must_use]
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// Returns the number of samples per channel taken so far: the index of the next block's first sample.
    #[must_use]
    pub fn samples_taken(&self) -> u64 {
        self.sample_count
    }

    /// Returns the flawed samples taken since the last call, in the order of the inputs.
    pub fn take_flaws(&mut self) -> [ChannelFlaws; N] {
        self.channels
            .each_mut()
            .map(|channel| channel.flaws.take_fresh())
    }

    /// Demodulates a block of any length and emits the frames that it completes, in order.
    ///
    /// # Errors
    /// When the block does not hold whole frames; it is then ignored.
    pub fn push(
        &mut self,
        interleaved: &[f32],
        mut emit: impl FnMut(&EnvelopeFrame<N>),
    ) -> Result<(), DemodulatorError> {
        if !interleaved.len().is_multiple_of(self.stream_channels) {
            return Err(DemodulatorError::TornBlock {
                samples: interleaved.len(),
                stream_channels: self.stream_channels,
            });
        }
        for chunk in interleaved.chunks(CHUNK * self.stream_channels) {
            for (channel, input) in self.channels.iter_mut().zip(self.inputs) {
                channel.take(chunk, self.stream_channels, input, self.sample_count);
            }
            self.sample_count += (chunk.len() / self.stream_channels) as u64;
            self.mix();
            self.emit_frames(&mut emit);
        }
        Ok(())
    }

    /// Runs the first stage as far as the samples reach.
    fn mix(&mut self) {
        let first = &self.filter.first;
        let per_hop = self.filter.second.decimation as u64;
        let available = self.channels.first().map_or(0, |c| c.samples.len());
        let length = first.re.len();
        if available < length {
            return;
        }
        let outputs = (available - length) / first.decimation + 1;
        for channel in &mut self.channels {
            let start = channel.re.len();
            channel.re.resize(start + outputs, 0.0);
            channel.im.resize(start + outputs, 0.0);
            MixAndDecimate {
                samples: &channel.samples,
                step: first.decimation,
                taps: [&first.re, &first.im],
                outputs: [&mut channel.re[start..], &mut channel.im[start..]],
            }
            .run();
            channel.samples.drain(..outputs * first.decimation);
        }

        // The taps turn each window relative to its own centre j·d (d the decimation): Σ g₁(n) x(jd + n) e^{−iωn} is still
        // turned by e^{+iωjd}. The factor e^{−iωjd} = e^{−iω·hop·⌊j/J⌋} e^{−iωd·(j mod J)}, J outputs per hop, refers it to
        // sample 0.
        let hop = self.filter.hop();
        let mut j = 0;
        while j < outputs {
            let index = self.mixed + j as u64;
            let turned = self.filter.phase.rotation_at(index / per_hop * hop).conj();
            let offset = (index % per_hop) as usize;
            let run = (outputs - j).min(per_hop as usize - offset);
            let fine = offset..offset + run;
            for channel in &mut self.channels {
                let run_start = channel.re.len() - outputs + j;
                kernel::rotate(
                    &mut channel.re[run_start..run_start + run],
                    &mut channel.im[run_start..run_start + run],
                    &first.rotation_re[fine.clone()],
                    &first.rotation_im[fine.clone()],
                    turned,
                );
            }
            j += run;
        }
        self.mixed += outputs as u64;
    }

    /// Runs the second stage as far as the first one's outputs reach.
    fn emit_frames(&mut self, emit: &mut impl FnMut(&EnvelopeFrame<N>)) {
        let second = &self.filter.second;
        let (half, decimation) = (second.half as u64, second.decimation as u64);
        let stored = self.channels.first().map_or(0, |c| c.re.len());
        // Start of a frame's window in the stored outputs. Add before subtracting, because the window of frame 0 starts
        // before output 0.
        let window_start = |frame: u64| {
            (frame * decimation + stored as u64 - second.lead as u64 - self.mixed) as usize
        };
        while self.next_frame * decimation + half < self.mixed {
            let sample = self.next_frame * self.filter.hop();
            let start = window_start(self.next_frame);
            let window = start..start + second.lead + 1 + second.half;
            let envelopes = self
                .channels
                .each_mut()
                .map(|channel| channel.envelope(&self.filter, sample, window.clone()));
            emit(&EnvelopeFrame {
                sample,
                time_s: sample as f64 / self.filter.sample_rate_hz(),
                envelopes,
            });
            self.next_frame += 1;
        }
        let consumed = window_start(self.next_frame).min(stored);
        let next_sample = self.next_frame * self.filter.hop();
        for channel in &mut self.channels {
            channel.re.drain(..consumed);
            channel.im.drain(..consumed);
            let first_touched = next_sample.saturating_sub(self.filter.half_support());
            channel.flaws.drop_before(first_touched);
        }
    }
}

impl ChannelState {
    /// Deinterleaves the samples and records lost and clipped ones.
    fn take(&mut self, chunk: &[f32], stride: usize, input: InputChannel, first_sample: u64) {
        let start = self.samples.len();
        let sound = Deinterleave {
            interleaved: chunk,
            stride,
            channel: input.channel,
            level: input.clip_level,
            column: &mut self.samples,
        }
        .run();
        if sound {
            return;
        }
        let level = f64::from(input.clip_level);
        for (sample, x) in (first_sample..).zip(&mut self.samples[start..]) {
            if !x.is_finite() {
                self.flaws.note_lost(sample);
                *x = 0.0;
            } else if x.abs() >= level {
                self.flaws.note_clipped(sample);
            }
        }
    }

    fn envelope(
        &mut self,
        filter: &Filter,
        sample: u64,
        window: std::ops::Range<usize>,
    ) -> ChannelEnvelope {
        let support = sample - filter.half_support()..sample + filter.half_support() + 1;
        let lost = self.flaws.lost_within(&support);
        let clipped = self.flaws.clipped_within(&support);
        let mut mask = Mask::CLEAR;
        if lost {
            mask |= Mask::LOST_SAMPLES;
        }
        if clipped > 0 {
            mask |= Mask::CLIPPED;
        }
        let (re, im) = (&self.re[window.clone()], &self.im[window]);
        if mask.is_clear() {
            self.noise.observe(filter, re, im);
        }
        let [value, slope_per_s, curvature_per_s2] = if lost {
            [Complex64::new(f64::NAN, f64::NAN); 3]
        } else {
            let taps = filter.second.taps.each_ref().map(Vec::as_slice);
            let [re, im] = kernel::inner_products([re, im], taps);
            std::array::from_fn(|i| Complex64::new(re[i], im[i]))
        };
        ChannelEnvelope {
            value,
            slope_per_s,
            curvature_per_s2,
            noise: self.noise.quadrature_std(),
            clipped,
            mask,
        }
    }
}
