//! Errors of parts.

use std::path::{Path, PathBuf};

use analysis::SeriesError;
use analysis::analysis_settings::SettingError;
use recording::DiskError;
use study::exclusions::ExclusionsError;
use study::identity::Duplicate;
use tables::TableError;

/// Errors of parts. Each names the file and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PartsError {
    /// The disk refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The folder has no parts.
    #[error(
        "{} has no parts of an analysis; `analyze --each STUDY --out {}` makes them",
        path.display(), path.display()
    )]
    NoParts {
        /// The folder.
        path: PathBuf,
    },
    /// A file is damaged, or another program wrote it.
    #[error(
        "{} is damaged ({reason}); delete it, and run `analyze --each` again",
        path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Reason.
        reason: &'static str,
    },
    /// Recordings of a call have no parts yet.
    #[error(
        "{count} recordings have no part yet, the first is {}; run `analyze --each` again, which makes what is missing",
        first.display()
    )]
    Unfinished {
        /// First of them.
        first: PathBuf,
        /// Number.
        count: usize,
    },
    /// The parts of two calls were made by different versions of the program.
    #[error(
        "{} was analysed by friction-bench {version}, and this is {}; run `analyze --each` again for it",
        folder.display(), crate::VERSION
    )]
    Version {
        /// Folder that was analysed.
        folder: PathBuf,
        /// Version that analysed it.
        version: String,
    },
    /// The parts of two calls were made with different settings.
    #[error(
        "{} and {} were analysed with different settings: {names}; run `analyze --each` again for one of them, or put their parts \
         into two folders",
        one.display(), other.display()
    )]
    Settings {
        /// Folder that was analysed.
        one: PathBuf,
        /// Another one.
        other: PathBuf,
        /// Names of the settings that differ.
        names: String,
    },
    /// Two calls found the same attempt with different contents.
    #[error(
        "{duplicate}: only one of them can count; look which is right, and leave the other out: run `analyze --each {} --exclude {}` \
         again, or, if only it was asked for, delete {}",
        folder.display(), duplicate.path.display(), call.display()
    )]
    Ambiguous {
        /// Recording, and the one with the same attempt.
        duplicate: Box<Duplicate>,
        /// Folder that was analysed in the later call.
        folder: PathBuf,
        /// File of that call.
        call: PathBuf,
    },
    /// Assumptions of a call cannot be made.
    #[error(transparent)]
    Assumption(#[from] SettingError),
    /// A result cannot be written as a file.
    #[error("{}: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Reason.
        reason: String,
    },
    /// The rows of a part cannot be written.
    #[error(transparent)]
    Table(#[from] TableError),
    /// The series of a recording cannot be read.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// The exclusions of a study cannot be read.
    #[error(transparent)]
    Exclusions(#[from] ExclusionsError),
}

impl PartsError {
    pub(crate) fn damaged(path: &Path, reason: &'static str) -> Self {
        Self::Damaged {
            path: path.to_owned(),
            reason,
        }
    }
}
