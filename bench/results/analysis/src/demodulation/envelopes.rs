//! Reads the envelopes of drive and pickup in place of their samples.

use std::path::Path;

use super::demodulated_recording::DemodulatedRecording;
use super::envelope_demodulator::EnvelopeDemodulator;
use crate::findings::RecordingError;
use crate::flaw::{Channel, Flaw};
use crate::measurements::Measurements;
use crate::spans::Spans;
use crate::vibration::Vibration;
use envelope_files::EvenRows;
use recording::manifest::Manifest;
use recording::pipeline::{DemodulationError, PickupOffset};
use recording::{ENVELOPES_FILE, RecordingSource};

/// Length that is read at a time, s.
const PIECE_S: f64 = 1.0;

/// Reads a recording with envelopes, with the pickup's phase and delay corrected by the offset.
pub(super) fn read(
    source: &RecordingSource<'_>,
    manifest: Manifest,
    pickup: PickupOffset,
) -> Result<DemodulatedRecording, RecordingError> {
    let vibration = Vibration::stated(&manifest).ok_or(DemodulationError::NoSteadyCarrier)?;
    let mut envelopes = EnvelopeDemodulator::open(source.path(), (&manifest, &vibration), pickup)?;
    let mut record =
        Measurements::from_faults(&manifest, manifest.event_rate_hz(envelopes.rate_hz()));
    let spans = Spans::with_surroundings(&manifest);
    let mut until_s = envelopes.time_s();
    let mut follows = true;
    while follows {
        source.require_running()?;
        until_s += PIECE_S;
        follows = envelopes.read_until(until_s, |frame| {
            if spans.contain(frame.time_s, 0.0) {
                record.frames.push(frame);
            }
        })?;
    }
    let (_, lost) = envelopes.counts();
    let channels = [Channel::Drive, Channel::Pickup].into_iter().zip(lost);
    let (flaws, duration_s) = match manifest.archived() {
        // Checked when the samples were there.
        Some(archived) => {
            let warnings = archived.warnings.iter().cloned();
            let flaws: Vec<Flaw> = warnings.map(|warning| Flaw::Archived { warning }).collect();
            (flaws, archived.duration_s)
        }
        None => {
            let mut flaws = vec![Flaw::ConverterUnchecked];
            flaws.extend(
                channels
                    .filter(|(_, lost)| *lost > 0)
                    .map(|(channel, samples)| Flaw::LostSamples { channel, samples }),
            );
            flaws.extend(low_pass(source.path(), &manifest)?);
            (flaws, envelopes.end_s())
        }
    };
    let mut reading = DemodulatedRecording {
        manifest,
        vibration: Some(vibration),
        record,
        flaws,
    };
    // An interval may end with the time of the last envelope.
    reading.check_intervals(duration_s, 1.5 / envelopes.rate_hz())?;
    reading.read_rows(source, duration_s)?;
    Ok(reading)
}

/// Returns the flaw of envelopes that were low-passed, by the longest interval without a finger.
fn low_pass(folder: &Path, manifest: &Manifest) -> Result<Option<Flaw>, RecordingError> {
    let mut rows = EvenRows::open(&folder.join(ENVELOPES_FILE))?;
    let unloaded_s = manifest.unloaded_s();
    let length_s = |span: &&(f64, f64)| span.1 - span.0;
    let longest = unloaded_s
        .iter()
        .max_by(|a, b| length_s(a).total_cmp(&length_s(b)));
    let Some(&(start_s, end_s)) = longest else {
        return Ok(None);
    };
    let (rate_hz, first_s) = (rows.rate_hz(), rows.start_s());
    let row = |time_s: f64| ((time_s - first_s) * rate_hz).max(0.0) as usize;
    let inside = row(start_s)..row(end_s);
    let (mut count, mut block) = (0, Vec::new());
    let mut levels = [Vec::new(), Vec::new()];
    while count < inside.end {
        block.clear();
        if rows.read(&mut block)? == 0 {
            break;
        }
        for pair in &block {
            if inside.contains(&count) {
                levels[0].push(pair[0].norm());
                levels[1].push(pair[1].norm());
            }
            count += 1;
        }
    }
    let [drive, pickup] = &levels;
    let remaining = plausibility::filtered_envelopes([drive, pickup], rate_hz);
    Ok(remaining.map(|remaining| Flaw::EnvelopesFiltered { remaining }))
}
