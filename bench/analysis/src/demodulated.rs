//! Streams a recording folder through the demodulator that also runs live; only its 2 kHz frames are held in memory.

use std::path::Path;

use crate::analysed::RecordingError;
use crate::clipping::Extremes;
use crate::flaw::{Channel, Flaw};
use crate::levels::Levels;
use crate::measurements::{LONGEST_GAP_S, Measurements};
use recording::manifest::Manifest;
use recording::pipeline::{FoundProperties, PickupOffset, Pipeline, RecordedError};
use recording::reader::{ReadError, RecordingReader};
use recording::{FORCE_FILE, POSITION_FILE};

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
    pub fn carrier_missing(&self) -> bool {
        let missing = |flaw: &Flaw| matches!(flaw, Flaw::CarrierMissing { .. });
        self.flaws.iter().any(missing)
    }
}

/// Reads a recording folder, with the pickup as stated plus its offset. The audio is read twice: first for the level at
/// which it clips.
///
/// # Errors
/// A file cannot be read, or the audio cannot be demodulated as the manifest says.
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
    let mut found = FoundProperties {
        pickup,
        ..FoundProperties::default()
    };
    let levels = extremes.iter().zip(&mut found.clip_levels);
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
    let mut pipeline = Pipeline::of_recording_with(&manifest, reader.format(), &found)?;
    let mut levels = Levels::new(&manifest, reader.format().sample_rate_hz);
    let mut record = Measurements::default();
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
    let duration_s = reader.frames() as f64 / f64::from(reader.format().sample_rate_hz);
    let force_s: Vec<f64> = record.force.iter().map(|row| row.time_s).collect();
    flaws.extend(misplaced(FORCE_FILE, &force_s, duration_s));
    let position_s: Vec<f64> = record.position.iter().map(|row| row.time_s).collect();
    flaws.extend(misplaced(POSITION_FILE, &position_s, duration_s));
    record.saturated = manifest.saturated_s(reader.format().sample_rate_hz);
    Ok(DemodulatedRecording {
        manifest,
        record,
        flaws,
    })
}

/// Returns the flaw of readings that lie outside the recording, or too far apart for anything to be estimated.
fn misplaced(file: &'static str, times_s: &[f64], duration_s: f64) -> Option<Flaw> {
    let (&from_s, &to_s) = times_s.first().zip(times_s.last())?;
    if to_s < 0.0 || from_s > duration_s {
        return Some(Flaw::ElsewhereInTime {
            file,
            from_s,
            to_s,
            duration_s,
        });
    }
    let mut steps_s: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps_s.sort_by(f64::total_cmp);
    let step_s = *steps_s.get(steps_s.len() / 2)?;
    (step_s > LONGEST_GAP_S).then_some(Flaw::Sparse { file, step_s })
}
