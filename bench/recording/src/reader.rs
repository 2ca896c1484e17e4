//! Reads recording folders as streams, also damaged ones: reads what is there and reports what is missing.

use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use crate::csv_rows::{CsvRow, ForceRow, PositionRow};
use crate::manifest::{Manifest, ManifestReadError};
use crate::wav::{AudioFormat, WavError, WavReader, WavWarning};
use crate::{FORCE_FILE, MANIFEST_FILE, POSITION_FILE, SIGNALS_FILE};

/// Bytes of audio read from the operating system at a time.
const BUFFER_BYTES: usize = 1 << 18;

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// A file of the recording is missing, or the operating system refused.
    #[error("cannot read {}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason; not a `source`, because the message contains it.
        reason: io::Error,
    },
    /// `recording.toml` is not one, or does not fit the audio.
    #[error(transparent)]
    Manifest(#[from] ManifestReadError),
    /// `signals.wav` cannot be read.
    #[error("{}: {reason}", path.display())]
    Wav {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: WavError,
    },
    /// A CSV file lacks a column.
    #[error(
        "{}: no column `{column}`; its header is `{header}`, columns are separated by commas",
        path.display()
    )]
    MissingColumn {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// The header found.
        header: String,
    },
}

/// Defect of a recording that can be read nevertheless.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Warning {
    /// A defect of the audio file.
    #[error("{SIGNALS_FILE}: {0}")]
    Signals(#[from] WavWarning),
    /// An interval ends after the last sample.
    #[error(
        "{MANIFEST_FILE}: `intervals.{index}` ends at {end_s} s, but the recording ends at {duration_s} s"
    )]
    IntervalBeyondEnd {
        /// Position in the list, from 0.
        index: usize,
        /// End of the interval, s.
        end_s: f64,
        /// Length of the audio, s.
        duration_s: f64,
    },
    /// The trial did not end.
    #[error("{MANIFEST_FILE}: the trial has no `end`: its recording was cut off")]
    CutOff,
    /// Rows are left out because a field is missing or no number, because they have more fields than the header (as
    /// where the decimal sign is a comma), or because the last line has no end and may be torn.
    #[error(
        "{file}: {rows} rows cannot be read and are left out, the first in line {first_line}: `{first}`"
    )]
    UnreadableRows {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
        /// Beginning of that line.
        first: String,
    },
    /// Rows are left out because their time does not increase.
    #[error(
        "{file}: {rows} rows are left out because their time does not increase, the first in line {first_line}"
    )]
    TimeDisorder {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
    },
    /// Rows have a value that is not finite; they are read.
    #[error(
        "{file}: {rows} rows have a value that is NaN or infinite, the first in line {first_line}"
    )]
    NotFinite {
        /// The file.
        file: &'static str,
        /// Number of rows.
        rows: u64,
        /// Line of the first of them.
        first_line: u64,
    },
    /// No row could be read.
    #[error(
        "{file}: no row can be read; columns are separated by commas, and the decimal sign is a point"
    )]
    NoRows {
        /// The file.
        file: &'static str,
    },
}

/// Recording folder opened for reading; its audio is read in blocks. [`RecordingWriter`](crate::RecordingWriter) has an
/// example.
#[derive(Debug)]
pub struct RecordingReader {
    folder: PathBuf,
    manifest: Manifest,
    wav: WavReader<BufReader<File>>,
    warnings: Vec<Warning>,
}

