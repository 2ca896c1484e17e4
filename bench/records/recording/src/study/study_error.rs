//! Errors of studies and their sessions.

use std::path::PathBuf;

use super::event_log::EventLogError;
use crate::DiskError;
use crate::lock;

/// Description of the study, in the manner of BIDS.
pub const DESCRIPTION_FILE: &str = "dataset_description.json";
/// File with one line per participant.
pub const PARTICIPANTS_FILE: &str = "participants.tsv";
/// File with one line for each participant, session or trial that is excluded from the analysis.
pub const EXCLUSIONS_FILE: &str = "exclusions.tsv";

/// Error of using a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The operating system refused.
    #[error(transparent)]
    Disk(#[from] DiskError),
    /// The log of a session cannot be written or read.
    #[error(transparent)]
    Log(#[from] EventLogError),
    /// The folder is neither empty nor a study.
    #[error(
        "{} is not a study: it has files but no {DESCRIPTION_FILE}; name an empty or a new folder with `--study`",
        path.display()
    )]
    NotAStudy {
        /// The folder.
        path: PathBuf,
    },
    /// The folder of a study lost its description.
    #[error(
        "{} has a {PARTICIPANTS_FILE} but no {DESCRIPTION_FILE}: put it back from a copy, or copy that of another study and correct its Name",
        path.display()
    )]
    NoDescription {
        /// The folder.
        path: PathBuf,
    },
    /// The folder is not a study.
    #[error("{} is not a study: it has no {DESCRIPTION_FILE}; check the spelling", path.display())]
    NoStudy {
        /// The folder.
        path: PathBuf,
    },
    /// The study has no data of a participant.
    #[error("{} has no data of {participant}; check the spelling", path.display())]
    NoParticipant {
        /// The study's folder.
        path: PathBuf,
        /// The participant.
        participant: String,
    },
    /// The study has the participant in another case, and some disks ignore case.
    #[error(
        "{participant} and {existing}, which {} knows, differ in upper and lower case only: write {existing} if it is the same \
         person, or choose another code",
        path.display()
    )]
    OtherCase {
        /// The study's folder.
        path: PathBuf,
        /// The participant.
        participant: String,
        /// Identifier in the study.
        existing: String,
    },
    /// A new participant's identifier differs from another one only in the zeros before its number.
    #[error(
        "{participant} is new, and {} knows {existing}: write {existing} if it is the same person, or choose another number",
        path.display()
    )]
    OtherZeros {
        /// The study's folder.
        path: PathBuf,
        /// The participant.
        participant: String,
        /// Identifier in the study.
        existing: String,
    },
    /// A folder of the study is a symbolic link.
    #[error(
        "{} is a symbolic link, which is not followed out of the study; remove it and its target by hand",
        path.display()
    )]
    Link {
        /// The link.
        path: PathBuf,
    },
    /// The study's description cannot be read.
    #[error("{}: {reason}", path.display())]
    Description {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        reason: String,
    },
    /// Another instance uses the study.
    #[error("study {} is in use by another friction-bench{}; quit that one first", path.display(), lock::holder(*.holder))]
    InUse {
        /// The study.
        path: PathBuf,
        /// Process that holds the lock, if known.
        holder: Option<u32>,
    },
    /// A disk without file locks has a file that says that another instance uses the study.
    #[error(
        "study {} is marked as in use by another friction-bench{}: quit that one first; if it has ended, on every computer, remove {}",
        path.display(), lock::holder(*.holder), mark.display()
    )]
    Marked {
        /// The study.
        path: PathBuf,
        /// The file.
        mark: PathBuf,
        /// Process that created the file, if known.
        holder: Option<u32>,
    },
    /// The session exists already.
    #[error(
        "{} exists already and is never overwritten; go on with it by `--resume`, or begin session {next} by `--new-session`",
        path.display()
    )]
    SessionExists {
        /// The session's folder.
        path: PathBuf,
        /// First free session number.
        next: u32,
    },
    /// The session to be resumed does not exist.
    #[error("{} does not exist, so it cannot be resumed; start it without `--resume`", path.display())]
    NoSession {
        /// The session's folder.
        path: PathBuf,
    },
    /// The session ended with success.
    #[error("{} has ended; begin session {next} by `--new-session`", path.display())]
    SessionEnded {
        /// The session's folder.
        path: PathBuf,
        /// First free session number.
        next: u32,
    },
    /// The trial was recorded already.
    #[error(
        "{} exists already and is never overwritten; go on after it by `--resume`, or record another attempt",
        path.display()
    )]
    TrialExists {
        /// The trial's folder.
        path: PathBuf,
    },
    /// A text contains a tab or line end, which would break `participants.tsv`.
    #[error("{field} is {value:?}; tabs and line ends are not allowed in {PARTICIPANTS_FILE}")]
    Tsv {
        /// The column.
        field: &'static str,
        /// The text.
        value: String,
    },
    /// A table of the study cannot be read as one.
    #[error("{}: {reason}; correct it by hand, or put it back from a copy", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        reason: String,
    },
    /// The name of a snapshot is not a plain file name.
    #[error("a snapshot cannot be named {name:?}; a file name without folders is needed")]
    SnapshotName {
        /// The name.
        name: String,
    },
    /// The disk has too little free space.
    #[error(
        "{} has {:.2} GB free, but {:.2} GB are needed; make room or choose another folder with `--study`",
        path.display(), *free as f64 / 1e9, *needed as f64 / 1e9
    )]
    NoRoom {
        /// Folder on the disk.
        path: PathBuf,
        /// Bytes free.
        free: u64,
        /// Bytes needed.
        needed: u64,
    },
}
