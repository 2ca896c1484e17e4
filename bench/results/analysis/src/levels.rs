//! Measures the fraction of the carrier in the signal, and the carrier's frequency.

use std::f64::consts::TAU;
use std::ops::Range;

use impedance::{CarrierLevel, Mask, ZmFrame};
use num_complex::Complex64;

use crate::flaw::{Channel, Flaw};
use crate::spans::Spans;
use crate::vibration::Vibration;
use recording::manifest::{Manifest, RecordedChannels};

/// Ratio of the carrier's power to the rest below which the carrier counts as missing, and as weak, dB.
const MISSING_DB: f64 = 0.0;
const WEAK_DB: f64 = 15.0;
/// Offset of the carrier above which a flaw reports it, Hz: two clocks differ by less, which the demodulator
/// tolerates.
const REPORTED_OFFSET_HZ: f64 = 10.0;

/// Carrier and total power in both channels over the recording's intervals.
pub(super) struct Levels {
    spans: Vec<Range<u64>>,
    /// Voltage and displacement of a sample value of 1, V and m.
    units: [f64; 2],
    samples: [u64; 2],
    total: [f64; 2],
    frames: u64,
    carrier: [f64; 2],
    rotation: EnvelopeRotation,
}

impl Levels {
    pub(super) fn new(manifest: &Manifest, channels: &RecordedChannels, rate_hz: f64) -> Self {
        Self {
            spans: Spans::new(manifest).samples(rate_hz),
            units: [
                channels.drive.volts_per_unit,
                channels.pickup.metres_per_unit,
            ],
            samples: [0; 2],
            total: [0.0; 2],
            frames: 0,
            carrier: [0.0; 2],
            rotation: EnvelopeRotation::default(),
        }
    }

    pub(super) fn take(&mut self, first: u64, block: &[f32], channels: usize, indices: [usize; 2]) {
        let end = first + (block.len() / channels) as u64;
        let ended_count = self.spans.partition_point(|span| span.end <= first);
        let remaining_spans = self.spans[ended_count..].iter();
        for span in remaining_spans.take_while(|span| span.start < end) {
            let overlap = span.start.clamp(first, end)..span.end.clamp(first, end);
            let frames = (overlap.start - first) as usize * channels
                ..(overlap.end - first) as usize * channels;
            let overlap_samples = block.get(frames).unwrap_or_default();
            for (channel, index) in indices.into_iter().enumerate() {
                let finite_values = overlap_samples
                    .iter()
                    .skip(index)
                    .step_by(channels)
                    .filter(|x| x.is_finite());
                for x in finite_values {
                    self.samples[channel] += 1;
                    self.total[channel] += f64::from(*x).powi(2);
                }
            }
        }
    }

    pub(super) fn take_frame(&mut self, frame: &ZmFrame) {
        let has_ended = |span: &Range<u64>| span.end <= frame.sample;
        let span = self.spans.get(self.spans.partition_point(has_ended));
        let is_counted = span.is_some_and(|span| span.contains(&frame.sample));
        if frame.mask.contains(Mask::LOST_SAMPLES) || !is_counted {
            self.rotation.previous_frame = None;
            return;
        }
        self.rotation.take(frame);
        self.frames += 1;
        let envelopes = [frame.drive_v, frame.displacement_m];
        for ((carrier, envelope), unit) in self.carrier.iter_mut().zip(envelopes).zip(self.units) {
            *carrier += (envelope / unit).norm_sqr() / 2.0;
        }
    }

    /// Returns the flaws of the carrier; one that moves is followed.
    pub(super) fn flaws(&self, vibration: &Vibration) -> Vec<Flaw> {
        let carrier_hz = vibration.carrier_hz;
        if self.frames == 0 {
            return Vec::new();
        }
        let mut flaws: Vec<Flaw> = [Channel::Drive, Channel::Pickup]
            .into_iter()
            .enumerate()
            .filter_map(|(index, channel)| {
                // A counted frame lacks no sample in either channel, so that both have finite ones.
                let carrier = self.carrier[index] / self.frames as f64;
                let total = self.total[index] / self.samples[index] as f64;
                let level = CarrierLevel {
                    amplitude: (2.0 * carrier).sqrt(),
                    rest_rms: (total - carrier).max(0.0).sqrt(),
                };
                let ratio_db = level.ratio_db();
                if ratio_db < MISSING_DB {
                    Some(Flaw::CarrierMissing {
                        channel,
                        carrier_hz,
                        ratio_db,
                    })
                } else {
                    (ratio_db < WEAK_DB).then_some(Flaw::CarrierWeak { channel, ratio_db })
                }
            })
            .collect();
        let is_driven = !flaws.iter().any(|flaw| {
            matches!(
                flaw,
                Flaw::CarrierMissing {
                    channel: Channel::Drive,
                    ..
                }
            )
        });
        let offset_hz = self.rotation.offset_hz();
        if is_driven && !vibration.moves && offset_hz.abs() > REPORTED_OFFSET_HZ {
            flaws.push(Flaw::CarrierElsewhere {
                measured_hz: carrier_hz + offset_hz,
                stated_hz: carrier_hz,
            });
        }
        flaws
    }
}

/// Rotation of the drive's envelope, due to the offset of its carrier from the stated frequency. A rotation common to
/// drive and pickup leaves Z_m unchanged.
#[derive(Default)]
struct EnvelopeRotation {
    previous_frame: Option<ZmFrame>,
    turns: Complex64,
    frame_s: f64,
}

impl EnvelopeRotation {
    fn take(&mut self, frame: &ZmFrame) {
        if let Some(previous) = self.previous_frame.replace(*frame) {
            self.turns += frame.drive_v * previous.drive_v.conj();
            self.frame_s = frame.time_s - previous.time_s;
        }
    }

    /// Returns the offset of the carrier, Hz; NaN with fewer than two frames.
    fn offset_hz(&self) -> f64 {
        self.turns.arg() / (TAU * self.frame_s)
    }
}