impl RecordingReader {
    /// Opens `recording.toml` and `signals.wav`.
    ///
    /// # Errors
    /// [`ReadError`] names the file and what is wrong with it; no content makes this panic.
    pub fn open(folder: &Path) -> Result<Self, ReadError> {
        let (manifest, manifest_text, manifest_file) = parse_manifest(folder)?;
        let path = folder.join(SIGNALS_FILE);
        let file = File::open(&path).map_err(|reason| ReadError::Io {
            path: path.clone(),
            reason,
        })?;
        let (wav, wav_warnings) = WavReader::new(BufReader::with_capacity(BUFFER_BYTES, file))
            .map_err(|reason| match reason {
                WavError::Io(reason) => ReadError::Io {
                    path: path.clone(),
                    reason,
                },
                reason => ReadError::Wav {
                    path: path.clone(),
                    reason,
                },
            })?;
        let format = wav.format();
        manifest
            .validate_audio(format.sample_rate_hz, format.channels)
            .map_err(|rule| ManifestReadError::at(rule, &manifest_text, &manifest_file))?;
        let mut warnings: Vec<Warning> = wav_warnings.into_iter().map(Warning::from).collect();
        if manifest.trial.as_ref().is_some_and(|t| t.end.is_none()) {
            warnings.push(Warning::CutOff);
        }
        let duration_s = wav.frames() as f64 / f64::from(format.sample_rate_hz);
        for (index, interval) in manifest.intervals.iter().enumerate() {
            if interval.end_s > duration_s {
                warnings.push(Warning::IntervalBeyondEnd {
                    index,
                    end_s: interval.end_s,
                    duration_s,
                });
            }
        }
        Ok(Self {
            folder: folder.to_owned(),
            manifest,
            wav,
            warnings,
        })
    }

    /// Returns the folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the description of the recording.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns sample rate and channels.
    #[must_use]
    pub fn format(&self) -> AudioFormat {
        self.wav.format()
    }

    /// Returns the number of frames of audio.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.wav.frames()
    }

    /// Returns the defects of the description and the audio.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Replaces `block` by the next frames, interleaved, at most `max_frames` of them; returns their number, 0 at the
    /// end. NaN stays NaN.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn read_block(
        &mut self,
        max_frames: usize,
        block: &mut Vec<f32>,
    ) -> Result<usize, ReadError> {
        self.wav
            .read_block(max_frames, block)
            .map_err(|reason| ReadError::Io {
                path: self.folder.join(SIGNALS_FILE),
                reason,
            })
    }

    /// Opens the rows of `force.csv`.
    ///
    /// # Errors
    /// The file or one of its columns is missing.
    pub fn force(&self) -> Result<RowReader<ForceRow>, ReadError> {
        RowReader::open(&self.folder, FORCE_FILE)
    }

    /// Opens the rows of `position.csv`.
    ///
    /// # Errors
    /// The file or one of its columns is missing.
    pub fn position(&self) -> Result<RowReader<PositionRow>, ReadError> {
        RowReader::open(&self.folder, POSITION_FILE)
    }
}

/// Reads and checks the `recording.toml` of a folder.
///
/// # Errors
/// The file is missing or breaks a rule.
pub fn read_manifest(folder: &Path) -> Result<Manifest, ReadError> {
    parse_manifest(folder).map(|(manifest, _, _)| manifest)
}

/// Returns the manifest, its text, and the name of its file for errors.
fn parse_manifest(folder: &Path) -> Result<(Manifest, String, String), ReadError> {
    let path = folder.join(MANIFEST_FILE);
    let file = path.display().to_string();
    let text = fs::read_to_string(&path).map_err(|reason| ReadError::Io { path, reason })?;
    let manifest = Manifest::parse(&text, &file)?;
    Ok((manifest, text, file))
}

/// Rows of a CSV file, in file order, with rising times.
///
/// Rows that cannot be read or whose time does not increase are left out and counted; [`warnings`](Self::warnings)
/// after the last row returns them.
#[derive(Debug)]
pub struct RowReader<R> {
    file: &'static str,
    path: PathBuf,
    records: csv::Reader<File>,
    record: csv::ByteRecord,
    columns: Vec<usize>,
    /// Number of columns in the header.
    width: usize,
    /// Length of the file if its last line has no end and so may be torn.
    torn_at_byte: Option<u64>,
    last_time_s: f64,
    rows: u64,
    unreadable: Tally,
    first_unreadable: String,
    disordered: Tally,
    not_finite: Tally,
    row: PhantomData<R>,
}

#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    rows: u64,
    first_line: u64,
}

impl Tally {
    fn count(&mut self, line: u64) {
        if self.rows == 0 {
            self.first_line = line;
        }
        self.rows += 1;
    }
}

