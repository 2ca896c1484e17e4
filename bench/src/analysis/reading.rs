//! A recording folder through the same demodulator as live, in a stream: only its 2 kHz frames are held.

use std::f64::consts::TAU;
use std::fmt;
use std::ops::Range;
use std::path::Path;

use impedance::{CarrierLevel, Mask, ZmFrame};
use num_complex::Complex64;

use super::analysed::RecordingError;
use super::record::Record;
use super::unloaded::UnloadedError;
use crate::pipeline::{PickupOffset, Pipeline, RecordedError, Unstated};
use crate::recording::manifest::Manifest;
use crate::recording::reader::{self, ReadError, RecordingReader};

/// Frames of audio read at a time.
const BLOCK_FRAMES: usize = 16_384;
/// Below this the carrier is not in the signal; below the other it is told of. Carrier power over that of all else, dB.
const MISSING_DB: f64 = 0.0;
const WEAK_DB: f64 = 15.0;
/// A carrier farther from where it should be is told of: two clocks differ by less, and the demodulator does not care.
const ELSEWHERE_HZ: f64 = 10.0;

/// Which of the two channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Channel {
    /// Actuator voltage.
    Drive,
    /// Plate displacement.
    Pickup,
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Drive => "drive",
            Self::Pickup => "pickup",
        })
    }
}

