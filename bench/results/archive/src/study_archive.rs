//! Archive of a study, of parts of it, or of single recordings.

use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use recording::study::require_idle;

use crate::archive_error::ArchiveError;
use crate::archive_folder;
use crate::places::plan;
use crate::recording_archive::{self, ArchivedRecording};
use crate::study_files::copy_files;

/// `archive`
#[derive(Debug, Args)]
pub struct ArchiveOptions {
    /// Studies, participants, sessions or recordings to archive; of a study every attempt, also rejected ones and practice.
    #[arg(required = true, value_name = "STUDY|RECORDING")]
    pub sources: Vec<PathBuf>,
    /// Folder of the archive, outside the study; created if it does not exist. Recordings that are there are left.
    #[arg(long, value_name = "DIR")]
    pub to: PathBuf,
    /// Create files with the umask's permissions [default: readable by you only].
    #[arg(long)]
    pub shared: bool,
}

/// Summary of an archiving.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ArchiveSummary {
    /// Number of recordings in the archive.
    pub archived: usize,
    /// Number of recordings that could not be archived.
    pub failed: usize,
    /// Bytes of the recordings that are in the archive.
    pub original_bytes: u64,
    /// Bytes of their archives.
    pub archive_bytes: u64,
}

/// Archives recordings, several at a time; `begin` is called with their number, and `callback` after each. A recording that cannot be
/// archived does not stop the others.
///
/// # Errors
/// There is nothing to archive, a session of the study is running, the archive would be in the study, or a file of the whole study
/// cannot be copied.
pub fn archive(
    options: &ArchiveOptions,
    version: &str,
    begin: impl FnOnce(usize),
    callback: impl Fn(&ArchivedRecording) + Sync,
) -> Result<ArchiveSummary, ArchiveError> {
    let plan = plan(&options.sources, &options.to)?;
    if let Some(study) = &plan.study {
        require_idle(study)?;
    }
    archive_folder::open(&options.to, plan.study.as_deref())?;
    begin(plan.recordings.len());
    for folder in &plan.shared_folders {
        copy_files(&folder.source, &options.to.join(&folder.name), |_| true)?;
    }
    let recordings = plan.recordings.par_iter().map(|place| {
        let recording = recording_archive::archive(place, &options.to, version);
        callback(&recording);
        match &recording.state {
            Ok((_, bytes)) => ArchiveSummary {
                archived: 1,
                failed: 0,
                original_bytes: recording.bytes,
                archive_bytes: *bytes,
            },
            Err(_) => ArchiveSummary {
                failed: 1,
                ..ArchiveSummary::default()
            },
        }
    });
    Ok(
        recordings.reduce(ArchiveSummary::default, |a, b| ArchiveSummary {
            archived: a.archived + b.archived,
            failed: a.failed + b.failed,
            original_bytes: a.original_bytes + b.original_bytes,
            archive_bytes: a.archive_bytes + b.archive_bytes,
        }),
    )
}
