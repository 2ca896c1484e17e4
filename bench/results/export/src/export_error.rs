//! Reasons why a study or one of its recordings is not exported.

use std::path::PathBuf;

use attempts::find::FindError;
use envelope_files::EnvelopeError;
use recording::DiskError;
use recording::reader::ReadError;
use study::exclusions::ExclusionsError;
use text_tables::TableFault;

/// Reason why a study or one of its recordings is not exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The study has no recordings that can be exported.
    #[error(transparent)]
    Find(#[from] FindError),
    /// The study's exclusions cannot be read.
    #[error(transparent)]
    Exclusions(#[from] ExclusionsError),
    /// The exclusions leave out every recording.
    #[error(
        "nothing is left to export: exclusions.tsv leaves out {left_out}; --include-excluded exports it all the same"
    )]
    NothingLeft {
        /// Excluded parts of the study.
        left_out: String,
    },
    /// The target is the study, or a folder in it.
    #[error(
        "{} is in the study {}, which is for recordings alone: name a folder outside it after --to",
        target.display(), study.display()
    )]
    InsideStudy {
        /// Target folder.
        target: PathBuf,
        /// Folder of the study.
        study: PathBuf,
    },
    /// The target has files that this export does not write.
    #[error(
        "{} has files that do not belong to this export ({count}, the first {}): remove them, or name an empty or new folder after --to",
        folder.display(), first.display()
    )]
    Foreign {
        /// Target folder.
        folder: PathBuf,
        /// First file, relative to the folder.
        first: PathBuf,
        /// Number of these files.
        count: usize,
    },
    /// Two recordings would be written to the same file.
    #[error(
        "{} and {} would both be written to {}: export each study to a separate folder",
        first.display(), second.display(), name.display()
    )]
    SameName {
        /// First recording.
        first: PathBuf,
        /// Second recording.
        second: PathBuf,
        /// File, relative to the target folder.
        name: PathBuf,
    },
    /// A recording that BIDS has no place for.
    #[error(
        "{}: BIDS needs the participant and the trial: add [participant] and [trial] to its recording.toml (docs/RECORDING.md)",
        recording.display()
    )]
    NoParticipant {
        /// The recording.
        recording: PathBuf,
    },
    /// A recording is longer than a format allows.
    #[error(
        "{}: {part} has more than the 2 GiB that a variable of a MAT-file can have: export it as npz or csv",
        recording.display()
    )]
    TooLarge {
        /// The recording.
        recording: PathBuf,
        /// Part of the recording.
        part: String,
    },
    /// A recording changed between two readings.
    #[error(
        "{}: the recording changed while it was read: export it again when its session has ended",
        recording.display()
    )]
    Changed {
        /// The recording.
        recording: PathBuf,
    },
    /// A recording cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The envelopes of a recording cannot be read.
    #[error(transparent)]
    Envelopes(#[from] EnvelopeError),
    /// The study's table of participants cannot be read.
    #[error("{}: {fault}", path.display())]
    Participants {
        /// The table.
        path: PathBuf,
        /// Its fault.
        fault: TableFault,
    },
    /// A file or folder of the export cannot be written.
    #[error(transparent)]
    Disk(#[from] DiskError),
}
