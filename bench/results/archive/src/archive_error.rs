//! Reasons why a recording or a study is not archived.

use std::path::PathBuf;

use analysis::findings::RecordingError;
use envelope_files::EnvelopeError;
use recording::DiskError;
use recording::manifest::ManifestError;
use recording::reader::ReadError;
use recording::study::StudyError;

/// Reason why a recording or a study is not archived.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ArchiveError {
    /// A file of the recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The recording cannot be analysed, so that nothing shows whether its archive gives the same results.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The envelopes cannot be written.
    #[error(transparent)]
    Envelopes(#[from] EnvelopeError),
    /// The description of the archive breaks a rule.
    #[error("recording.toml: {0}")]
    Description(#[from] ManifestError),
    /// A session of the study is running: its recording would be archived before its end.
    #[error(transparent)]
    InUse(#[from] StudyError),
    /// A file or folder cannot be read or written.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The folders have no recording.
    #[error(
        "{} is neither a recording (it has no recording.toml) nor a study with recordings",
        path.display()
    )]
    Nothing {
        /// Folder given.
        path: PathBuf,
    },
    /// The target is the study, or lies in it.
    #[error(
        "{} is in the study {}: choose a folder outside it with --to, or the archive would be archived too",
        target.display(), study.display()
    )]
    InsideStudy {
        /// Target given.
        target: PathBuf,
        /// The study.
        study: PathBuf,
    },
    /// The recordings are of two studies.
    #[error(
        "{} and {} are two studies, which may have the same participants: archive each into a folder of its own",
        first.display(), second.display()
    )]
    TwoStudies {
        /// First study.
        first: PathBuf,
        /// Second study.
        second: PathBuf,
    },
    /// The target has other files.
    #[error(
        "{} is no archive, and has other files, such as {file}: choose an empty folder with --to",
        target.display()
    )]
    Occupied {
        /// Target given.
        target: PathBuf,
        /// Name of a file in it.
        file: String,
    },
    /// The target is the archive of another study.
    #[error(
        "{} is the archive of another study: choose another folder with --to",
        target.display()
    )]
    OtherStudy {
        /// Target given.
        target: PathBuf,
    },
    /// Two recordings would have the same place in the archive.
    #[error(
        "{} and {} would both be {} in the archive: archive them into two folders",
        first.display(), second.display(), name.display()
    )]
    SameName {
        /// First recording.
        first: PathBuf,
        /// Second recording.
        second: PathBuf,
        /// Place of both.
        name: PathBuf,
    },
    /// The archive has another recording under this name.
    #[error(
        "{} is the archive of another recording, or of this one before its {file} changed: look which is right, and remove it or choose \
         another folder with --to",
        target.display()
    )]
    Other {
        /// Folder in the archive.
        target: PathBuf,
        /// Name of a file that differs.
        file: String,
    },
}
