//! Export of a study: its recordings, chosen as an analysis chooses them, and the files of the whole study.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use attempts::find::{self, TrialFilter};
use attempts::{Attempts, OmittedAttempt, missed_lines};
use clap::Args;
use rayon::prelude::*;
use study::exclusions::study_of;

use crate::content::RecordingContent;
use crate::dictionary::DictionaryEntry;
use crate::export_error::ExportError;
use crate::export_format::ExportFormat;
use crate::export_origin::ExportOrigin;
use crate::identity::RecordingIdentity;
use crate::target_folder::{FileState, TargetFolder};
use crate::{bids, csv_tables, mat, npz};

/// `export`
#[derive(Debug, Args)]
pub struct ExportOptions {
    /// Study of which the accepted trials are exported; or a participant, a session or a recording of it.
    #[arg(value_name = "STUDY")]
    pub study: PathBuf,
    /// Folder for the files, outside the study; created if it does not exist. Files that are there and equal are left.
    #[arg(long, value_name = "DIR")]
    pub to: PathBuf,
    /// Format of the files.
    #[arg(long = "as", value_name = "FORMAT", value_enum)]
    pub format: ExportFormat,
    /// Leave out the samples of drive and pickup, which are most of a recording.
    #[arg(long)]
    pub no_signals: bool,
    /// Include practice trials.
    #[arg(long)]
    pub practice: bool,
    /// Also export trials that the study's exclusions.tsv excludes.
    #[arg(long)]
    pub include_excluded: bool,
    /// Create files with the umask's permissions [default: readable by you only].
    #[arg(long)]
    pub shared: bool,
}

/// Exported recording.
#[derive(Debug)]
pub struct ExportedRecording {
    /// Folder of the recording.
    pub recording: PathBuf,
    /// Files, or the reason why it is not exported.
    pub files: Result<ExportedFiles, ExportError>,
}

/// Files of an exported recording.
#[derive(Debug)]
pub struct ExportedFiles {
    /// State of each file.
    pub states: Vec<FileState>,
    /// Parts that the recording lacks, in words.
    pub missing: Vec<String>,
}

/// Summary of an export.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportSummary {
    /// Number of exported recordings.
    pub exported: usize,
    /// Number of recordings that could not be exported.
    pub failed: usize,
    /// Exclusions that apply, in words.
    pub excluded: Vec<String>,
    /// Copies of recordings, accepted trials without a whole recording, logs that cannot be read, and particulars that the table of
    /// participants lacks, in words.
    pub left_out: Vec<String>,
}

/// Exports a study; `callback` is called after each recording. A recording that cannot be exported does not stop the others.
///
/// # Errors
/// There is nothing to export, the target folder has other content, or a file of the whole study cannot be written.
pub fn export(
    options: &ExportOptions,
    origin: &ExportOrigin,
    callback: impl Fn(&ExportedRecording) + Sync,
) -> Result<ExportSummary, ExportError> {
    let filter = TrialFilter {
        practice: options.practice,
        rejected: false,
    };
    let mut attempts = find::attempts(std::slice::from_ref(&options.study), filter)?;
    let mut selection = study::exclusions::select(attempts.recordings())?;
    if options.include_excluded {
        selection = selection.overridden(attempts.recordings());
    } else {
        let omitted = attempts.omissions.iter().map(|attempt| &attempt.path);
        let decided = study::exclusions::select(omitted.cloned().collect())?;
        let is_kept = |attempt: &OmittedAttempt| decided.recordings.contains(&attempt.path);
        attempts.omissions.retain(is_kept);
    }
    let excluded = selection.lines();
    if selection.recordings.is_empty() {
        return Err(ExportError::NothingLeft {
            left_out: excluded.join("; "),
        });
    }
    let identities: Vec<RecordingIdentity> = selection
        .recordings
        .iter()
        .map(|folder| RecordingIdentity::read(folder))
        .collect();
    let study = study_of(&options.study);
    require_outside(&options.to, study.as_deref().unwrap_or(&options.study))?;
    let target = TargetFolder::open(&options.to, &file_names(options, &identities)?)?;
    let exports = identities.par_iter().map(|identity| {
        let mut entries = BTreeSet::new();
        let exported = ExportedRecording {
            recording: identity.folder.clone(),
            files: write(options, identity, &target, &mut entries),
        };
        callback(&exported);
        (exported.files.is_ok(), entries)
    });
    let exports: Vec<(bool, BTreeSet<DictionaryEntry>)> = exports.collect();
    let mut remarks = Vec::new();
    let exported = exports
        .iter()
        .filter(|(is_exported, _)| *is_exported)
        .count();
    match options.format {
        ExportFormat::Mat | ExportFormat::Npz => {}
        ExportFormat::Csv => {
            let entries = exports
                .into_iter()
                .flat_map(|(_, entries)| entries)
                .collect();
            csv_tables::write_dictionary(&entries, &target)?;
        }
        ExportFormat::Bids => {
            let done = identities
                .iter()
                .zip(&exports)
                .filter(|(_, (is_exported, _))| *is_exported);
            let places = done.filter_map(|(identity, _)| identity.place.as_ref());
            let participants: BTreeSet<String> = places
                .map(|place| place.participant.as_str().to_owned())
                .collect();
            let participants = Vec::from_iter(participants);
            bids::copy_protocols(&identities, &target)?;
            remarks = bids::dataset::write(study.as_deref(), &participants, origin, &target)?;
        }
    }
    let missed = attempts
        .omissions
        .iter()
        .filter(|attempt| attempt.is_missed());
    let broken = missed.filter(|attempt| attempt.path.exists()).count();
    Ok(ExportSummary {
        exported,
        failed: identities.len() - exported + broken,
        excluded,
        left_out: left_out(&attempts).into_iter().chain(remarks).collect(),
    })
}

