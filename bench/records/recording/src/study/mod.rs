//! Study folders: participants, sessions, trials. A study only grows; its files are never overwritten.
//!
//! ```text
//! STUDY/dataset_description.json
//! STUDY/participants.tsv
//! STUDY/exclusions.tsv                        what the analysis leaves out, and why
//! STUDY/removals.tsv                          when participants were removed, without who they were
//! STUDY/sub-01/ses-01/events.jsonl            start, descriptors, events, stop
//! STUDY/sub-01/ses-01/huloux2021.toml …       snapshots of the protocol and the hardware file
//! STUDY/sub-01/ses-01/practice-01_attempt-1/  recordings
//! STUDY/sub-01/ses-01/trial-003_attempt-1/
//! ```

pub mod event_log;
mod participants;
mod room;
mod session_folder;
mod study_error;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use protocols::{NOT_STATED, ParticipantId, Person};
use serde::{Deserialize, Serialize};

pub use event_log::{Document, EventLog, EventLogError};
pub use participants::ID_COLUMN;
pub use protocols::{TrialBlock, TrialLabel};
pub use room::{DataRates, free_bytes, require_room};
pub use session_folder::{EVENTS_FILE, RecordedTrial, SessionFolder};
pub use study_error::{DESCRIPTION_FILE, EXCLUSIONS_FILE, PARTICIPANTS_FILE, StudyError};

use crate::disk::{self, DiskError, OnPath};
use crate::disk_limit::{self, DiskLimit};
use crate::lock::{HeldLock, Lock};
use crate::rights;
use crate::storage::{FileSystem, Storage};
use bounded_files::parse_json;

/// Lock file of the instance that uses the study.
pub const LOCK_FILE: &str = ".friction-bench.lock";

/// `dataset_description.json`, with the keys of BIDS.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct Description {
    /// Name of the study.
    pub name: String,
    /// Type of the data, `raw`.
    pub dataset_type: String,
    /// Programs that wrote the study.
    pub generated_by: Vec<GeneratedBy>,
}

/// Program that wrote a study.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "PascalCase")]
pub struct GeneratedBy {
    /// Name of the program.
    pub name: String,
    /// Version of the program.
    pub version: String,
}

/// Length of the day at the begin of a time by RFC 3339.
const DAY_LENGTH: usize = "2026-01-31".len();

/// Study, locked against other instances until it is dropped.
#[derive(Debug)]
pub struct Study {
    folder: PathBuf,
    storage: Arc<dyn Storage>,
    description: Description,
    _lock: Option<HeldLock>,
}

impl Study {
    /// Opens the study in `folder`, or creates one named after the folder; missing parent folders are created too.
    ///
    /// # Errors
    /// The folder contains other files, or another instance uses the study.
    pub fn open_or_create(folder: &Path, generated_by: GeneratedBy) -> Result<Self, StudyError> {
        fs::create_dir_all(folder).with_path("create", folder)?;
        let description_path = folder.join(DESCRIPTION_FILE);
        if !description_path.exists() && !is_unused(folder)? {
            let path = folder.to_owned();
            return Err(match folder.join(PARTICIPANTS_FILE).is_file() {
                true => StudyError::NoDescription { path },
                false => StudyError::NotAStudy { path },
            });
        }
        let lock = lock(folder)?;
        if !rights::are_kept(folder) {
            disk_limit::note(DiskLimit::Rights, folder);
        }
        Self::open_locked(Arc::new(FileSystem), folder, generated_by, Some(lock))
    }

    /// Opens or creates the study in `folder` of a storage that no other program can reach, and therefore without a lock.
    ///
    /// # Errors
    /// The disk refused.
    pub fn open_or_create_in(
        storage: Arc<dyn Storage>,
        folder: &Path,
        generated_by: GeneratedBy,
    ) -> Result<Self, StudyError> {
        Self::open_locked(storage, folder, generated_by, None)
    }

    fn open_locked(
        storage: Arc<dyn Storage>,
        folder: &Path,
        generated_by: GeneratedBy,
        lock: Option<HeldLock>,
    ) -> Result<Self, StudyError> {
        let description_path = folder.join(DESCRIPTION_FILE);
        if !disk::exists(&*storage, &description_path)? {
            let description = Description {
                name: study_name(folder),
                dataset_type: "raw".to_owned(),
                generated_by: vec![generated_by],
            };
            create_description(&*storage, &description_path, &description)?;
        }
        participants::require_table(&*storage, &folder.join(PARTICIPANTS_FILE))?;
        Ok(Self {
            folder: folder.to_owned(),
            description: read_description(&*storage, &description_path)?,
            storage,
            _lock: lock,
        })
    }

    /// Opens the existing study in `folder`.
    ///
    /// # Errors
    /// The folder is not a study, or another instance uses it.
    pub fn open(folder: &Path) -> Result<Self, StudyError> {
        let description = folder.join(DESCRIPTION_FILE);
        if !description.is_file() {
            return Err(StudyError::NoStudy {
                path: folder.to_owned(),
            });
        }
        let lock = lock(folder)?;
        Ok(Self {
            folder: folder.to_owned(),
            description: read_description(&FileSystem, &description)?,
            storage: Arc::new(FileSystem),
            _lock: Some(lock),
        })
    }

