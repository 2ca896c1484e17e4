//! Envelopes of an archive: demodulated samples, rounded well below their noise.

use std::path::Path;

use analysis::findings::RecordingError;
use analysis::flaw::{Channel, Flaw};
use envelope_files::{EnvelopeRow, EnvelopeWriter};
use impedance::{ChannelEnvelope, Demodulator, EnvelopeFrame, samples_per_frame};
use num_complex::Complex64;
use recording::RecordingReader;
use recording::manifest::RecordedChannels;
use recording::pipeline::{DemodulationError, SignalProperties, envelope_demodulator};
use statistics::median;

use crate::archive_error::ArchiveError;
use crate::rounding::{binary_step, rounded};

/// Frames of audio read at a time.
const BLOCK_FRAMES: usize = 16_384;
/// Fewest envelopes per frame of an analysis: its filter then is the last one, and the archive's is flat where it passes.
const LEAST_PER_FRAME: u32 = 2;
/// Fewest samples per envelope.
const LEAST_HOP: u32 = 8;
/// Time from which the noise is read, s.
const NOISE_S: f64 = 10.0;
/// Distance from the carrier, in rates of the envelopes, up to which their filter is flat.
const FLAT: f64 = 0.15;

/// Envelopes of a recording in a file.
#[derive(Debug)]
pub(crate) struct WrittenEnvelopes {
    pub(crate) rows: u64,
    pub(crate) rate_hz: f64,
    pub(crate) flat_hz: f64,
    pub(crate) rejected_hz: f64,
    /// Standard deviations of drive, V, and pickup, m; 0 if they are not known.
    pub(crate) noise: [f64; 2],
}

/// Writes the envelopes of a recording with samples of these flaws.
pub(crate) fn write(
    source: &Path,
    flaws: &[Flaw],
    target: &Path,
) -> Result<WrittenEnvelopes, ArchiveError> {
    let noise = noise(source, flaws)?;
    let frame_samples = FrameSamples::at(RecordingReader::open(source)?.rate_hz());
    let steps = noise.map(binary_step);
    let mut writer = EnvelopeWriter::create_small(target)?;
    let mut written = Ok(());
    let mut rows = 0;
    let mut pending = Vec::new();
    let filter = demodulate(source, flaws, f64::INFINITY, |scales, frame| {
        // Between two frames of the samples, an analysis would read the noise at other instants, and other errors from it.
        if rows == 0 && frame.sample % u64::from(frame_samples.total()) != 0 {
            return;
        }
        let [drive, pickup] = [frame.drive(), frame.pickup()];
        pending.push(EnvelopeRow {
            time_s: frame.time_s,
            drive_v: value(drive, scales[0], steps[0]),
            pickup_m: value(pickup, scales[1], steps[1]),
        });
        rows += 1;
        if pending.len() >= BLOCK_FRAMES && written.is_ok() {
            written = writer.write(&pending);
            pending.clear();
        }
    })?;
    written?;
    writer.write(&pending)?;
    writer.finish()?;
    let rate_hz = filter.filter().output_rate_hz();
    Ok(WrittenEnvelopes {
        rows,
        rate_hz,
        flat_hz: FLAT * rate_hz,
        rejected_hz: filter.filter().stopband_hz(),
        noise: noise.map(|noise| if noise.is_finite() { noise } else { 0.0 }),
    })
}

/// Samples of a frame of an analysis, divided into envelopes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FrameSamples {
    /// Samples per envelope.
    hop: u32,
    /// Envelopes per frame.
    envelopes: u32,
}

impl FrameSamples {
    /// Divides the samples of a frame at this sampling rate into the fewest envelopes that have equal numbers of them, so that frames
    /// of envelopes and of samples have the same instants. Few rates have no such number; their frames are shorter by up to a sample.
    fn at(rate_hz: f64) -> Self {
        let samples = samples_per_frame(rate_hz);
        let mut counts = LEAST_PER_FRAME..=samples / LEAST_HOP;
        let envelopes = counts.find(|count| samples.is_multiple_of(*count));
        let envelopes = envelopes.unwrap_or(LEAST_PER_FRAME);
        Self {
            hop: (samples / envelopes).max(LEAST_HOP),
            envelopes,
        }
    }