/// Returns the recordings that were found and are not exported, other than by decision, a line each.
fn left_out(attempts: &Attempts) -> Vec<String> {
    let missed = attempts
        .omissions
        .iter()
        .filter(|attempt| attempt.is_missed());
    let missed = missed_lines(missed).into_iter();
    let copies = attempts.copies.iter().map(ToString::to_string);
    let logs = attempts.unread_logs.iter();
    let logs = logs.map(|(log, reason)| format!("{}: {reason}", log.display()));
    missed.chain(copies).chain(logs).collect()
}

/// Writes the files of a recording, and collects the dictionary of its columns.
fn write(
    options: &ExportOptions,
    identity: &RecordingIdentity,
    target: &TargetFolder,
    entries: &mut BTreeSet<DictionaryEntry>,
) -> Result<ExportedFiles, ExportError> {
    let with_signals = !options.no_signals;
    let content = RecordingContent::read(identity, with_signals)?;
    let states = match options.format {
        ExportFormat::Mat => mat::write(&content, target),
        ExportFormat::Npz => npz::write(&content, target),
        ExportFormat::Csv => {
            entries.extend(DictionaryEntry::of_recording(&content));
            csv_tables::write(&content, target)
        }
        ExportFormat::Bids => bids::write(&content, target, with_signals),
    }?;
    Ok(ExportedFiles {
        states,
        missing: content.missing,
    })
}

/// Returns the names of all files that the export may write.
fn file_names(
    options: &ExportOptions,
    identities: &[RecordingIdentity],
) -> Result<BTreeSet<PathBuf>, ExportError> {
    let with_signals = !options.no_signals;
    let mut owners: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    let (shared, study_names) = match options.format {
        ExportFormat::Mat | ExportFormat::Npz => (BTreeSet::new(), Vec::new()),
        ExportFormat::Csv => (BTreeSet::new(), csv_tables::study_names()),
        ExportFormat::Bids => (bids::shared_names(identities), bids::study_names()),
    };
    for identity in identities {
        let names = match options.format {
            ExportFormat::Mat => mat::names(identity),
            ExportFormat::Npz => npz::names(identity),
            ExportFormat::Csv => csv_tables::names(identity, with_signals),
            ExportFormat::Bids => bids::names(identity, with_signals),
        };
        for name in names {
            if let Some(first) = owners.insert(name.clone(), &identity.folder) {
                return Err(ExportError::SameName {
                    first: first.to_owned(),
                    second: identity.folder.clone(),
                    name,
                });
            }
        }
    }
    Ok(owners
        .into_keys()
        .chain(shared)
        .chain(study_names)
        .collect())
}

/// Requires a target that is neither the study nor in it.
fn require_outside(target: &Path, study: &Path) -> Result<(), ExportError> {
    match recording::disk::is_within(target, study) {
        false => Ok(()),
        true => Err(ExportError::InsideStudy {
            target: target.to_owned(),
            study: study.canonicalize().unwrap_or_else(|_| study.to_owned()),
        }),
    }
}
