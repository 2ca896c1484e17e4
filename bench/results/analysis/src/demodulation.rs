//! Reads a recording for its analysis: its impedance frames, from the demodulator of the live bench or from recorded envelopes,
//! and the rows of force and position. Only data in and around the recording's intervals are kept.
//!
//! A stream that is missing is left empty, with a flaw that names the results that lack it.

mod demodulated_recording;
mod envelope_demodulator;
mod envelopes;
mod signals;

use crate::findings::RecordingError;
use crate::flaw::Flaw;
use crate::measurements::{LONGEST_GAP_S, Measurements};
use crate::row_times;
use crate::spans::Spans;
pub use demodulated_recording::DemodulatedRecording;
pub use envelope_demodulator::EnvelopeDemodulator;
use recording::manifest::{Manifest, Streams};
use recording::pipeline::PickupOffset;
use recording::reader::Warning;
use recording::{CsvRow, FORCE_FILE, RecordingSource, STIMULUS_FILE, reader};

/// Reads a recording, with the pickup's stated values plus the offset. The audio is read twice: first to find its
/// clipping level.
///
/// # Errors
/// A file cannot be read, or the audio cannot be demodulated with the manifest's values.
pub fn read(
    source: &RecordingSource<'_>,
    pickup: PickupOffset,
) -> Result<DemodulatedRecording, RecordingError> {
    let manifest = source.manifest()?;
    match &manifest.streams {
        Streams::Signals(_) => signals::read(source, pickup),
        Streams::Envelopes(_) => envelopes::read(source, manifest, pickup),
        Streams::Forces(_) => read_forces(source, manifest),
    }
}

/// Returns the flaws of a recording's samples, and whether nothing but the samples shows them in full, because the carrier moves or is
/// missing.
///
/// # Errors
/// As [`read`].
pub fn sample_flaws(source: &RecordingSource<'_>) -> Result<(Vec<Flaw>, bool), RecordingError> {
    let (mut reading, _) = signals::demodulate(source, PickupOffset::default())?;
    let moves = reading
        .vibration
        .as_ref()
        .is_none_or(|vibration| vibration.moves);
    let needs_samples = moves || reading.is_carrier_missing();
    // Found in the envelopes too.
    reading
        .flaws
        .retain(|flaw| !matches!(flaw, Flaw::File(Warning::IntervalBeyondEnd { .. })));
    Ok((reading.flaws, needs_samples))
}

/// Reads a recording of forces alone, which lasts as long as its rows.
fn read_forces(
    source: &RecordingSource<'_>,
    manifest: Manifest,
) -> Result<DemodulatedRecording, RecordingError> {
    let mut reading = DemodulatedRecording {
        manifest,
        vibration: None,
        record: Measurements::default(),
        flaws: Vec::new(),
    };
    // Without its forces nothing is left.
    reader::force_rows(source.path(), f64::INFINITY)?;
    let Some(duration_s) = reading.read_rows(source, f64::INFINITY)? else {
        reading.flaws.extend(elsewhere(source, &reading.manifest)?);
        return Ok(reading);
    };
    reading.check_intervals(duration_s, LONGEST_GAP_S)?;
    if let Some(mut rows) = source.stimulus(f64::INFINITY)? {
        let spans = Spans::with_surroundings(&reading.manifest);
        let time_s = CsvRow::time_s;
        let (stimulus, times) = row_times::read_rows(&spans, STIMULUS_FILE, rows.by_ref(), time_s)?;
        reading.record.stimulus = stimulus;
        reading
            .flaws
            .extend(times.flaws(rows.warnings(), duration_s));
    }
    Ok(reading)
}

/// Returns the flaw of forces with no row in an interval.
fn elsewhere(
    source: &RecordingSource<'_>,
    manifest: &Manifest,
) -> Result<Option<Flaw>, RecordingError> {
    let Some(duration_s) = manifest
        .intervals
        .iter()
        .map(|interval| interval.end_s)
        .reduce(f64::max)
    else {
        return Ok(None);
    };
    let mut ends_s: Option<(f64, f64)> = None;
    for row in reader::force_rows(source.path(), f64::INFINITY)? {
        let time_s = row?.time_s;
        ends_s = Some((ends_s.map_or(time_s, |(first_s, _)| first_s), time_s));
    }
    Ok(ends_s.map(|(from_s, to_s)| Flaw::ElsewhereInTime {
        file: FORCE_FILE,
        from_s,
        to_s,
        duration_s,
    }))
}
