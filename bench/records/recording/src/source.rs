//! Content of a recording, from its folder or from arrays in memory.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use wav_files::AudioFormat;

use crate::csv_rows::{CsvRow, ForceRow, PositionRow, StimulusRow};
use crate::manifest::Manifest;
use crate::read_error::{ReadError, Warning};
use crate::reader::{self, RecordingReader, RowReader};
use crate::recorded_arrays::{ArrayRows, RecordedArrays};

/// Place in results of a recording that has no folder.
const ARRAYS: &str = "arrays";

/// Recording from which an analysis reads, and the request to stop it.
#[derive(Debug, Clone, Copy)]
pub struct RecordingSource<'a> {
    content: Content<'a>,
    stop: Option<&'a AtomicBool>,
}

#[derive(Debug, Clone, Copy)]
enum Content<'a> {
    Folder(&'a Path),
    Arrays(&'a RecordedArrays<'a>),
}

impl<'a> RecordingSource<'a> {
    /// Creates the source of the recording in a folder.
    #[must_use]
    pub fn folder(folder: &'a Path) -> Self {
        Self {
            content: Content::Folder(folder),
            stop: None,
        }
    }

    /// Creates the source of a recording in memory.
    #[must_use]
    pub fn arrays(arrays: &'a RecordedArrays<'a>) -> Self {
        Self {
            content: Content::Arrays(arrays),
            stop: None,
        }
    }

    /// Returns the source with a request to stop: reading fails once it is set.
    #[must_use]
    pub fn with_stop(self, stop: &'a AtomicBool) -> Self {
        Self {
            stop: Some(stop),
            ..self
        }
    }

    /// Returns the folder, or the name of a recording without one.
    #[must_use]
    pub fn path(&self) -> &'a Path {
        match self.content {
            Content::Folder(folder) => folder,
            Content::Arrays(_) => Path::new(ARRAYS),
        }
    }

    /// Returns the recording in memory; `None` for a folder.
    #[must_use]
    pub fn in_memory(&self) -> Option<&'a RecordedArrays<'a>> {
        match self.content {
            Content::Folder(_) => None,
            Content::Arrays(arrays) => Some(arrays),
        }
    }

    /// Returns an error if the analysis was asked to stop.
    ///
    /// # Errors
    /// [`ReadError::Stopped`].
    pub fn require_running(&self) -> Result<(), ReadError> {
        match self.stop {
            Some(stop) if stop.load(Ordering::Relaxed) => Err(ReadError::Stopped),
            _ => Ok(()),
        }
    }

    /// Returns the description of the recording.
    ///
    /// # Errors
    /// `recording.toml` is missing or violates a rule.
    pub fn manifest(&self) -> Result<Manifest, ReadError> {
        self.require_running()?;
        match self.content {
            Content::Folder(folder) => reader::read_manifest(folder),
            Content::Arrays(arrays) => Ok(arrays.manifest().clone()),
        }
    }

    /// Opens the samples.
    ///
    /// # Errors
    /// As [`RecordingReader::open`].
    pub fn signals(&self) -> Result<SignalReader<'a>, ReadError> {
        let blocks = match self.content {
            Content::Folder(folder) => Blocks::File(Box::new(RecordingReader::open(folder)?)),
            Content::Arrays(arrays) => Blocks::Arrays { arrays, first: 0 },
        };
        Ok(SignalReader {
            source: *self,
            blocks,
        })
    }

    /// Opens the forces of a recording of `duration_s`; `None` if they were not recorded.
    ///
    /// # Errors
    /// As [`reader::force_rows`], unless its file does not exist.
    pub fn force(&self, duration_s: f64) -> Result<Option<Rows<'a, ForceRow>>, ReadError> {
        match self.content {
            Content::Folder(folder) => file_rows(reader::force_rows(folder, duration_s)),
            Content::Arrays(arrays) => Ok(arrays.force(duration_s).map(Rows::Arrays)),
        }
    }

    /// Opens the positions of a recording of `duration_s`; `None` if they were not recorded.
    ///
    /// # Errors
    /// As [`reader::position_rows`], unless its file does not exist.
    pub fn position(&self, duration_s: f64) -> Result<Option<Rows<'a, PositionRow>>, ReadError> {
        match self.content {
            Content::Folder(folder) => file_rows(reader::position_rows(folder, duration_s)),
            Content::Arrays(arrays) => Ok(arrays.position(duration_s).map(Rows::Arrays)),
        }
    }

    /// Opens the stimulus of a surface; `None` if it was not recorded.
    ///
    /// # Errors
    /// As [`reader::stimulus_rows`], unless its file does not exist.
    pub fn stimulus(&self, duration_s: f64) -> Result<Option<Rows<'a, StimulusRow>>, ReadError> {
        match self.content {
            Content::Folder(folder) => file_rows(reader::stimulus_rows(folder, duration_s)),
            Content::Arrays(_) => Ok(None),
        }
    }
}

