//! Streams of a recording, read in blocks from its files.

use std::path::{Path, PathBuf};

use recording::reader::{ReadError, RowReader};
use recording::{CsvRow, ForceRow, PositionRow, RecordingReader};

/// Values per block.
pub(crate) const BLOCK: usize = 1 << 14;

/// One quantity of a file of a recording. Each reading of it opens the file anew, so that no file is held in memory.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    recording: PathBuf,
    source: Source,
}

/// Source of a stream.
#[derive(Debug, Clone, Copy)]
enum Source {
    /// Channel of `signals.wav`; values are multiplied by `factor`.
    Channel { index: u16, factor: f64 },
    /// Column of `force.csv`.
    Force(fn(&ForceRow) -> f64),
    /// Column of `position.csv`.
    Position(fn(&PositionRow) -> f64),
}

impl Stream {
    pub(crate) fn channel(recording: &Path, index: u16, factor: f64) -> Self {
        Self::new(recording, Source::Channel { index, factor })
    }

    pub(crate) fn force(recording: &Path, value: fn(&ForceRow) -> f64) -> Self {
        Self::new(recording, Source::Force(value))
    }

    pub(crate) fn position(recording: &Path, value: fn(&PositionRow) -> f64) -> Self {
        Self::new(recording, Source::Position(value))
    }

    fn new(recording: &Path, source: Source) -> Self {
        Self {
            recording: recording.to_owned(),
            source,
        }
    }

    /// Returns whether its values have single precision, as audio samples do.
    pub(crate) fn is_single(&self) -> bool {
        matches!(self.source, Source::Channel { .. })
    }

    /// Opens its file.
    pub(crate) fn open(&self) -> Result<OpenStream, ReadError> {
        let reader = RecordingReader::open(&self.recording)?;
        Ok(match self.source {
            Source::Channel { index, factor } => OpenStream::Channel {
                channels: usize::from(reader.format().channels),
                reader: Box::new(reader),
                index: usize::from(index),
                factor,
                frames: Vec::new(),
            },
            Source::Force(value) => OpenStream::Force(Box::new(reader.force()?), value),
            Source::Position(value) => OpenStream::Position(Box::new(reader.position()?), value),
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
    /// Column of `force.csv`.
    Force(Box<RowReader<ForceRow>>, fn(&ForceRow) -> f64),
    /// Column of `position.csv`.
    Position(Box<RowReader<PositionRow>>, fn(&PositionRow) -> f64),
}

impl OpenStream {
    /// Replaces the content of `block` with the next values, at most [`BLOCK`]; none at the end.
    pub(crate) fn read(&mut self, block: &mut Vec<f64>) -> Result<(), ReadError> {
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
                Ok(())
            }
            Self::Force(rows, value) => read_rows(rows, *value, block),
            Self::Position(rows, value) => read_rows(rows, *value, block),
        }
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
    /// Reads all rows; `None` if there are none.
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
