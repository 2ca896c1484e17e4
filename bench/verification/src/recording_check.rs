//! Whether the files of one recording are there, as they were written, and agree with each other.

use std::path::Path;
use std::sync::Arc;

use crate::defect::RecordingDefect;
use recording::manifest::{End, EventKind, Manifest};
use recording::reader::{ReadError, RecordingReader, RowReader, Warning};
use recording::storage::FileSystem;
use recording::sums::{FILES, Summing, Sums};
use recording::wav::WavWarning;

/// Frames read at a time.
const BLOCK_FRAMES: usize = 1 << 14;
/// Bytes summed at a time.
const SUM_BYTES: usize = 1 << 24;

/// What a recording's files showed.
#[derive(Debug, Default)]
pub struct RecordingCheck {
    /// What is wrong.
    pub defects: Vec<RecordingDefect>,
    /// What is worth knowing.
    pub notes: Vec<String>,
    /// The description, if it can be read.
    pub manifest: Option<Manifest>,
}

/// Checks the files in `folder` against each other, and against `sums` if the log has any.
#[must_use]
pub fn check(folder: &Path, sums: Option<&Sums>) -> RecordingCheck {
    let mut found = RecordingCheck::default();
    for file in FILES {
        if !folder.join(file).is_file() {
            let file = file.to_owned();
            found.defects.push(RecordingDefect::NoFile { file });
        }
    }
    // What else is wrong follows from it.
    if !found.defects.is_empty() {
        return found;
    }
    if let Some(sums) = sums {
        found.compare(folder, sums);
    }
    if let Err(error) = found.read(folder) {
        found.defects.push(RecordingDefect::Unreadable {
            reason: error.to_string(),
        });
    }
    found
}

impl RecordingCheck {
    fn compare(&mut self, folder: &Path, sums: &Sums) {
        let mut summing = Summing::new(Arc::new(FileSystem), folder);
        let summed = loop {
            match summing.advance(SUM_BYTES) {
                Ok(_) => match summing.sums() {
                    Some(sums) => break sums,
                    None => continue,
                },
                Err(error) => {
                    let reason = error.to_string();
                    self.defects.push(RecordingDefect::Unreadable { reason });
                    return;
                }
            }
        };
        let differ = sums
            .iter()
            .filter(|(file, sum)| summed.get(*file) != Some(*sum));
        self.defects
            .extend(differ.map(|(file, _)| RecordingDefect::SumDiffers { file: file.clone() }));
    }

    fn read(&mut self, folder: &Path) -> Result<(), ReadError> {
        let mut reader = RecordingReader::open(folder)?;
        let manifest = reader.manifest().clone();
        let end = manifest.trial.as_ref().and_then(|trial| trial.end);
        let mut warnings = reader.warnings().to_vec();
        self.lost_frames(&mut reader, &manifest, end.is_some())?;
        warnings.extend(rows(reader.force()?)?);
        warnings.extend(rows(reader.position()?)?);
        for warning in warnings {
            let marked = |kind| manifest.events.iter().any(|event| event.kind == kind);
            let wrong = match &warning {
                // A sensor that is not there, or whose position is not known for a while.
                Warning::NoRows { .. } | Warning::NotFinite { .. } => continue,
                Warning::TimeDisorder { .. } => !marked(EventKind::TimeDisorder),
                // Broken off before anything came, or before what was marked.
                Warning::Signals(WavWarning::Empty) | Warning::IntervalBeyondEnd { .. } => {
                    end == Some(End::Completed)
                }
                // A killed program leaves such recordings.
                _ => end.is_some(),
            };
            let warning = warning.to_string();
            if wrong {
                self.defects.push(RecordingDefect::Warned { warning });
            } else {
                self.notes.push(warning);
            }
        }
        self.manifest = Some(manifest);
        Ok(())
    }

    /// Compares the lost frames of the audio with the events that say so.
    fn lost_frames(
        &mut self,
        reader: &mut RecordingReader,
        manifest: &Manifest,
        ended: bool,
    ) -> Result<(), ReadError> {
        let events = manifest.events.iter();
        let mut gaps: Vec<(u64, u64)> = events
            .filter(|event| event.kind == EventKind::Gap)
            .map(|event| (event.sample, event.frames.unwrap_or(0)))
            .collect();
        gaps.sort_unstable();
        let channels = usize::from(reader.format().channels);
        let (mut block, mut frame, mut unexplained) = (Vec::new(), 0, 0);
        let mut lost_in = vec![0; gaps.len()];
        let mut gap = 0;
        while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
            for samples in block.chunks_exact(channels) {
                while gaps
                    .get(gap)
                    .is_some_and(|(at, frames)| frame >= at + frames)
                {
                    gap += 1;
                }
                if samples.iter().all(|sample| sample.is_nan()) {
                    match gaps.get(gap) {
                        Some((at, _)) if frame >= *at => lost_in[gap] += 1,
                        _ => unexplained += 1,
                    }
                }
                frame += 1;
            }
        }
        for ((sample, frames), lost) in gaps.into_iter().zip(lost_in) {
            // The events of a killed program reach further than its audio.
            if lost != frames && ended {
                self.defects
                    .push(RecordingDefect::GapWithSamples { sample, frames });
            }
        }
        let of_the_converter = manifest
            .events
            .iter()
            .any(|event| event.kind == EventKind::NonFinite);
        if unexplained > 0 && !of_the_converter && ended {
            self.defects.push(RecordingDefect::UnexplainedLoss {
                frames: unexplained,
            });
        }
        Ok(())
    }
}

/// Reads rows to their end for what they warn of.
fn rows<R: recording::CsvRow>(mut rows: RowReader<R>) -> Result<Vec<Warning>, ReadError> {
    for row in rows.by_ref() {
        row?;
    }
    Ok(rows.warnings())
}