/// Returns the rows of a file; `None` if it does not exist.
fn file_rows<'a, R>(
    rows: Result<RowReader<R>, ReadError>,
) -> Result<Option<Rows<'a, R>>, ReadError> {
    match rows {
        Ok(rows) => Ok(Some(Rows::File(Box::new(rows)))),
        Err(ReadError::Absent { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Drive and pickup of a recording, read in blocks.
#[derive(Debug)]
pub struct SignalReader<'a> {
    source: RecordingSource<'a>,
    blocks: Blocks<'a>,
}

#[derive(Debug)]
enum Blocks<'a> {
    File(Box<RecordingReader>),
    Arrays {
        arrays: &'a RecordedArrays<'a>,
        first: usize,
    },
}

impl SignalReader<'_> {
    /// Returns the description of the recording.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        match &self.blocks {
            Blocks::File(reader) => reader.manifest(),
            Blocks::Arrays { arrays, .. } => arrays.manifest(),
        }
    }

    /// Returns the whole sampling rate next to the exact one, and the number of channels.
    #[must_use]
    pub fn format(&self) -> AudioFormat {
        match &self.blocks {
            Blocks::File(reader) => reader.format(),
            Blocks::Arrays { arrays, .. } => arrays.format(),
        }
    }

    /// Returns the sampling rate, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        match &self.blocks {
            Blocks::File(reader) => reader.rate_hz(),
            Blocks::Arrays { arrays, .. } => arrays.rate_hz(),
        }
    }

    /// Returns the length of the signals, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match &self.blocks {
            Blocks::File(reader) => reader.duration_s(),
            Blocks::Arrays { arrays, .. } => arrays.duration_s(),
        }
    }

    /// Returns the defects of the description and the samples.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        match &self.blocks {
            Blocks::File(reader) => reader.warnings().to_vec(),
            Blocks::Arrays { arrays, .. } => {
                Warning::of_description(arrays.manifest(), arrays.duration_s())
            }
        }
    }

    /// Replaces the content of `block` with the next frames, interleaved, at most `max_frames`; returns their number, 0
    /// at the end. NaN stays NaN.
    ///
    /// # Errors
    /// The operating system refused, or the analysis was asked to stop.
    pub fn read_block(
        &mut self,
        max_frames: usize,
        block: &mut Vec<f32>,
    ) -> Result<usize, ReadError> {
        self.source.require_running()?;
        match &mut self.blocks {
            Blocks::File(reader) => reader.read_block(max_frames, block),
            Blocks::Arrays { arrays, first } => {
                let count = arrays.read_block(*first, max_frames, block);
                *first += count;
                Ok(count)
            }
        }
    }
}

/// Rows of a sensor, with increasing times.
#[derive(Debug)]
pub enum Rows<'a, R> {
    /// Rows of a file.
    File(Box<RowReader<R>>),
    /// Rows of arrays.
    Arrays(ArrayRows<'a, R>),
}

impl<R: CsvRow> Rows<'_, R> {
    /// Returns the defects of the rows so far; complete once the iterator has ended.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        match self {
            Self::File(rows) => rows.warnings(),
            Self::Arrays(rows) => rows.warnings(),
        }
    }
}

impl<R: CsvRow> Iterator for Rows<'_, R> {
    type Item = Result<R, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Self::File(rows) => rows.next(),
            Self::Arrays(rows) => rows.next().map(Ok),
        }
    }
}
