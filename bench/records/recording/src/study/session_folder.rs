//! Folder of a session.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::event_log::{EventLog, ExitStatus, LogContent};
use super::study_error::StudyError;
use crate::Manifest;
use crate::disk::{self, OnPath};
use crate::reader::{self, ReadError};
use crate::storage::Storage;
use crate::sums::file_sum;
use protocols::TrialLabel;

/// Log of a session.
pub const EVENTS_FILE: &str = "events.jsonl";

/// Folder of a session, with its log open for appending.
#[derive(Debug)]
pub struct SessionFolder {
    folder: PathBuf,
    storage: Arc<dyn Storage>,
    log: EventLog,
    earlier_log: LogContent,
}

/// Recording folder found in a session.
#[derive(Debug)]
pub struct RecordedTrial {
    /// Trial and attempt.
    pub label: TrialLabel,
    /// Folder of the recording.
    pub folder: PathBuf,
    /// Description of the recording; its trial has no `end` if the recording was cut off.
    pub manifest: Result<Manifest, ReadError>,
}

impl SessionFolder {
    pub(super) fn create(storage: Arc<dyn Storage>, folder: PathBuf) -> Result<Self, StudyError> {
        Ok(Self {
            log: EventLog::create_in(Arc::clone(&storage), folder.join(EVENTS_FILE))?,
            earlier_log: LogContent::default(),
            folder,
            storage,
        })
    }

    pub(super) fn open(storage: Arc<dyn Storage>, folder: PathBuf) -> Result<Self, StudyError> {
        let path = folder.join(EVENTS_FILE);
        if !disk::exists(&*storage, &path)? {
            // The program was killed between creating the folder and the log.
            return Self::create(storage, folder);
        }
        let (log, earlier_log) = EventLog::open_in(Arc::clone(&storage), path)?;
        Ok(Self {
            folder,
            storage,
            log,
            earlier_log,
        })
    }

    /// Returns the folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Returns the content of the log when the session was opened; empty for a new session.
    #[must_use]
    pub fn earlier_log(&self) -> &LogContent {
        &self.earlier_log
    }

    /// Returns the session's log.
    pub fn log(&mut self) -> &mut EventLog {
        &mut self.log
    }

    pub(super) fn has_succeeded(&self) -> bool {
        self.earlier_log
            .stop()
            .is_some_and(|stop| stop.exit_status == ExitStatus::Success)
    }

    /// Stores a copy of a file that this session depends on, such as the protocol, and returns its path. If the session
    /// has another content under that name already (it was resumed after an edit), the copy is numbered.
    ///
    /// # Errors
    /// The name includes folders, or the operating system refused.
    pub fn snapshot(&self, name: &str, contents: &str) -> Result<PathBuf, StudyError> {
        let is_plain = Path::new(name).file_name() == Some(name.as_ref()) && !name.contains('\\');
        if !is_plain {
            return Err(StudyError::SnapshotName {
                name: name.to_owned(),
            });
        }
        let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
        let mut number = 1;
        loop {
            let path = match number {
                1 => self.folder.join(name),
                _ => self.folder.join(format!("{stem}.{number}.{extension}")),
            };
            if !disk::exists(&*self.storage, &path)? {
                disk::replace_file_on(&*self.storage, &path, contents.as_bytes())?;
                return Ok(path);
            }
            let existing = disk::read_on(&*self.storage, &path, contents.len() as u64);
            if existing.is_ok_and(|existing| existing == contents.as_bytes()) {
                // An earlier attempt may have failed after writing the file.
                disk::sync_parent(&*self.storage, &path)?;
                return Ok(path);
            }
            number += 1;
        }
    }

    /// Returns the SHA-256 of each of the session's copies of files.
    ///
    /// # Errors
    /// The folder or a copy cannot be read.
    pub fn copies(&self) -> Result<BTreeMap<String, String>, StudyError> {
        let names = disk::entries(&self.folder)?.into_iter();
        let copies = names.filter(|name| name.ends_with(".toml"));
        let sum = |name: String| {
            let path = self.folder.join(&name);
            let (_, sum) = file_sum(&path).with_path("read", &path)?;
            Ok((name, sum))
        };
        copies.map(sum).collect()
    }

    /// Returns the folder for a new recording, which does not exist yet; the recorder creates it.
    ///
    /// # Errors
    /// [`StudyError::TrialExists`] if the attempt was recorded already.
    pub fn trial_folder(&self, label: TrialLabel) -> Result<PathBuf, StudyError> {
        let path = self.folder.join(label.to_string());
        if path.symlink_metadata().is_ok() {
            return Err(StudyError::TrialExists { path });
        }
        Ok(path)
    }

    /// Returns the recordings of the session, practice first, then by number and attempt.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub fn recorded_trials(&self) -> Result<Vec<RecordedTrial>, StudyError> {
        let mut labels = self.recorded_labels()?;
        labels.sort_unstable();
        let trials = labels.into_iter().map(|label| {
            let folder = self.folder.join(label.to_string());
            RecordedTrial {
                label,
                manifest: reader::read_manifest(&folder),
                folder,
            }
        });
        Ok(trials.collect())
    }

    /// Returns the attempts that have a folder, in no particular order.
    ///
    /// # Errors
    /// The folder cannot be listed.
    pub fn recorded_labels(&self) -> Result<Vec<TrialLabel>, StudyError> {
        let names = disk::entries(&self.folder)?;
        Ok(names.iter().filter_map(|name| name.parse().ok()).collect())
    }
}
