//! Reads a recording folder into memory: its impedance frames, from the demodulator of the live bench or from recorded envelopes,
//! and the rows of force and position. Only data in and around the recording's intervals are kept.
//!
//! A stream that is missing is left empty, with a flaw that names the results that lack it.

mod envelopes;
mod signals;

use std::path::Path;

use crate::findings::RecordingError;
use crate::flaw::{Flaw, MissingStream};
use crate::measurements::Measurements;
use crate::row_times;
use crate::spans::Spans;
use crate::vibration::Vibration;
use recording::manifest::{Manifest, Streams};
use recording::pipeline::PickupOffset;
use recording::reader::{ReadError, RowReader, read_manifest};
use recording::{CsvRow, FORCE_FILE, POSITION_FILE, STIMULUS_FILE, reader};

/// Recording in memory, demodulated.
#[derive(Debug)]
pub struct DemodulatedRecording {
    /// Description of the recording.
    pub manifest: Manifest,
    /// Vibration of the plate; `None` if only forces were recorded.
    pub vibration: Option<Vibration>,
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
    reading.read_rows(folder, f64::INFINITY)?;
    let Some(last) = reading.record.force.last() else {
        return Ok(reading);
    };
    let duration_s = last.time_s;
    let rows = optional(reader::stimulus_rows(folder, f64::INFINITY))?;
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

impl DemodulatedRecording {
    /// Reads the rows of force and position of a recording of `duration_s`.
    fn read_rows(&mut self, folder: &Path, duration_s: f64) -> Result<(), RecordingError> {
        let spans = Spans::with_surroundings(&self.manifest);
        match optional(reader::force_rows(folder, duration_s))? {
            Some(mut rows) => {
                let time_s = CsvRow::time_s;
                let (force, times) =
                    row_times::read_rows(&spans, FORCE_FILE, rows.by_ref(), time_s)?;
                self.record.force = force;
                self.flaws.extend(times.flaws(rows.warnings(), duration_s));
            }
            None => self.flaws.push(Flaw::Missing(MissingStream::Forces)),
        }
        match optional(reader::position_rows(folder, duration_s))? {
            Some(mut rows) => {
                let time_s = CsvRow::time_s;
                let (position, times) =
                    row_times::read_rows(&spans, POSITION_FILE, rows.by_ref(), time_s)?;
                self.record.position = position;
                self.flaws.extend(times.flaws(rows.warnings(), duration_s));
            }
            None => self.flaws.push(Flaw::Missing(MissingStream::Positions)),
        }
        Ok(())
    }
}

/// Returns the rows of a file; `None` if it does not exist.
fn optional<R>(rows: Result<RowReader<R>, ReadError>) -> Result<Option<RowReader<R>>, ReadError> {
    match rows {
        Ok(rows) => Ok(Some(rows)),
        Err(ReadError::Absent { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}
