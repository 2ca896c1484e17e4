//! Reads a recording folder into memory: its impedance frames, from the demodulator of the live bench or from recorded envelopes,
//! and the rows of force and position. Only data in and around the recording's intervals are kept.
//!
//! A stream that is missing is left empty, with a flaw that names the results that lack it.

mod demodulated_recording;
mod envelope_demodulator;
mod envelopes;
mod signals;

use std::path::Path;

use crate::findings::RecordingError;
use crate::measurements::Measurements;
use crate::row_times;
use crate::spans::Spans;
pub use demodulated_recording::{DemodulatedRecording, optional_rows};
pub use envelope_demodulator::EnvelopeDemodulator;
use recording::manifest::{Manifest, Streams};
use recording::pipeline::PickupOffset;
use recording::reader::read_manifest;
use recording::{CsvRow, STIMULUS_FILE, reader};

/// Reads a recording folder, with the pickup's stated values plus the offset. The audio is read twice: first to find its
/// clipping level.
///
/// # Errors
/// A file cannot be read, or the audio cannot be demodulated with the manifest's values.
pub fn read(folder: &Path, pickup: PickupOffset) -> Result<DemodulatedRecording, RecordingError> {
    let manifest = read_manifest(folder)?;
    match &manifest.streams {
        Streams::Signals(_) => signals::read(folder, pickup),
        Streams::Envelopes(_) => envelopes::read(folder, manifest, pickup),
        Streams::Forces(_) => read_forces(folder, manifest),
    }
}

/// Reads a recording of forces alone, which lasts as long as its rows.
fn read_forces(folder: &Path, manifest: Manifest) -> Result<DemodulatedRecording, RecordingError> {
    let mut reading = DemodulatedRecording {
        manifest,
        vibration: None,
        record: Measurements::default(),
        flaws: Vec::new(),
    };
    // Without its forces nothing is left.
    reader::force_rows(folder, f64::INFINITY)?;
    reading.read_rows(folder, f64::INFINITY)?;
    let Some(last) = reading.record.force.last() else {
        return Ok(reading);
    };
    let duration_s = last.time_s;
    reading.check_intervals(duration_s)?;
    let rows = optional_rows(reader::stimulus_rows(folder, f64::INFINITY))?;
    if let Some(mut rows) = rows {
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
