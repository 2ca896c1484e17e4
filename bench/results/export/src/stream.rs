//! Streams of a recording, read in blocks from its files.

use std::path::{Path, PathBuf};

use envelope_files::{EnvelopeReader, EnvelopeRow};
use recording::reader::{ReadError, RowReader, force_rows, position_rows, stimulus_rows};
use recording::{CsvRow, ENVELOPES_FILE, ForceRow, PositionRow, RecordingReader, StimulusRow};

use crate::fill_error::FillError;

/// Values per block.
pub(crate) const BLOCK: usize = 1 << 14;

/// One quantity of a file of a recording. Each reading of it opens the file anew, so that no file is held in memory.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    recording: PathBuf,
    source: StreamSource,
}

/// Source of a stream.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StreamSource {
    /// Channel of `signals.wav`; values are multiplied by `factor`.
    Channel { index: u16, factor: f64 },
    /// Column of `envelopes.parquet`.
    Envelopes(fn(&EnvelopeRow) -> f64),
    /// Column of `force.csv`, in a recording of this length, s.
    Force(fn(&ForceRow) -> f64, f64),
    /// Column of `position.csv`, likewise.
    Position(fn(&PositionRow) -> f64, f64),
    /// Column of `stimulus.csv`, likewise.
    Stimulus(fn(&StimulusRow) -> f64, f64),
}

impl Stream {
    pub(crate) fn new(recording: &Path, source: StreamSource) -> Self {
        Self {
            recording: recording.to_owned(),
            source,
        }
    }

    /// Returns whether its values have single precision, as audio samples do.
    pub(crate) fn is_single(&self) -> bool {
        matches!(self.source, StreamSource::Channel { .. })
    }

    /// Opens its file.
    pub(crate) fn open(&self) -> Result<OpenStream, FillError> {
        let folder = &self.recording;
        Ok(match self.source {
            StreamSource::Channel { index, factor } => {
                let reader = RecordingReader::open(folder)?;
                OpenStream::Channel {
                    channels: usize::from(reader.format().channels),
                    reader: Box::new(reader),
                    index: usize::from(index),
                    factor,
                    frames: Vec::new(),
                }
            }
            StreamSource::Envelopes(value) => {
                let reader = EnvelopeReader::open(&folder.join(ENVELOPES_FILE))?;
                OpenStream::Envelopes(Box::new(reader), value)
            }
            StreamSource::Force(value, duration_s) => {
                OpenStream::Force(Box::new(force_rows(folder, duration_s)?), value)
            }
            StreamSource::Position(value, duration_s) => {
                OpenStream::Position(Box::new(position_rows(folder, duration_s)?), value)
            }
            StreamSource::Stimulus(value, duration_s) => {
                OpenStream::Stimulus(Box::new(stimulus_rows(folder, duration_s)?), value)
            }
        })
    }
}

/// Stream that is being read.
pub(crate) enum OpenStream {
    /// Channel of `signals.wav`.
    Channel {
        reader: Box<RecordingReader>,
        channels: usize,
        index: usize,
        factor: f64,
        frames: Vec<f32>,
    },
    /// Column of `envelopes.parquet`.
    Envelopes(Box<EnvelopeReader>, fn(&EnvelopeRow) -> f64),
    /// Column of `force.csv`.
    Force(Box<RowReader<ForceRow>>, fn(&ForceRow) -> f64),
    /// Column of `position.csv`.
    Position(Box<RowReader<PositionRow>>, fn(&PositionRow) -> f64),
    /// Column of `stimulus.csv`.
    Stimulus(Box<RowReader<StimulusRow>>, fn(&StimulusRow) -> f64),
}

impl OpenStream {
    /// Replaces the content of `block` with the next values: [`BLOCK`] of them, fewer only at the end.
    pub(crate) fn read(&mut self, block: &mut Vec<f64>) -> Result<(), FillError> {
        block.clear();
        match self {
            Self::Channel {
                reader,
                channels,
                index,
                factor,
                frames,
            } => {
                reader.read_block(BLOCK, frames)?;
                let samples = frames.iter().skip(*index).step_by(*channels);
                block.extend(samples.map(|sample| f64::from(*sample) * *factor));
            }
            Self::Envelopes(reader, value) => {
                let mut rows = Vec::new();
                while rows.len() < BLOCK && reader.read(BLOCK - rows.len(), &mut rows)? > 0 {}
                block.extend(rows.iter().map(*value));
            }
            Self::Force(rows, value) => read_rows(rows, *value, block)?,
            Self::Position(rows, value) => read_rows(rows, *value, block)?,
            Self::Stimulus(rows, value) => read_rows(rows, *value, block)?,
        }
        Ok(())
    }
}

fn read_rows<R: CsvRow>(
    rows: &mut RowReader<R>,
    value: fn(&R) -> f64,
    block: &mut Vec<f64>,
) -> Result<(), ReadError> {
    for row in rows.by_ref().take(BLOCK) {
        block.push(value(&row?));
    }
    Ok(())
}

/// Rows of a file: their number and times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowTimes {
    /// Number of rows.
    pub(crate) rows: u64,
    /// Time of the first row, s.
    pub(crate) first_s: f64,
    /// Rate of the rows, Hz: the reciprocal of the median time between the first ten thousand.
    pub(crate) rate_hz: f64,
}

/// Most differences of time of which the median is taken.
const MOST_DIFFERENCES: usize = 10_000;

impl RowTimes {
    /// Reads all rows; `None` without rows.
    pub(crate) fn read<R: CsvRow>(rows: RowReader<R>) -> Result<Option<Self>, ReadError> {
        let (mut count, mut first_s, mut last_s) = (0, 0.0, 0.0);
        let mut differences_s = Vec::new();
        for row in rows {
            let time_s = row?.time_s();
            if count == 0 {
                first_s = time_s;
            } else if differences_s.len() < MOST_DIFFERENCES {
                differences_s.push(time_s - last_s);
            }
            last_s = time_s;
            count += 1;
        }
        differences_s.sort_by(f64::total_cmp);
        let median_s = differences_s.get(differences_s.len() / 2);
        Ok((count > 0).then_some(Self {
            rows: count,
            first_s,
            rate_hz: median_s.map_or(f64::NAN, |median_s| 1.0 / median_s),
        }))
    }
}