    /// Returns the folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the description of the study.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Returns the folder of a session, whether it exists or not.
    #[must_use]
    pub fn session_folder(&self, participant: &ParticipantId, session: u32) -> PathBuf {
        self.folder
            .join(participant.as_str())
            .join(session_name(session))
    }

    /// Returns the number of the participant's next session, one above the highest so far.
    ///
    /// # Errors
    /// [`StudyError::OtherCase`], or the participant's folder cannot be listed.
    pub fn next_session(&self, participant: &ParticipantId) -> Result<u32, StudyError> {
        self.require_one_case(participant)?;
        let last = last_session(&self.folder.join(participant.as_str()))?;
        Ok(last.unwrap_or(0).saturating_add(1))
    }

    /// Requires that no participant of the study has an identifier that differs from this one only in case: their folders
    /// would be the same on a disk that ignores case.
    fn require_one_case(&self, participant: &ParticipantId) -> Result<(), StudyError> {
        let path = self.folder.join(PARTICIPANTS_FILE);
        // Lost, as by a copy: the session that begins writes it anew.
        if !disk::exists(&*self.storage, &path)? {
            return Ok(());
        }
        let table = participants::Table::read(&*self.storage, &path)?;
        match table.case_variant(participant) {
            Some(id) => Err(StudyError::OtherCase {
                path: self.folder.clone(),
                participant: participant.to_string(),
                existing: id.to_owned(),
            }),
            None => Ok(()),
        }
    }

    /// Requires that a participant who is new has no number of another one, written with other zeros: a slip would make two people of
    /// one.
    fn require_other_number(&self, participant: &ParticipantId) -> Result<(), StudyError> {
        let table =
            participants::Table::read(&*self.storage, &self.folder.join(PARTICIPANTS_FILE))?;
        match table.other_zeros(participant) {
            Some(id) => Err(StudyError::OtherZeros {
                path: self.folder.clone(),
                participant: participant.to_string(),
                existing: id.to_owned(),
            }),
            None => Ok(()),
        }
    }

    /// Begins a session: creates its folder and log, and the participant's line in `participants.tsv` if it is their
    /// first session. `date` is the day as `2026-01-31`, `protocol` the protocol's name.
    ///
    /// # Errors
    /// [`StudyError::OtherCase`]; [`StudyError::OtherZeros`];
    /// [`StudyError::SessionExists`], with the next free session, if the session was held
    /// already.
    pub fn begin_session(
        &self,
        participant: &ParticipantId,
        session: u32,
        date: &str,
        protocol: &str,
    ) -> Result<SessionFolder, StudyError> {
        participants::require_cells(date, protocol)?;
        self.require_one_case(participant)?;
        self.require_other_number(participant)?;
        let folder = self.session_folder(participant, session);
        let participant_folder = self.folder.join(participant.as_str());
        let storage = &*self.storage;
        if let Err(error) = storage.create_folder(&participant_folder)
            && error.kind() != io::ErrorKind::AlreadyExists
        {
            return Err(error).with_path("create", &participant_folder)?;
        }
        // Every participant in the table has a folder.
        disk::sync_parent(storage, &participant_folder)?;
        // Before there is a session, so that it has its day and protocol.
        participants::register(storage, &self.folder, participant, date, protocol)?;
        match storage.create_folder(&folder) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                return Err(StudyError::SessionExists {
                    path: folder,
                    next: self.next_session(participant)?,
                });
            }
            result => result.with_path("create", &folder)?,
        }
        disk::sync_parent(storage, &folder)?;
        SessionFolder::create(Arc::clone(&self.storage), folder)
    }

    /// Returns the data of a participant in `participants.tsv`; empty if the participant is not listed.
    ///
    /// # Errors
    /// The table cannot be read.
    pub fn person(&self, participant: &ParticipantId) -> Result<Person, StudyError> {
        let path = self.folder.join(PARTICIPANTS_FILE);
        Ok(participants::Table::read(&*self.storage, &path)?.person(participant))
    }

    /// Fills in missing data of a participant in `participants.tsv`; existing data are kept.
    ///
    /// # Errors
    /// The disk refused; the table is unchanged.
    pub fn describe(&self, participant: &ParticipantId, person: &Person) -> Result<(), StudyError> {
        participants::describe(&*self.storage, &self.folder, participant, person)
    }

    /// Lists a participant with imported recordings in `participants.tsv`: adds the row if it is missing, and fills in cells that
    /// have no value; columns that the table lacks are added.
    ///
    /// # Errors
    /// [`StudyError::OtherCase`], or the disk refused.
    pub fn list_imported(
        &self,
        participant: &ParticipantId,
        cells: &[(&str, &str)],
    ) -> Result<(), StudyError> {
        self.require_one_case(participant)?;
        participants::list_imported(&*self.storage, &self.folder, participant, cells)
    }

    /// Removes the row of `participants.tsv` that [`Study::list_imported`] added; a row of the bench stays.
    ///
    /// # Errors
    /// The disk refused.
    pub fn unlist_imported(&self, participant: &ParticipantId) -> Result<(), StudyError> {
        participants::unlist_imported(&*self.storage, &self.folder, participant)
    }

    /// Opens an interrupted session to resume it, and restores a lost row of `participants.tsv`.
    ///
    /// # Errors
    /// The session does not exist, or it ended with success.
    pub fn resume_session(
        &self,
        participant: &ParticipantId,
        session: u32,
    ) -> Result<SessionFolder, StudyError> {
        let folder = self.session_folder(participant, session);
        if !disk::exists(&*self.storage, &folder)? {
            return Err(StudyError::NoSession { path: folder });
        }
        let opened = SessionFolder::open(Arc::clone(&self.storage), folder.clone())?;
        if opened.has_succeeded() {
            return Err(StudyError::SessionEnded {
                path: folder,
                next: self.next_session(participant)?,
            });
        }
        self.restore_row(participant, session, opened.earlier_log())?;
        Ok(opened)
    }

    /// Restores the lost row of a participant from the log of the session.
    fn restore_row(
        &self,
        participant: &ParticipantId,
        session: u32,
        log: &event_log::LogContent,
    ) -> Result<(), StudyError> {
        let first = log.starts().next().filter(|_| session == 1);
        let day = first.and_then(|start| start.time.get(..DAY_LENGTH));
        let protocol = first.map_or(NOT_STATED, |start| &start.protocol);
        participants::register(
            &*self.storage,
            &self.folder,
            participant,
            day.unwrap_or(NOT_STATED),
            protocol,
        )
    }
}

