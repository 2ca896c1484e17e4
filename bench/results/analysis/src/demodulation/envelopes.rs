//! Reads the envelopes of drive and pickup in place of their samples.

use super::demodulated_recording::DemodulatedRecording;
use super::envelope_demodulator::EnvelopeDemodulator;
use crate::findings::RecordingError;
use crate::flaw::{Channel, Flaw};
use crate::measurements::Measurements;
use crate::spans::Spans;
use crate::vibration::Vibration;
use recording::RecordingSource;
use recording::manifest::Manifest;
use recording::pipeline::{DemodulationError, PickupOffset};

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