/// What is wrong with a recording that can be analysed nevertheless, wholly or in part.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Flaw {
    /// In its files.
    #[error(transparent)]
    File(#[from] reader::Warning),
    /// Samples that are NaN or infinite.
    #[error("{channel}: {samples} samples are NaN or infinite; what they touch is left out")]
    LostSamples {
        /// Of which channel.
        channel: Channel,
        /// Their number.
        samples: u64,
    },
    /// The converter's limit was reached.
    #[error(
        "{channel} clipped: {samples} samples at ±{level} of full scale; what they touch is left out"
    )]
    Clipped {
        /// Which channel.
        channel: Channel,
        /// Samples at the limit.
        samples: u64,
        /// The limit, in sample values.
        level: f32,
    },
    /// Nothing to demodulate.
    #[error(
        "{channel}: the carrier of {carrier_hz} Hz is not in the signal ({ratio_db:.0} dB of all else)"
    )]
    CarrierMissing {
        /// In which channel.
        channel: Channel,
        /// The carrier, Hz.
        carrier_hz: f64,
        /// Its power over that of the rest, dB.
        ratio_db: f64,
    },
    /// Much besides the carrier: DC, hum, foreign tones, noise.
    #[error("{channel}: the carrier is only {ratio_db:.0} dB above all else in the signal")]
    CarrierWeak {
        /// In which channel.
        channel: Channel,
        /// Its power over that of the rest, dB.
        ratio_db: f64,
    },
    /// The drive's carrier is elsewhere than stated.
    #[error(
        "drive: the carrier is at {measured_hz:.1} Hz, not at {stated_hz} Hz as recording.toml says; farther than 300 Hz away the amplitude would read low"
    )]
    CarrierElsewhere {
        /// Where it is, Hz.
        measured_hz: f64,
        /// Where it should be, Hz.
        stated_hz: f64,
    },
    /// No Z_p.
    #[error(transparent)]
    Unloaded(#[from] UnloadedError),
    /// A finger during part of the unloaded interval.
    #[error(
        "finger on the plate during {touched_s:.2} s of the unloaded interval, which are left out"
    )]
    Touched {
        /// How long, s.
        touched_s: f64,
    },
    /// The unloaded plate's impedance changes.
    #[error(
        "the unloaded plate's impedance scatters by {scatter_n_s_per_m:.2} N·s/m: was a finger on it?"
    )]
    PlateScatters {
        /// RMS about the mean, N·s/m.
        scatter_n_s_per_m: f64,
    },
    /// The pickup's phase is not what is stated.
    #[error(
        "pickup: the unloaded plate answers to the modulation as with phase_rad = {found_rad:.3}, but recording.toml states {stated_rad:.3}; analysed with what was found: state it, or look for a swapped or delayed channel"
    )]
    PickupPhase {
        /// As stated, rad.
        stated_rad: f64,
        /// As the plate tells, rad.
        found_rad: f64,
    },
    /// The pickup's envelope is not that of the same moment as the drive's.
    #[error(
        "pickup: the unloaded plate answers to the modulation as if the pickup were {:+.0} µs late; analysed with that: look for a filter or a delay in its channel, and whether modal_mass_kg and the scales of both channels hold",
        delay_s * 1e6
    )]
    PickupLate {
        /// How late, s.
        delay_s: f64,
    },
    /// The unloaded plate is not as heavy as stated, or the pickup later than any channel is.
    #[error(
        "the unloaded plate answers to the modulation as if its modal mass were {mass_ratio:.3} times the stated one, or the pickup {:+.2} ms late; analysed as stated: check volts_per_unit, force_factor_n_per_v, metres_per_unit (peak, not peak to peak or RMS), modal_mass_kg, and whether the channels are swapped or not aligned",
        delay_s * 1e3
    )]
    PlateMass {
        /// Modal mass as the plate shows it, of the stated one.
        mass_ratio: f64,
        /// The delay that would look the same, s.
        delay_s: f64,
    },
    /// The unloaded plate's impedance is out of its phase, and so is the pickup or the resonance.
    #[error(
        "the unloaded plate's impedance is {z_p_n_s_per_m:.2} N·s/m, but carrier_hz, resonance_hz and modal_mass_kg make its imaginary part {expected_im_n_s_per_m:+.2}: check the pickup's phase_rad, and the resonance"
    )]
    PlateReactance {
        /// Z_p as read, N·s/m.
        z_p_n_s_per_m: Complex64,
        /// ω m_p − k_p/ω, N·s/m.
        expected_im_n_s_per_m: f64,
    },
    /// The resonance is elsewhere than stated.
    #[error(
        "the plate's resonance is at {measured_hz:.0} Hz by the unloaded plate's impedance, not at {stated_hz} Hz as recording.toml says; Z_p is read with the plate as it was"
    )]
    ResonanceElsewhere {
        /// Where it is, Hz.
        measured_hz: f64,
        /// Where it should be, Hz.
        stated_hz: f64,
    },
    /// The model does not describe what was measured.
    #[error(
        "with the parameters of the first instance, the self-sensed normal force is {:.0} % off the measured one (90th percentile) at amplitudes of {:.1} to {:.1} µm: the model does not hold for this recording, or something in it changed on the way",
        difference * 100.0, amplitude_from_m * 1e6, amplitude_to_m * 1e6
    )]
    ModelParts {
        /// 90th percentile of |self-sensed − measured|/measured in the worst band.
        difference: f64,
        /// The band's amplitudes, from, m.
        amplitude_from_m: f64,
        /// To, m.
        amplitude_to_m: f64,
    },
    /// No exploration to analyse.
    #[error("no exploration interval")]
    NoExploration,
}

/// A recording in memory.
#[derive(Debug)]
pub struct Reading {
    /// What it is of.
    pub manifest: Manifest,
    /// Impedance, force and position.
    pub record: Record,
    /// What is wrong with it.
    pub flaws: Vec<Flaw>,
}

impl Reading {
    /// Whether there is nothing to demodulate.
    pub fn carrier_missing(&self) -> bool {
        let missing = |flaw: &Flaw| matches!(flaw, Flaw::CarrierMissing { .. });
        self.flaws.iter().any(missing)
    }
}