/// Returns the name of a session's folder.
#[must_use]
pub fn session_name(session: u32) -> String {
    format!("ses-{session:02}")
}

/// Returns the number of the last session in a participant's folder; `None` without a session.
///
/// # Errors
/// The folder cannot be listed.
pub fn last_session(participant: &Path) -> Result<Option<u32>, DiskError> {
    let names = disk::entries(participant)?;
    let numbers = names
        .iter()
        .filter_map(|name| name.strip_prefix("ses-")?.parse().ok());
    Ok(numbers.max())
}

fn study_name(folder: &Path) -> String {
    folder
        .canonicalize()
        .ok()
        .as_deref()
        .and_then(Path::file_name)
        .map_or_else(
            || "study".to_owned(),
            |name| name.to_string_lossy().into_owned(),
        )
}

/// Returns whether a folder contains only a lock, left by an instance that was killed while creating the study.
fn is_unused(folder: &Path) -> Result<bool, StudyError> {
    Ok(disk::entries(folder)?.iter().all(|name| {
        name.starts_with(LOCK_FILE)
            || name == rights::PROBE_FILE
            || name.strip_suffix(".tmp") == Some(DESCRIPTION_FILE)
    }))
}

fn create_description(
    storage: &dyn Storage,
    path: &Path,
    description: &Description,
) -> Result<(), StudyError> {
    let mut text =
        serde_json::to_string_pretty(description).map_err(|error| StudyError::Description {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
    text.push('\n');
    disk::replace_file_on(storage, path, text.as_bytes())?;
    Ok(())
}

fn read_description(storage: &dyn Storage, path: &Path) -> Result<Description, StudyError> {
    let text = disk::read_on(storage, path, bounded_files::TEXT_LIMIT_BYTES)?;
    parse_description(&text).map_err(|reason| StudyError::Description {
        path: path.to_owned(),
        reason,
    })
}

/// Reads the content of `dataset_description.json`.
///
/// # Errors
/// The words for its fault.
pub fn parse_description(text: &[u8]) -> Result<Description, String> {
    parse_json(text)
}

/// Requires that no other program records into the study in a folder, as far as the folder shows it.
///
/// # Errors
/// [`StudyError::InUse`] or [`StudyError::Marked`].
pub fn require_idle(folder: &Path) -> Result<(), StudyError> {
    if !folder.join(LOCK_FILE).exists() {
        return Ok(());
    }
    match lock(folder) {
        Err(error @ (StudyError::InUse { .. } | StudyError::Marked { .. })) => Err(error),
        // Nobody records on a disk that cannot be written.
        _ => Ok(()),
    }
}

/// Takes the study's lock.
fn lock(folder: &Path) -> Result<HeldLock, StudyError> {
    match Lock::try_take(&folder.join(LOCK_FILE))? {
        Lock::Taken(lock) => Ok(lock),
        Lock::Held {
            holder,
            mark: Some(mark),
        } => Err(StudyError::Marked {
            path: folder.to_owned(),
            mark,
            holder,
        }),
        Lock::Held { holder, mark: None } => Err(StudyError::InUse {
            path: folder.to_owned(),
            holder,
        }),
    }
}