impl<R: CsvRow> RowReader<R> {
    fn open(folder: &Path, file: &'static str) -> Result<Self, ReadError> {
        let path = folder.join(file);
        let io_error = |reason| ReadError::Io {
            path: path.clone(),
            reason,
        };
        let mut source = File::open(&path).map_err(io_error)?;
        let torn_at_byte = unended_last_line(&mut source).map_err(io_error)?;
        let mut records = csv::ReaderBuilder::new()
            .flexible(true)
            .quoting(false)
            // With the default, lines are counted one short after CR LF; trimming takes the CR away.
            .terminator(csv::Terminator::Any(b'\n'))
            .trim(csv::Trim::All)
            .from_reader(source);
        let header = records
            .byte_headers()
            .map_err(|error| io_error(error.into()))?
            .clone();
        let columns = R::COLUMNS
            .iter()
            .map(|&column| {
                header
                    .iter()
                    .position(|name| name == column.as_bytes())
                    .ok_or_else(|| ReadError::MissingColumn {
                        path: path.clone(),
                        column,
                        header: beginning(&header),
                    })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            file,
            path,
            records,
            record: csv::ByteRecord::new(),
            columns,
            width: header.len(),
            torn_at_byte,
            last_time_s: f64::NEG_INFINITY,
            rows: 0,
            unreadable: Tally::default(),
            first_unreadable: String::new(),
            disordered: Tally::default(),
            not_finite: Tally::default(),
            row: PhantomData,
        })
    }

    /// Returns the defects of the rows so far; complete once the iterator has ended.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let file = self.file;
        let mut warnings = Vec::new();
        let Tally { rows, first_line } = self.unreadable;
        if rows > 0 {
            warnings.push(Warning::UnreadableRows {
                file,
                rows,
                first_line,
                first: self.first_unreadable.clone(),
            });
        }
        let Tally { rows, first_line } = self.disordered;
        if rows > 0 {
            warnings.push(Warning::TimeDisorder {
                file,
                rows,
                first_line,
            });
        }
        let Tally { rows, first_line } = self.not_finite;
        if rows > 0 {
            warnings.push(Warning::NotFinite {
                file,
                rows,
                first_line,
            });
        }
        if self.rows == 0 {
            warnings.push(Warning::NoRows { file });
        }
        warnings
    }

    fn parse_record(&self) -> Option<(R, bool)> {
        let mut beyond = self.record.iter().skip(self.width);
        if !beyond.all(<[u8]>::is_empty) {
            return None;
        }
        let mut fields = [0.0; 4];
        let fields = fields.get_mut(..self.columns.len())?;
        for (field, &column) in fields.iter_mut().zip(&self.columns) {
            let text = std::str::from_utf8(self.record.get(column)?).ok()?;
            *field = text.parse().ok()?;
        }
        let row = R::from_fields(fields)?;
        let finite = fields.iter().all(|value| value.is_finite());
        row.time_s().is_finite().then_some((row, finite))
    }
}

impl<R: CsvRow> Iterator for RowReader<R> {
    type Item = Result<R, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.records.read_byte_record(&mut self.record) {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error) => {
                    return Some(Err(ReadError::Io {
                        path: self.path.clone(),
                        reason: error.into(),
                    }));
                }
            }
            let line = self.record.position().map_or(0, csv::Position::line);
            let torn = self
                .torn_at_byte
                .is_some_and(|end| self.records.position().byte() >= end);
            let Some((row, finite)) = self.parse_record().filter(|_| !torn) else {
                if self.unreadable.rows == 0 {
                    self.first_unreadable = beginning(&self.record);
                }
                self.unreadable.count(line);
                continue;
            };
            if row.time_s() <= self.last_time_s {
                self.disordered.count(line);
                continue;
            }
            if !finite {
                self.not_finite.count(line);
            }
            self.last_time_s = row.time_s();
            self.rows += 1;
            return Some(Ok(row));
        }
    }
}

/// Returns the first 80 characters of a line, for messages.
fn beginning(record: &csv::ByteRecord) -> String {
    String::from_utf8_lossy(&record.iter().collect::<Vec<_>>().join(&b','))
        .chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .take(80)
        .collect()
}

/// Returns the file's length if its last byte ends no line; leaves the file at its start.
fn unended_last_line(file: &mut File) -> io::Result<Option<u64>> {
    let bytes = file.seek(SeekFrom::End(0))?;
    let mut last = [b'\n'];
    if bytes > 0 {
        file.seek(SeekFrom::End(-1))?;
        file.read_exact(&mut last)?;
        file.seek(SeekFrom::Start(0))?;
    }
    Ok((last != [b'\n']).then_some(bytes))
}
