//! Checks that the files of one recording exist, are unchanged and agree with each other.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use bounded_files::ContentStore;

use crate::verification::defect::RecordingDefect;
use envelope_files::{EnvelopeError, EvenRows};
use recording::manifest::{Archived, End, EventKind, Manifest, RecordedIntervalKind, Streams};
use recording::reader::{
    ReadError, RecordingReader, RowReader, Warning, force_rows, position_rows, read_manifest,
    required_file,
};
use recording::storage::FileSystem;
use recording::sums::{FILES, Summation, Sums, file_sum, text_sum};
use recording::{
    ENVELOPES_FILE, FORCE_FILE, MANIFEST_FILE, OTHER_FILES, POSITION_FILE, SIGNALS_FILE, table_path,
};
use wav_files::WavWarning;

/// Frames per read.
const BLOCK_FRAMES: usize = 1 << 14;
/// Longest gap in the readings of a continuously sending sensor within an exploration, s.
const LONGEST_GAP_S: f64 = 0.5;
/// Events that explain missing rows.
const LOSS_KINDS: [EventKind; 3] = [
    EventKind::ForceLost,
    EventKind::Gap,
    EventKind::TimeDisorder,
];
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
    let mut check = RecordingCheck::default();
    let required = required_files(folder);
    for file in FILES.into_iter().chain(OTHER_FILES) {
        let path = folder.join(file);
        let store = ContentStore::find(&path);
        if store.is_some() || (required.contains(&file) && !path.is_file()) {
            let reason = store.map_or_else(String::new, |store| format!(": {store}"));
            let file = file.to_owned();
            check.defects.push(RecordingDefect::NoFile { file, reason });
        }
    }
    check.notes.extend(other_files(folder));
    let manifest = read_manifest(folder).ok();
    let archived = manifest.as_ref().and_then(Manifest::archived);
    // Any further defects would follow from these, but for the changes of the files that are there.
    if !check.defects.is_empty() {
        if archived.is_none() {
            let present = sums.into_iter().flatten();
            let present = present.filter(|(file, _)| folder.join(file).is_file());
            check.compare_present(folder, present);
        }
        return check;
    }
    match (archived, sums) {
        (Some(archived), sums) => check.compare_archived(folder, archived, sums),
        (None, Some(sums)) => check.compare(folder, sums),
        (None, None) => {}
    }
    if let Err(error) = check.read(folder) {
        check.defects.push(RecordingDefect::Unreadable {
            reason: error.to_string(),
        });
    }
    check
}

/// Returns the files that a recording cannot lack: all that the bench writes, or of a recording made elsewhere those that its
/// description needs.
fn required_files(folder: &Path) -> Vec<&'static str> {
    match read_manifest(folder) {
        Ok(manifest) if manifest.hardware.is_none() || manifest.archived().is_some() => {
            vec![MANIFEST_FILE, required_file(&manifest.streams)]
        }
        _ => FILES.to_vec(),
    }
}

/// Returns the defect of a file whose sum differs from the one in the log.
fn differing(folder: &Path, file: &str, sum: &str) -> RecordingDefect {
    let text_sum = text_sum(&folder.join(file)).ok();
    let is_text = file != SIGNALS_FILE && text_sum.as_deref() == Some(sum);
    let file = file.to_owned();
    if is_text {
        RecordingDefect::LineEndsDiffer { file }
    } else {
        RecordingDefect::SumDiffers { file }
    }
}

/// Files that nothing reads but that belong: the figure of an import, and what the systems' own programs leave.
const IGNORED_FILES: [&str; 4] = ["import.svg", ".DS_Store", "Thumbs.db", "desktop.ini"];

/// Returns the note of files in a recording's folder that are of no recording, such as the copies that sync programs make.
fn other_files(folder: &Path) -> Option<String> {
    let entries = fs::read_dir(folder).ok()?.filter_map(Result::ok);
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let is_known = |name: &str| {
        let mut known = FILES.iter().chain(&OTHER_FILES).chain(&IGNORED_FILES);
        known.any(|file| *file == name)
    };
    let mut others: Vec<String> = names.filter(|name| !is_known(name)).collect();
    others.sort();
    let (first, rest) = others.split_first()?;
    let first = escaping::escaped_line(first);
    Some(match rest.len() {
        0 => format!("{first} is no file of a recording: nothing reads it"),
        more => format!("{first} and {more} more are no files of a recording: nothing reads them"),
    })
}

