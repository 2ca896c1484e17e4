//! Reads the envelopes of drive and pickup in place of their samples.

use std::f64::consts::PI;

use envelope_files::EvenRows;
use impedance::{ChannelScales, EnvelopeStream, Filter, Zm};
use num_complex::Complex64;

use super::demodulated_recording::DemodulatedRecording;
use crate::findings::RecordingError;
use crate::flaw::{Channel, Flaw};
use crate::measurements::Measurements;
use crate::spans::Spans;
use crate::vibration::Vibration;
use recording::manifest::Manifest;
use recording::pipeline::{DemodulationError, PickupOffset};
use recording::{ENVELOPES_FILE, RecordingSource};

/// Reads a recording with envelopes, with the pickup's phase and delay corrected by the offset.
pub(super) fn read(
    source: &RecordingSource<'_>,
    manifest: Manifest,
    pickup: PickupOffset,
) -> Result<DemodulatedRecording, RecordingError> {
    let vibration = Vibration::stated(&manifest).ok_or(DemodulationError::NoSteadyCarrier)?;
    let mut rows = EvenRows::open(&source.path().join(ENVELOPES_FILE))?;
    let filter = Filter::for_envelopes(rows.rate_hz(), vibration.carrier_hz)
        .map_err(DemodulationError::from)?;
    let is_inverted = vibration.plate.force_factor_n_per_v < 0.0;
    let scales = ChannelScales {
        drive_volts_per_unit: 1.0,
        pickup_metres_per_unit: 1.0,
        pickup_phase_rad: pickup.turn_rad + if is_inverted { PI } else { 0.0 },
    };
    let zm = Zm::new(vibration.plate.constants(), scales, &filter)
        .map_err(DemodulationError::from)?
        .with_pickup_delay(pickup.delay_s);
    let mut record = Measurements::from_faults(&manifest, manifest.event_rate_hz(rows.rate_hz()));
    let spans = Spans::with_surroundings(&manifest);
    let mut stream = EnvelopeStream::new(filter, rows.start_s());
    if let Some(archived) = manifest.archived() {
        stream = stream.with_noise([archived.drive_noise_v, archived.pickup_noise_m]);
    }
    let mut lost = [0u64; 2];
    let mut envelopes: Vec<[Complex64; 2]> = Vec::new();
    while rows.read(&mut envelopes)? > 0 {
        source.require_running()?;
        for pair in envelopes.drain(..) {
            for (lost, envelope) in lost.iter_mut().zip(&pair) {
                *lost += u64::from(!envelope.is_finite());
            }
            stream.push(pair, &mut |frame| {
                if spans.contain(frame.time_s, 0.0) {
                    record.frames.push(zm.read(frame));
                }
            });
        }
    }
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
            (flaws, rows.end_s())
        }
    };
    let mut reading = DemodulatedRecording {
        manifest,
        vibration: Some(vibration),
        record,
        flaws,
    };
    reading.check_intervals(duration_s)?;
    reading.read_rows(source, duration_s)?;
    Ok(reading)
}
