//! Recording as a source of batches, in place of the sound card and the sensors.

use std::path::Path;

use anyhow::Context;

use analysis::vibration::Vibration;
use recording::manifest::Manifest;
use recording::pipeline::{Batch, Pipeline};
use recording::reader::{ReadError, RowReader, Warning};
use recording::{ForceRow, PositionRow, RecordingReader};

/// Frames of audio per read.
const BLOCK_FRAMES: usize = 4096;

/// Audio through the live pipeline, with the sensor rows of the same time.
pub struct Source {
    reader: RecordingReader,
    vibration: Vibration,
    pipeline: Pipeline,
    force: Rows<ForceRow>,
    position: Rows<PositionRow>,
    block: Vec<f32>,
    ended: bool,
}

impl Source {
    /// Opens the recording in `folder`.
    ///
    /// # Errors
    /// If a file is missing or violates the format, or the audio cannot be demodulated as the manifest says.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        let reader = RecordingReader::open(folder)?;
        let pipeline = Pipeline::from_recording(reader.manifest(), reader.format())
            .context("the recording cannot be demodulated")?;
        let vibration = Vibration::stated(reader.manifest())
            .context("the recording has no carrier, and a replay needs one")?;
        Ok(Self {
            force: Rows::new(reader.force()?)?,
            position: Rows::new(reader.position()?)?,
            reader,
            vibration,
            pipeline,
            block: Vec::new(),
            ended: false,
        })
    }

    /// Returns the manifest of the recording.
    pub fn manifest(&self) -> &Manifest {
        self.reader.manifest()
    }

    /// Returns the vibration of the plate.
    pub fn vibration(&self) -> &Vibration {
        &self.vibration
    }

    /// Returns the sampling rate of the file's header, Hz.
    pub fn header_rate_hz(&self) -> u32 {
        self.reader.format().sample_rate_hz
    }

    /// Returns the sampling rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.reader.rate_hz()
    }

    /// Returns the length of the recording, s.
    pub fn duration_s(&self) -> f64 {
        self.reader.duration_s()
    }

    /// Whether everything has been read.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Returns the defects found so far in the recording.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.reader.warnings().to_vec();
        warnings.extend(self.force.rows.warnings());
        warnings.extend(self.position.rows.warnings());
        warnings
    }

    /// Reads on to `until_s` of the recording.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn read_until(&mut self, until_s: f64) -> anyhow::Result<Batch> {
        let mut batch = Batch::default();
        let end_frame = (until_s * self.pipeline.rate_hz()) as u64;
        while !self.ended {
            let missing_frames = end_frame.saturating_sub(self.pipeline.account().frames);
            if missing_frames == 0 {
                break;
            }
            let block = usize::try_from(missing_frames)
                .map_or(BLOCK_FRAMES, |frames| frames.min(BLOCK_FRAMES));
            self.ended = self.reader.read_block(block, &mut self.block)? == 0;
            self.pipeline
                .process_recorded(&self.block, &mut batch.frames)?;
        }
        batch.audio_s = self.pipeline.audio_s();
        batch.account = self.pipeline.account();
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

/// Rows of a file, with one row of look-ahead.
struct Rows<R> {
    rows: RowReader<R>,
    next: Option<R>,
}

/// A row with a time.
trait Timed {
    fn time_s(&self) -> f64;
}

impl Timed for ForceRow {
    fn time_s(&self) -> f64 {
        self.time_s
    }
}

impl Timed for PositionRow {
    fn time_s(&self) -> f64 {
        self.time_s
    }
}

impl<R: Timed> Rows<R>
where
    RowReader<R>: Iterator<Item = Result<R, ReadError>>,
{
    fn new(mut rows: RowReader<R>) -> Result<Self, ReadError> {
        let next = rows.next().transpose()?;
        Ok(Self { rows, next })
    }

    fn take_until(&mut self, until_s: f64, output: &mut Vec<R>) -> Result<(), ReadError> {
        while let Some(row) = self.next.take_if(|row| row.time_s() <= until_s) {
            output.push(row);
            self.next = self.rows.next().transpose()?;
        }
        Ok(())
    }
}
