//! Checks that the files of one recording exist, are unchanged and agree with each other.

use std::path::Path;
use std::sync::Arc;

use crate::defect::RecordingDefect;
use recording::manifest::{End, EventKind, Manifest, RecordedIntervalKind};
use recording::reader::{ReadError, RecordingReader, RowReader, Warning};
use recording::storage::FileSystem;
use recording::sums::{FILES, Summing, Sums};
use recording::wav::WavWarning;
use recording::{FORCE_FILE, POSITION_FILE};

/// Frames per read.
const BLOCK_FRAMES: usize = 1 << 14;
/// Longest gap in the readings of a continuously sending sensor within an exploration, s.
const LONGEST_GAP_S: f64 = 0.5;
/// Bytes hashed per read.
const SUM_BYTES: usize = 1 << 24;

/// Result of checking a recording's files.
#[derive(Debug, Default)]
pub struct RecordingCheck {
    /// Defects of the recording.
    pub defects: Vec<RecordingDefect>,
    /// Notes that are not defects.
    pub notes: Vec<String>,
    /// Parts of explorations without readings of a sensor; defects if the trial was accepted.
    pub not_covered: Vec<RecordingDefect>,
    /// Description, if it can be read.
    pub manifest: Option<Manifest>,
}

/// Checks the files in `folder` against each other, and against `sums` if the log has sums.
#[must_use]
pub fn check(folder: &Path, sums: Option<&Sums>) -> RecordingCheck {
    let mut found = RecordingCheck::default();
    for file in FILES {
        if !folder.join(file).is_file() {
            let file = file.to_owned();
            found.defects.push(RecordingDefect::NoFile { file });
        }
    }
    // Any further defects would follow from these.
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
        let hardware = manifest.hardware.as_ref();
        let has_force = hardware.is_some_and(|of| of.force_sensor.is_some());
        let has_position = hardware.is_some_and(|of| of.position_sensor.is_some());
        let (said, force) = rows(reader.force()?, &manifest, FORCE_FILE)?;
        warnings.extend(said);
        let (said, position) = rows(reader.position()?, &manifest, POSITION_FILE)?;
        warnings.extend(said);
        self.not_covered.extend(force.filter(|_| has_force));
        self.not_covered.extend(position.filter(|_| has_position));
        for warning in warnings {
            let marked = |kind| manifest.events.iter().any(|event| event.kind == kind);
            let wrong = match &warning {
                // The sensor was absent, or did not know its position for a while.
                Warning::NoRows { .. } | Warning::NotFinite { .. } => continue,
                Warning::TimeDisorder { .. } => !marked(EventKind::TimeDisorder),
                // Interrupted before any data arrived, or before the end of a marked interval.
                Warning::Signals(WavWarning::Empty) | Warning::IntervalBeyondEnd { .. } => {
                    end == Some(End::Completed)
                }
                // After a freeze, the program reads its sensors before its card continues, and stops.
                Warning::OutsideRecording {
                    from_s, duration_s, ..
                } if from_s > duration_s => end == Some(End::Completed),
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

    /// Compares the lost frames of the audio with the events that report them.
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
            // The events of a killed program extend beyond its audio.
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

/// Reads all rows. Returns their warnings, and the longest part of an exploration without rows, if it exceeds
/// [`LONGEST_GAP_S`] and no event of the recording explains it.
fn rows<R: recording::CsvRow>(
    mut rows: RowReader<R>,
    manifest: &Manifest,
    file: &'static str,
) -> Result<(Vec<Warning>, Option<RecordingDefect>), ReadError> {
    let explorations = manifest.intervals.iter();
    let mut explorations: Vec<(f64, f64)> = explorations
        .filter(|interval| matches!(interval.kind, RecordedIntervalKind::Exploration(_)))
        .map(|interval| (interval.start_s, interval.end_s))
        .collect();
    explorations.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Time up to which each exploration has rows, and its longest part without rows.
    let mut reached: Vec<f64> = explorations.iter().map(|of| of.0).collect();
    let mut longest: Option<(f64, f64)> = None;
    let mut gap = |from_s: f64, to_s: f64| {
        let longer = longest.is_none_or(|(from, to)| to_s - from_s > to - from);
        if to_s - from_s > LONGEST_GAP_S && longer {
            longest = Some((from_s, to_s));
        }
    };
    for row in rows.by_ref() {
        let time_s = row?.time_s();
        for ((start_s, end_s), reached_s) in explorations.iter().zip(&mut reached) {
            if (*start_s..=*end_s).contains(&time_s) {
                gap(*reached_s, time_s);
                *reached_s = time_s;
            }
        }
    }
    for ((_, end_s), reached_s) in explorations.iter().zip(&reached) {
        gap(*reached_s, *end_s);
    }
    let lost = [
        EventKind::ForceLost,
        EventKind::Gap,
        EventKind::TimeDisorder,
    ];
    let told = manifest.events.iter().any(|of| lost.contains(&of.kind));
    let defect = longest
        .filter(|_| !told)
        .map(|(from_s, to_s)| RecordingDefect::NoRowsOf { file, from_s, to_s });
    Ok((rows.warnings(), defect))
}
