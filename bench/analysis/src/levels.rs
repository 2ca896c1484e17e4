//! Measures the fraction of the carrier in the signal, and the carrier's frequency.

use std::f64::consts::TAU;
use std::ops::Range;

use impedance::{CarrierLevel, Mask, ZmFrame};
use num_complex::Complex64;

use crate::flaw::{Channel, Flaw};
use crate::spans::Spans;
use recording::manifest::Manifest;

/// Ratio of the carrier's power to the rest below which the carrier counts as missing, and as weak, dB.
const MISSING_DB: f64 = 0.0;
const WEAK_DB: f64 = 15.0;
/// Offset of the carrier above which a flaw reports it, Hz: two clocks differ by less, which the demodulator
/// tolerates.
const ELSEWHERE_HZ: f64 = 10.0;

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
    pub(super) fn new(manifest: &Manifest, sample_rate_hz: u32) -> Self {
        Self {
            spans: Spans::of(manifest).samples(sample_rate_hz),
            units: [
                manifest.channels.drive.volts_per_unit,
                manifest.channels.pickup.metres_per_unit,
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
        let ended = self.spans.partition_point(|span| span.end <= first);
        let begun = self.spans[ended..].iter();
        for span in begun.take_while(|span| span.start < end) {
            let within = span.start.clamp(first, end)..span.end.clamp(first, end);
            let frames = (within.start - first) as usize * channels
                ..(within.end - first) as usize * channels;
            let inside = block.get(frames).unwrap_or_default();
            for (at, index) in indices.into_iter().enumerate() {
                let finite = inside
                    .iter()
                    .skip(index)
                    .step_by(channels)
                    .filter(|x| x.is_finite());
                for x in finite {
                    self.samples[at] += 1;
                    self.total[at] += f64::from(*x).powi(2);
                }
            }
        }
    }

    pub(super) fn take_frame(&mut self, frame: &ZmFrame) {
        let ended = |span: &Range<u64>| span.end <= frame.sample;
        let span = self.spans.get(self.spans.partition_point(ended));
        let counts = span.is_some_and(|span| span.contains(&frame.sample));
        if frame.mask.contains(Mask::LOST_SAMPLES) || !counts {
            self.rotation.before = None;
            return;
        }
        self.rotation.take(frame);
        self.frames += 1;
        let envelopes = [frame.drive_v, frame.displacement_m];
        for ((carrier, envelope), unit) in self.carrier.iter_mut().zip(envelopes).zip(self.units) {
            *carrier += (envelope / unit).norm_sqr() / 2.0;
        }
    }

    pub(super) fn flaws(&self, carrier_hz: f64) -> Vec<Flaw> {
        if self.frames == 0 {
            return Vec::new();
        }
        let mut flaws: Vec<Flaw> = [Channel::Drive, Channel::Pickup]
            .into_iter()
            .enumerate()
            .filter_map(|(at, channel)| {
                let carrier = self.carrier[at] / self.frames as f64;
                let total = self.total[at] / self.samples[at] as f64;
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
        let driven = !flaws.iter().any(|flaw| {
            matches!(
                flaw,
                Flaw::CarrierMissing {
                    channel: Channel::Drive,
                    ..
                }
            )
        });
        let offset_hz = self.rotation.offset_hz();
        if driven && offset_hz.abs() > ELSEWHERE_HZ {
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
    before: Option<ZmFrame>,
    turns: Complex64,
    frame_s: f64,
}

impl EnvelopeRotation {
    fn take(&mut self, frame: &ZmFrame) {
        if let Some(before) = self.before.replace(*frame) {
            self.turns += frame.drive_v * before.drive_v.conj();
            self.frame_s = frame.time_s - before.time_s;
        }
    }

    /// Returns the offset of the carrier, Hz; NaN with fewer than two frames.
    fn offset_hz(&self) -> f64 {
        self.turns.arg() / (TAU * self.frame_s)
    }
}
