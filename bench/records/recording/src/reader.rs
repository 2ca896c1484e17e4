//! Reads recording folders as streams, including damaged ones: reads existing data and reports missing data.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use bounded_files::Refusal;

use crate::csv_rows::{CsvRow, ForceRow, PositionRow, StimulusRow};
use crate::manifest::{Manifest, ManifestReadError, Streams};
pub use crate::read_error::{ReadError, Warning};
pub use crate::rows::RowReader;
use crate::{
    ENVELOPES_FILE, FORCE_FILE, MANIFEST_FILE, POSITION_FILE, SIGNALS_FILE, STIMULUS_FILE,
};
use wav_files::{AudioFormat, WavError, WavReader};

/// Bytes of audio per read.
const BUFFER_BYTES: usize = 1 << 18;

/// Maximum size of `recording.toml`, bytes: the maximum numbers of events and intervals, with twice the usual length.
const MANIFEST_LIMIT_BYTES: u64 = 2 << 20;

/// Recording with raw signals, opened for reading; the audio is read in blocks. [`RecordingWriter`](crate::RecordingWriter) has an
/// example.
#[derive(Debug)]
pub struct RecordingReader {
    folder: PathBuf,
    manifest: Manifest,
    wav: WavReader<BufReader<File>>,
    rate_hz: f64,
    warnings: Vec<Warning>,
}

impl RecordingReader {
    /// Opens `recording.toml` and `signals.wav`.
    ///
    /// # Errors
    /// [`ReadError`] names the file and the fault; no content causes a panic.
    pub fn open(folder: &Path) -> Result<Self, ReadError> {
        let (manifest, manifest_text, manifest_file) = parse_manifest(folder)?;
        let path = folder.join(SIGNALS_FILE);
        if manifest.signals().is_none() {
            return Err(ReadError::NoSignals {
                path: folder.join(MANIFEST_FILE),
            });
        }
        let file = bounded_files::open(&path).map_err(|reason| {
            let path = path.clone();
            match bounded_files::refusal(&reason) {
                Some(Refusal::Elsewhere(store)) => ReadError::Wav {
                    path,
                    reason: WavError::Elsewhere(*store),
                },
                _ => ReadError::Io { path, reason },
            }
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
        let rate_hz = manifest
            .validate_audio(format.sample_rate_hz, format.channels)
            .map_err(|rule| ManifestReadError::with_line(rule, &manifest_text, &manifest_file))?;
        let duration_s = wav.frames() as f64 / rate_hz;
        manifest
            .validate_length(duration_s)
            .map_err(|rule| ManifestReadError::with_line(rule, &manifest_text, &manifest_file))?;
        let mut warnings: Vec<Warning> = wav_warnings.into_iter().map(Warning::from).collect();
        warnings.extend(Warning::of_description(&manifest, duration_s));
        Ok(Self {
            folder: folder.to_owned(),
            manifest,
            wav,
            rate_hz,
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

    /// Returns the sampling rate, Hz: that of `recording.toml` where it states one, as the header of a WAV file has a whole number.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Returns the sampling rate of the header and the number of channels.
    #[must_use]
    pub fn format(&self) -> AudioFormat {
        self.wav.format()
    }

    /// Returns the number of audio frames.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.wav.frames()
    }

    /// Returns the length of the audio, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.frames() as f64 / self.rate_hz
    }

    fn own_duration_s(&self) -> f64 {
        self.manifest.own_duration_s(self.duration_s())
    }

    /// Returns the defects of the description and the audio.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Replaces the content of `block` with the next frames, interleaved, at most `max_frames`; returns their number, 0
    /// at the end. NaN stays NaN.
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
        force_rows(&self.folder, self.own_duration_s())
    }

    /// Opens the rows of `position.csv`.
    ///
    /// # Errors
    /// The file or one of its columns is missing.
    pub fn position(&self) -> Result<RowReader<PositionRow>, ReadError> {
        position_rows(&self.folder, self.own_duration_s())
    }
}

/// Opens the rows of `force.csv` in the folder of a recording of `duration_s`, infinite if only its rows tell it.
///
/// # Errors
/// The file or one of its columns is missing.
pub fn force_rows(folder: &Path, duration_s: f64) -> Result<RowReader<ForceRow>, ReadError> {
    rows(folder, (FORCE_FILE, NO_FORCES), duration_s)
}

/// Opens the rows of `position.csv`, as [`force_rows`] those of the forces.
///
/// # Errors
/// The file or one of its columns is missing.
pub fn position_rows(folder: &Path, duration_s: f64) -> Result<RowReader<PositionRow>, ReadError> {
    rows(folder, (POSITION_FILE, NO_POSITIONS), duration_s)
}

/// Opens the rows of `stimulus.csv`, as [`force_rows`] those of the forces.
///
/// # Errors
/// The file or one of its columns is missing.
pub fn stimulus_rows(folder: &Path, duration_s: f64) -> Result<RowReader<StimulusRow>, ReadError> {
    rows(folder, (STIMULUS_FILE, NO_STIMULUS), duration_s)
}

fn rows<R: CsvRow>(
    folder: &Path,
    (file, remedy): (&'static str, &'static str),
    duration_s: f64,
) -> Result<RowReader<R>, ReadError> {
    RowReader::open(folder, file, duration_s).map_err(|error| error.or_absent(remedy))
}

/// Returns the file that a recording cannot lack, in addition to `recording.toml`.
#[must_use]
pub fn required_file(streams: &Streams) -> &'static str {
    match streams {
        Streams::Signals(_) => SIGNALS_FILE,
        Streams::Envelopes(_) => ENVELOPES_FILE,
        Streams::Forces(_) => FORCE_FILE,
    }
}

/// Remedy for a recording without forces.
const NO_FORCES: &str = "write the forces of the finger there, with the columns time_s,normal_n,lateral_n (docs/RECORDING.md)";
/// Remedy for a recording without positions, as without an encoder.
const NO_POSITIONS: &str = "without an encoder, write the positions of the motor or of the slider that the finger followed \
                            there, with the columns time_s,position_m (docs/RECORDING.md)";

/// Remedy for a recording without a stimulus.
const NO_STIMULUS: &str =
    "write the stimulus of the surface there, with the columns time_s,stimulus (docs/RECORDING.md)";

/// Reads and checks the `recording.toml` of a folder.
///
/// # Errors
/// The file is missing or violates a rule.
pub fn read_manifest(folder: &Path) -> Result<Manifest, ReadError> {
    parse_manifest(folder).map(|(manifest, _, _)| manifest)
}

/// Returns the manifest, its text, and the name of its file for errors.
fn parse_manifest(folder: &Path) -> Result<(Manifest, String, String), ReadError> {
    let path = folder.join(MANIFEST_FILE);
    let file = path.display().to_string();
    let text = bounded_files::read_text(&path, MANIFEST_LIMIT_BYTES)
        .map_err(|reason| ReadError::Io { path, reason })?;
    let manifest = Manifest::parse(&text, &file)?;
    Ok((manifest, text, file))
}
