//! Streams a recording folder through the demodulator of the live bench. Only data in and around the recording's intervals
//! are kept in memory: 2 kHz frames, and the rows of force and position.

use std::path::Path;

use impedance::ZmFrame;

use crate::clipping::Extremes;
use crate::findings::RecordingError;
use crate::flaw::{Channel, Flaw};
use crate::levels::Levels;
use crate::measurements::Measurements;
use crate::row_times;
use crate::spans::Spans;
use recording::manifest::Manifest;
use recording::pipeline::{DemodulationError, PickupOffset, Pipeline, SignalProperties};
use recording::reader::RecordingReader;
use recording::{FORCE_FILE, ForceRow, POSITION_FILE, PositionRow};

/// Frames of audio read at a time.
const BLOCK_FRAMES: usize = 16_384;

/// Recording in memory, demodulated.
#[derive(Debug)]
pub struct DemodulatedRecording {
    /// Description of the recording.
    pub manifest: Manifest,
    /// Impedance, force and position.
    pub record: Measurements,
    /// Defects of the recording.
    pub flaws: Vec<Flaw>,
}

impl DemodulatedRecording {
    /// Returns whether the carrier is missing from a channel.
    pub fn is_carrier_missing(&self) -> bool {
        let is_missing = |flaw: &Flaw| matches!(flaw, Flaw::CarrierMissing { .. });
        self.flaws.iter().any(is_missing)
    }
}

/// Reads a recording folder, with the pickup's stated values plus the offset. The audio is read twice: first to find its
/// clipping level.
///
/// # Errors
/// A file cannot be read, or the audio cannot be demodulated with the manifest's values.
pub fn read(folder: &Path, pickup: PickupOffset) -> Result<DemodulatedRecording, RecordingError> {
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
    let mut properties = SignalProperties {
        pickup,
        ..SignalProperties::default()
    };
    let levels = extremes.iter().zip(&mut properties.clip_levels);
    for ((extremes, level), (channel, _)) in levels.zip(indices) {
        if extremes.lost_samples > 0 {
            flaws.push(Flaw::LostSamples {
                channel,
                samples: extremes.lost_samples,
            });
        }
        let name = channel.to_string();
        flaws.extend(plausibility::channel(&name, extremes.level()).map(Flaw::from));
        if let Some((samples, magnitude)) = extremes.clipping() {
            *level = magnitude;
            flaws.push(Flaw::Clipped {
                channel,
                samples,
                level: magnitude,
            });
        }
    }

    let mut reader = RecordingReader::open(folder)?;
    let mut pipeline = Pipeline::from_recording_with(&manifest, reader.format(), &properties)?;
    let mut levels = Levels::new(&manifest, reader.format().sample_rate_hz);
    let mut record = Measurements::from_faults(&manifest, reader.format().sample_rate_hz);
    let spans = Spans::with_surroundings(&manifest);
    let mut frames: Vec<ZmFrame> = Vec::new();
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        levels.take(pipeline.account().frames, &block, channels, [drive, piezo]);
        pipeline
            .process(&block, &mut frames)
            .map_err(DemodulationError::from)?;
        for frame in frames.drain(..) {
            levels.take_frame(&frame);
            if spans.contain(frame.time_s, 0.0) {
                record.frames.push(frame);
            }
        }
    }
    flaws.extend(levels.flaws(manifest.carrier_hz));

    let duration_s = reader.duration_s();
    let mut rows = reader.force()?;
    let time_s = |row: &ForceRow| row.time_s;
    let (force, times) = row_times::read_rows(&spans, FORCE_FILE, rows.by_ref(), time_s)?;
    record.force = force;
    flaws.extend(times.flaws(rows.warnings(), duration_s));
    let mut rows = reader.position()?;
    let time_s = |row: &PositionRow| row.time_s;
    let (position, times) = row_times::read_rows(&spans, POSITION_FILE, rows.by_ref(), time_s)?;
    record.position = position;
    flaws.extend(times.flaws(rows.warnings(), duration_s));
    Ok(DemodulatedRecording {
        manifest,
        record,
        flaws,
    })
}
