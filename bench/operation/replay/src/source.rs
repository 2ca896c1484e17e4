//! Recording as a source of batches, in place of the sound card and the sensors.

use std::path::Path;

use analysis::vibration::Vibration;
use recording::manifest::Manifest;
use recording::pipeline::Batch;
use recording::reader::{ReadError, RowReader, Warning, force_rows, position_rows};
use recording::{CsvRow, ForceRow, PositionRow};

use crate::film::Film;

/// Impedances as they would arrive live, with the sensor rows of the same time; none of a sensor that was not recorded.
pub struct Source {
    film: Film,
    vibration: Vibration,
    force: Rows<ForceRow>,
    position: Rows<PositionRow>,
    ended: bool,
}

impl Source {
    /// Opens the recording in `folder`.
    ///
    /// # Errors
    /// If a file is missing or violates the format, the recording has neither signals nor envelopes, or they cannot be demodulated
    /// as the manifest says.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        let (film, vibration) = Film::open(folder)?;
        let duration_s = film.duration_s();
        Ok(Self {
            force: Rows::new(optional(force_rows(folder, duration_s))?)?,
            position: Rows::new(optional(position_rows(folder, duration_s))?)?,
            film,
            vibration,
            ended: false,
        })
    }

    /// Returns the manifest of the recording.
    pub fn manifest(&self) -> &Manifest {
        self.film.manifest()
    }

    /// Returns the vibration of the plate.
    pub fn vibration(&self) -> &Vibration {
        &self.vibration
    }

    /// Returns the rate of samples or envelopes, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.film.rate_hz()
    }

    /// Returns the rate of the samples by which events are counted, Hz.
    pub fn event_rate_hz(&self) -> f64 {
        self.manifest().event_rate_hz(self.rate_hz())
    }

    /// Returns the rate of samples or envelopes in whole hertz.
    pub fn whole_rate_hz(&self) -> u32 {
        self.rate_hz().round() as u32
    }

    /// Returns the length of the recording, s.
    pub fn duration_s(&self) -> f64 {
        self.film.duration_s()
    }

    /// Whether everything has been read.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Returns the defects found so far in the recording.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.film.warnings().to_vec();
        warnings.extend(self.force.warnings());
        warnings.extend(self.position.warnings());
        warnings
    }

    /// Reads on to `until_s` of the recording.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn read_until(&mut self, until_s: f64) -> anyhow::Result<Batch> {
        let mut batch = Batch::default();
        self.ended = !self.film.read_until(until_s, &mut batch)?;
        let rows_until_s = if self.ended {
            f64::INFINITY
        } else {
            batch.audio_s
        };
        self.force.take_until(rows_until_s, &mut batch.force)?;
        self.position
            .take_until(rows_until_s, &mut batch.position)?;
        Ok(batch)
    }
}

/// Rows of a file, with one row of look-ahead; none without the file.
struct Rows<R> {
    rows: Option<RowReader<R>>,
    next: Option<R>,
}

/// Returns the rows of a file; `None` if it does not exist.
fn optional<R>(rows: Result<RowReader<R>, ReadError>) -> Result<Option<RowReader<R>>, ReadError> {
    match rows {
        Ok(rows) => Ok(Some(rows)),
        Err(ReadError::Absent { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

impl<R: CsvRow> Rows<R> {
    fn new(rows: Option<RowReader<R>>) -> Result<Self, ReadError> {
        let mut rows = Self { rows, next: None };
        rows.next = rows.read()?;
        Ok(rows)
    }

    fn read(&mut self) -> Result<Option<R>, ReadError> {
        let row = self.rows.as_mut().and_then(Iterator::next);
        row.transpose()
    }

    fn warnings(&self) -> Vec<Warning> {
        let rows = self.rows.iter();
        rows.flat_map(RowReader::warnings).collect()
    }

    fn take_until(&mut self, until_s: f64, output: &mut Vec<R>) -> Result<(), ReadError> {
        while let Some(row) = self.next.take_if(|row| row.time_s() <= until_s) {
            output.push(row);
            self.next = self.read()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use envelope_files::{EnvelopeRow, EnvelopeWriter};
    use num_complex::Complex64;
    use recording::manifest::MINIMAL;

    use super::*;

    #[test]
    fn envelopes_without_forces_are_read_on_by_time() {
        let folder = tempfile::tempdir().unwrap();
        let lines = MINIMAL.lines();
        let manifest: Vec<&str> = lines.filter(|line| !line.starts_with("channels")).collect();
        fs::write(folder.path().join("recording.toml"), manifest.join("\n")).unwrap();
        let rows: Vec<EnvelopeRow> = (0..3000)
            .map(|row| EnvelopeRow {
                time_s: f64::from(row) * 1e-4,
                drive_v: Complex64::new(10.0, 0.0),
                pickup_m: Complex64::new(0.0, 1e-6),
            })
            .collect();
        let mut writer = EnvelopeWriter::create(&folder.path().join("envelopes.parquet")).unwrap();
        writer.write(&rows).unwrap();
        writer.finish().unwrap();

        let mut source = Source::open(folder.path()).unwrap();
        assert_eq!(source.whole_rate_hz(), 10_000);
        assert!((source.duration_s() - 0.2999).abs() < 1e-9);
        let first = source.read_until(0.1).unwrap();
        assert!((first.audio_s - 0.1).abs() < 2e-4 && !source.ended());
        let second = source.read_until(1.0).unwrap();
        assert!(source.ended() && second.force.is_empty());
        assert_eq!(second.account.frames, 3000);
        let frames = first.frames.iter().chain(&second.frames);
        let times_s: Vec<f64> = frames.map(|frame| frame.time_s).collect();
        assert!(times_s.len() > 400 && times_s.is_sorted(), "{times_s:?}");
        assert!(first.frames.iter().all(|frame| frame.time_s < 0.1));
    }

    #[test]
    fn forces_alone_are_refused_with_the_commands_that_show_them() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("recording.toml"), "format = 1\n").unwrap();
        fs::write(
            folder.path().join("force.csv"),
            "time_s,normal_n,lateral_n\n0,0.5,0.2\n",
        )
        .unwrap();
        let error = Source::open(folder.path()).err().unwrap().to_string();
        assert!(error.contains("friction-bench analyze"), "{error}");
        assert!(error.contains("--as csv"), "{error}");
    }
}