    fn total(self) -> u32 {
        self.hop * self.envelopes
    }
}

/// Returns an envelope in volts or metres, NaN where it is clipped or lost.
fn value(envelope: &ChannelEnvelope, scale: Complex64, step: Option<f64>) -> Complex64 {
    if !envelope.mask.is_clear() {
        return Complex64::new(f64::NAN, f64::NAN);
    }
    let value = envelope.value * scale;
    Complex64::new(rounded(value.re, step), rounded(value.im, step))
}

/// Returns the standard deviations of the noise at the beginning of a recording, V and m; not finite where it is not known.
fn noise(source: &Path, flaws: &[Flaw]) -> Result<[f64; 2], ArchiveError> {
    let mut noises = [Vec::new(), Vec::new()];
    demodulate(source, flaws, NOISE_S, |scales, frame| {
        for ((noises, envelope), scale) in noises.iter_mut().zip(&frame.envelopes).zip(scales) {
            noises.push(envelope.noise * scale.norm());
        }
    })?;
    let finite = |noises: Vec<f64>| noises.into_iter().filter(|noise| noise.is_finite());
    Ok(noises.map(|noises| median(finite(noises)).unwrap_or(f64::NAN)))
}

/// Passes the envelopes of the first seconds of a recording to `take`, with the scales of both channels.
fn demodulate(
    source: &Path,
    flaws: &[Flaw],
    length_s: f64,
    mut take: impl FnMut([Complex64; 2], &EnvelopeFrame<2>),
) -> Result<Demodulator<2>, ArchiveError> {
    let mut reader = RecordingReader::open(source)?;
    let properties = SignalProperties {
        clip_levels: clip_levels(flaws),
        ..SignalProperties::default()
    };
    let hop = FrameSamples::at(reader.rate_hz()).hop;
    let manifest = reader.manifest().clone();
    let demodulator = envelope_demodulator(&manifest, reader.format(), &properties, hop);
    let mut demodulator = demodulator.map_err(RecordingError::from)?;
    // The caller archives recordings with signals.
    let scales = manifest
        .signals()
        .map_or([Complex64::ONE; 2], |signals| scales(&signals.channels));
    let frames = (length_s * reader.rate_hz()).min(reader.frames() as f64) as u64;
    let mut block = Vec::new();
    let mut read = 0;
    while read < frames {
        let n = reader.read_block(BLOCK_FRAMES, &mut block)?;
        if n == 0 {
            break;
        }
        read += n as u64;
        demodulator
            .push(&block, |frame| take(scales, frame))
            .map_err(|error| RecordingError::from(DemodulationError::from(error)))?;
    }
    Ok(demodulator)
}

/// Returns the scales from sample values to volts and metres, with the pickup's phase.
fn scales(channels: &RecordedChannels) -> [Complex64; 2] {
    let pickup = Complex64::from_polar(1.0, channels.pickup.phase_rad);
    [
        Complex64::from(channels.drive.volts_per_unit),
        pickup * channels.pickup.metres_per_unit,
    ]
}

/// Returns the levels at which drive and pickup clip, by the flaws.
fn clip_levels(flaws: &[Flaw]) -> [f32; 2] {
    let mut levels = [f32::INFINITY; 2];
    for flaw in flaws {
        if let Flaw::Clipped { channel, level, .. } = flaw {
            let index = match channel {
                Channel::Drive => 0,
                Channel::Pickup => 1,
            };
            levels[index] = *level;
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_envelopes_have_the_instants_of_those_of_samples() {
        for (rate_hz, hop, envelopes) in [
            (100e3, 25, 2),
            (192e3, 48, 2),
            (156_250.0, 40, 2),
            (88_200.0, 15, 3),
            (250e3, 25, 5),
            (106e3, 26, 2),
        ] {
            let frame = FrameSamples::at(rate_hz);
            assert_eq!(frame, FrameSamples { hop, envelopes }, "{rate_hz}");
            let difference = samples_per_frame(rate_hz) - frame.total();
            assert_eq!(difference, u32::from(rate_hz == 106e3), "{rate_hz}");
        }
    }
}