impl RecordingCheck {
    /// Compares files with their sums in the log one by one.
    fn compare_present<'a>(
        &mut self,
        folder: &Path,
        sums: impl Iterator<Item = (&'a String, &'a String)>,
    ) {
        for (file, sum) in sums {
            if file_sum(&folder.join(file)).is_ok_and(|(_, actual)| actual != *sum) {
                let defect = differing(folder, file, sum);
                self.defects.push(defect);
            }
        }
    }

    /// Compares the files of an archive with their sums in it, and the sums of the originals with those of the log.
    fn compare_archived(&mut self, folder: &Path, archived: &Archived, sums: Option<&Sums>) {
        for file in &archived.files {
            let path = folder.join(&file.file);
            match file_sum(&path) {
                Ok((_, sum)) if sum == file.sha256 => {}
                Ok(_) => {
                    let file = file.file.clone();
                    self.defects
                        .push(RecordingDefect::ArchivedSumDiffers { file });
                }
                Err(error) => self.defects.push(RecordingDefect::NoFile {
                    file: file.file.clone(),
                    reason: match path.exists() {
                        true => format!(": {}", bounded_files::cause(&error)),
                        false => String::new(),
                    },
                }),
            }
        }
        let logged = sums.into_iter().flatten();
        for (name, sum) in logged {
            let original = archived.originals.iter().find(|file| file.file == *name);
            if original.is_some_and(|original| original.sha256 != *sum) {
                self.defects
                    .push(RecordingDefect::OriginalDiffers { file: name.clone() });
            }
        }
        self.notes.push(format!(
            "archived by version {}: the samples are not here, and the sums are those of the archive's files",
            archived.version
        ));
    }

    fn compare(&mut self, folder: &Path, sums: &Sums) {
        let mut summing = Summation::new(Arc::new(FileSystem), folder);
        let actual_sums = loop {
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
        let differences = sums
            .iter()
            .filter(|(file, sum)| actual_sums.get(*file) != Some(*sum));
        self.defects
            .extend(differences.map(|(file, sum)| differing(folder, file, sum)));
    }

    fn read(&mut self, folder: &Path) -> Result<(), ReadError> {
        let manifest = read_manifest(folder)?;
        let end = manifest.trial.as_ref().and_then(|trial| trial.end);
        let mut warnings = Vec::new();
        let duration_s = match &manifest.streams {
            Streams::Signals(_) => {
                let mut reader = RecordingReader::open(folder)?;
                warnings.extend_from_slice(reader.warnings());
                self.lost_frames(&mut reader, &manifest, end.is_some())?;
                reader.duration_s()
            }
            Streams::Envelopes(_) => match envelopes_end_s(folder) {
                Ok(end_s) => manifest
                    .archived()
                    .map_or(end_s, |archived| archived.duration_s),
                Err(error) => {
                    let reason = error.to_string();
                    self.defects.push(RecordingDefect::Unreadable { reason });
                    return Ok(());
                }
            },
            // Only its rows tell the length of a recording of forces alone.
            Streams::Forces(_) => f64::INFINITY,
        };
        let hardware = manifest.hardware.as_ref();
        let has_force = hardware.is_some_and(|hardware| hardware.force_sensor.is_some());
        let has_position = hardware.is_some_and(|hardware| hardware.position_sensor.is_some());
        let duration_s = manifest.own_duration_s(duration_s);
        let force = present(folder, FORCE_FILE).then(|| force_rows(folder, duration_s));
        let (row_warnings, force) = rows(force.transpose()?, &manifest, FORCE_FILE)?;
        warnings.extend(row_warnings);
        let position = present(folder, POSITION_FILE).then(|| position_rows(folder, duration_s));
        let (row_warnings, position) = rows(position.transpose()?, &manifest, POSITION_FILE)?;
        warnings.extend(row_warnings);
        self.not_covered.extend(force.filter(|_| has_force));
        self.not_covered.extend(position.filter(|_| has_position));
        for warning in warnings {
            let has_event = |kind| manifest.events.iter().any(|event| event.kind == kind);
            let is_defect = match &warning {
                // The sensor was absent, or did not know its position for a while.
                Warning::NoRows { .. } | Warning::NotFinite { .. } => continue,
                Warning::TimeDisorder { .. } => !has_event(EventKind::TimeDisorder),
                // Interrupted before any data arrived, or before the end of a marked interval.
                Warning::Signals(WavWarning::Empty) | Warning::IntervalBeyondEnd { .. } => {
                    end == Some(End::Completed)
                }
                // After a freeze, the program reads its sensors before its card continues, and stops.
                Warning::OutsideRecording {
                    from_s, duration_s, ..
                } if from_s > duration_s => end == Some(End::Completed),
                Warning::EndsEarly { .. } => {
                    end == Some(End::Completed) && !LOSS_KINDS.into_iter().any(has_event)
                }
                // A killed program leaves such recordings.
                _ => end.is_some(),
            };
            let warning = warning.to_string();
            if is_defect {
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
        has_end: bool,
    ) -> Result<(), ReadError> {
        let events = manifest.events.iter();
        let mut gaps: Vec<(u64, u64)> = events
            .filter(|event| event.kind == EventKind::Gap)
            .map(|event| (event.sample, event.frames.unwrap_or(0)))
            .collect();
        gaps.sort_unstable();
        let channels = usize::from(reader.format().channels);
        let (mut block, mut frame, mut n_unexplained) = (Vec::new(), 0, 0);
        let mut lost_counts = vec![0; gaps.len()];
        let mut gap = 0;
        while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
            for samples in block.chunks_exact(channels) {
                while gaps
                    .get(gap)
                    .is_some_and(|(sample, frames)| frame >= sample + frames)
                {
                    gap += 1;
                }
                if samples.iter().all(|sample| sample.is_nan()) {
                    match gaps.get(gap) {
                        Some((sample, _)) if frame >= *sample => lost_counts[gap] += 1,
                        _ => n_unexplained += 1,
                    }
                }
                frame += 1;
            }
        }
        for ((sample, frames), n_lost) in gaps.into_iter().zip(lost_counts) {
            // The events of a killed program extend beyond its audio.
            if n_lost != frames && has_end {
                self.defects
                    .push(RecordingDefect::GapWithSamples { sample, frames });
            }
        }
        let has_non_finite = manifest
            .events
            .iter()
            .any(|event| event.kind == EventKind::NonFinite);
        if n_unexplained > 0 && !has_non_finite && has_end {
            self.defects.push(RecordingDefect::UnexplainedLoss {
                frames: n_unexplained,
            });
        }
        Ok(())
    }
}

fn present(folder: &Path, file: &str) -> bool {
    table_path(folder, file).is_file()
}

/// Reads all envelopes, and returns the time of the last, s.
fn envelopes_end_s(folder: &Path) -> Result<f64, EnvelopeError> {
    let mut rows = EvenRows::open(&folder.join(ENVELOPES_FILE))?;
    let mut envelopes = Vec::new();
    while rows.read(&mut envelopes)? > 0 {
        envelopes.clear();
    }
    Ok(rows.end_s())
}

/// Reads all rows of a file that is there. Returns their warnings, and the longest part of an exploration without rows, if it exceeds
/// [`LONGEST_GAP_S`] and no event of the recording explains it.
fn rows<R: recording::CsvRow>(
    rows: Option<RowReader<R>>,
    manifest: &Manifest,
    file: &'static str,
) -> Result<(Vec<Warning>, Option<RecordingDefect>), ReadError> {
    let Some(mut rows) = rows else {
        return Ok((Vec::new(), None));
    };
    let explorations = manifest.intervals.iter();
    let mut explorations: Vec<(f64, f64)> = explorations
        .filter(|interval| matches!(interval.kind, RecordedIntervalKind::Exploration(_)))
        .map(|interval| (interval.start_s, interval.end_s))
        .collect();
    explorations.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Time up to which each exploration has rows, and its longest part without rows.
    let mut positions_s: Vec<f64> = explorations
        .iter()
        .map(|exploration| exploration.0)
        .collect();
    let mut longest_gap: Option<(f64, f64)> = None;
    let mut record_gap = |from_s: f64, to_s: f64| {
        let is_longer = longest_gap.is_none_or(|(from, to)| to_s - from_s > to - from);
        if to_s - from_s > LONGEST_GAP_S && is_longer {
            longest_gap = Some((from_s, to_s));
        }
    };
    for row in rows.by_ref() {
        let time_s = row?.time_s();
        for ((start_s, end_s), position_s) in explorations.iter().zip(&mut positions_s) {
            if (*start_s..=*end_s).contains(&time_s) {
                record_gap(*position_s, time_s);
                *position_s = time_s;
            }
        }
    }
    for ((_, end_s), position_s) in explorations.iter().zip(&positions_s) {
        record_gap(*position_s, *end_s);
    }
    let is_reported = manifest
        .events
        .iter()
        .any(|event| LOSS_KINDS.contains(&event.kind));
    let defect = longest_gap
        .filter(|_| !is_reported)
        .map(|(from_s, to_s)| RecordingDefect::NoRowsOf { file, from_s, to_s });
    Ok((rows.warnings(), defect))
}