/// Reads a recording folder, with the pickup as stated but for its offset. The audio is read twice: first for the level at which it clips.
///
/// # Errors
/// A file cannot be read, or the audio cannot be demodulated as the manifest says.
pub fn read(folder: &Path, pickup: PickupOffset) -> Result<Reading, RecordingError> {
    let mut reader = RecordingReader::open(folder)?;
    let channels = usize::from(reader.format().channels);
    let manifest = reader.manifest().clone();
    let drive = usize::from(manifest.channels.drive.index);
    let piezo = usize::from(manifest.channels.pickup.index);
    let indices = [(Channel::Drive, drive), (Channel::Pickup, piezo)];

    let mut extremes = [Extremes::default(), Extremes::default()];
    let mut block = Vec::new();
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        for (extremes, (_, index)) in extremes.iter_mut().zip(indices) {
            block
                .iter()
                .skip(index)
                .step_by(channels)
                .for_each(|&x| extremes.take(x));
        }
    }
    let mut flaws: Vec<Flaw> = reader.warnings().iter().cloned().map(Flaw::from).collect();
    let mut unstated = Unstated {
        pickup,
        ..Unstated::default()
    };
    let levels = extremes.iter().zip(&mut unstated.clip_levels);
    for ((extremes, level), (channel, _)) in levels.zip(indices) {
        if extremes.lost > 0 {
            flaws.push(Flaw::LostSamples {
                channel,
                samples: extremes.lost,
            });
        }
        if let Some((samples, at)) = extremes.clipped() {
            *level = at;
            flaws.push(Flaw::Clipped {
                channel,
                samples,
                level: at,
            });
        }
    }

    let mut reader = RecordingReader::open(folder)?;
    let mut pipeline = Pipeline::of_recording_seen(&manifest, reader.format(), &unstated)?;
    let mut levels = Levels::new(&manifest, reader.format().sample_rate_hz);
    let mut record = Record::default();
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        let (first, before) = (pipeline.account().frames, record.frames.len());
        levels.take(first, &block, channels, [drive, piezo]);
        pipeline
            .take(&block, &mut record.frames)
            .map_err(RecordedError::from)?;
        for frame in &record.frames[before..] {
            levels.take_frame(frame);
        }
    }
    flaws.extend(levels.flaws(manifest.carrier_hz));

    let mut force = reader.force()?;
    record.force = force.by_ref().collect::<Result<_, ReadError>>()?;
    flaws.extend(force.warnings().into_iter().map(Flaw::from));
    let mut position = reader.position()?;
    record.position = position.by_ref().collect::<Result<_, ReadError>>()?;
    flaws.extend(position.warnings().into_iter().map(Flaw::from));
    record.saturated = manifest.saturated_s(reader.format().sample_rate_hz);
    Ok(Reading {
        manifest,
        record,
        flaws,
    })
}

/// The greatest and least sample values and how often they occur.
#[derive(Debug, Default)]
struct Extremes {
    lost: u64,
    top: Extreme,
    bottom: Extreme,
}

/// The greatest value so far, how often it occurred, and how often something just under it did.
#[derive(Debug, Default)]
struct Extreme {
    value: f32,
    at: u64,
    near: u64,
}

/// What counts as just under the greatest value.
const NEAR: f32 = 0.999;
/// A wave that is cut off stays on its greatest value at least this often, and this many times as often as just under it.
const LEAST_CUT: u64 = 16;
const CUT_RATIO: u64 = 4;

impl Extreme {
    fn take(&mut self, value: f32) {
        if value > self.value {
            self.near = if self.value > NEAR * value {
                self.near + self.at
            } else {
                0
            };
            (self.value, self.at) = (value, 1);
        } else if value == self.value {
            self.at += 1;
        } else if value > NEAR * self.value {
            self.near += 1;
        }
    }

    fn is_cut(&self) -> bool {
        self.value > 0.0 && self.at >= LEAST_CUT && self.at > CUT_RATIO * self.near
    }
}

impl Extremes {
    fn take(&mut self, value: f32) {
        if value.is_finite() {
            self.top.take(value);
            self.bottom.take(-value);
        } else {
            self.lost += 1;
        }
    }

    /// How many samples are cut off, and at which magnitude.
    fn clipped(&self) -> Option<(u64, f32)> {
        let cut = [&self.top, &self.bottom].into_iter().filter(|e| e.is_cut());
        cut.map(|extreme| (extreme.at, extreme.value))
            .reduce(|a, b| (a.0 + b.0, a.1.min(b.1)))
    }
}

/// Carrier and total power in both channels over the recording's intervals.
struct Levels {
    spans: Vec<Range<u64>>,
    /// What a sample value of 1 stands for, V and m.
    units: [f64; 2],
    samples: [u64; 2],
    total: [f64; 2],
    frames: u64,
    carrier: [f64; 2],
    turning: Turning,
}

impl Levels {
    fn new(manifest: &Manifest, sample_rate_hz: u32) -> Self {
        let sample = |time_s: f64| (time_s * f64::from(sample_rate_hz)) as u64;
        let spans = manifest
            .intervals
            .iter()
            .map(|interval| sample(interval.start_s)..sample(interval.end_s));
        Self {
            spans: spans.collect(),
            units: [
                manifest.channels.drive.volts_per_unit,
                manifest.channels.pickup.metres_per_unit,
            ],
            samples: [0; 2],
            total: [0.0; 2],
            frames: 0,
            carrier: [0.0; 2],
            turning: Turning::default(),
        }
    }

    fn take(&mut self, first: u64, block: &[f32], channels: usize, indices: [usize; 2]) {
        let end = first + (block.len() / channels) as u64;
        for span in &self.spans {
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

    fn take_frame(&mut self, frame: &ZmFrame) {
        let counts = |span: &Range<u64>| span.contains(&frame.sample);
        if frame.mask.contains(Mask::LOST_SAMPLES) || !self.spans.iter().any(counts) {
            self.turning.before = None;
            return;
        }
        self.turning.take(frame);
        self.frames += 1;
        let envelopes = [frame.drive_v, frame.displacement_m];
        for ((carrier, envelope), unit) in self.carrier.iter_mut().zip(envelopes).zip(self.units) {
            *carrier += (envelope / unit).norm_sqr() / 2.0;
        }
    }

    fn flaws(&self, carrier_hz: f64) -> Vec<Flaw> {
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
        let offset_hz = self.turning.offset_hz();
        if driven && offset_hz.abs() > ELSEWHERE_HZ {
            flaws.push(Flaw::CarrierElsewhere {
                measured_hz: carrier_hz + offset_hz,
                stated_hz: carrier_hz,
            });
        }
        flaws
    }
}

/// How fast the drive's envelope turns: so far is its carrier from where it should be. A rotation common to drive and pickup
/// leaves Z_m as it is.
#[derive(Default)]
struct Turning {
    before: Option<ZmFrame>,
    turns: Complex64,
    frame_s: f64,
}

impl Turning {
    fn take(&mut self, frame: &ZmFrame) {
        if let Some(before) = self.before.replace(*frame) {
            self.turns += frame.drive_v * before.drive_v.conj();
            self.frame_s = frame.time_s - before.time_s;
        }
    }

    /// NaN of fewer than two frames.
    fn offset_hz(&self) -> f64 {
        self.turns.arg() / (TAU * self.frame_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extremes(values: impl Iterator<Item = f64>) -> Extremes {
        let mut extremes = Extremes::default();
        values.for_each(|x| extremes.take(x as f32));
        extremes
    }

    /// 35 kHz under 6 Hz modulation at 192 kHz.
    fn wave() -> impl Iterator<Item = f64> {
        (0..192_000).map(|i| {
            let t = f64::from(i) / 192e3;
            let envelope = 1.0 + 0.95 * (TAU * 6.0 * t).sin();
            0.4 * envelope * (TAU * 35e3 * t).cos()
        })
    }

    #[test]
    fn a_wave_that_is_cut_off_is_told_from_one_that_is_not() {
        assert_eq!(extremes(wave()).clipped(), None);
        // Of 16 bits, where the crest falls on one code for a while.
        assert_eq!(
            extremes(wave().map(|x| (x * 32768.0).round() / 32768.0)).clipped(),
            None
        );
        let (samples, level) = extremes(wave().map(|x| x.clamp(-0.7, 0.7)))
            .clipped()
            .unwrap();
        assert_eq!(level, 0.7);
        assert!(samples > 1000, "{samples}");
        // One side alone, as with DC.
        let (_, level) = extremes(wave().map(|x| (x + 0.1).min(0.8)))
            .clipped()
            .unwrap();
        assert_eq!(level, 0.8);
    }
}
