//! Removal of a participant from a study.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use protocols::ParticipantId;

use recording::disk::{self, DiskError, OnPath};
use recording::study::{EXCLUSIONS_FILE, ID_COLUMN, PARTICIPANTS_FILE, Study, StudyError};
use text_tables::{TabTable, TableLine, table_lines, without_lines};

/// File with one line for each removed participant: the date, without any personal data.
pub const REMOVALS_FILE: &str = "removals.tsv";

const REMOVALS_HEADER: &str = "removed_on\twhat\n";
/// Maximum size of a file searched for a participant, bytes; files in participants' folders are not searched.
const SEARCHED_BYTES: u64 = 16 << 20;
/// Maximum depth of folders searched, apart from participants' folders.
const SEARCHED_DEPTH: usize = 4;

/// Data of a participant in a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Traces {
    participant: String,
    /// The participant's folder, if it exists.
    pub folder: Option<PathBuf>,
    /// Number of folders in it, including itself.
    pub folders: u64,
    /// Number of files in it.
    pub files: u64,
    /// Number of symbolic links in it, which are removed without their targets.
    pub links: u64,
    /// Total size of the files, bytes.
    pub bytes: u64,
    /// Whether the participant is in `participants.tsv`.
    pub is_listed: bool,
    /// Number of lines of `exclusions.tsv` about the participant.
    pub exclusions: usize,
    /// Files of the study, outside all participants' folders, with the participant's identifier in their name or text, and folders
    /// with it in their name, such as copies. They are not removed.
    pub others: Vec<PathBuf>,
}

impl Traces {
    /// Returns the data of a participant in a study, without searching other participants' folders.
    ///
    /// # Errors
    /// [`StudyError::NoParticipant`]; [`StudyError::Link`] if the participant's folder is a symbolic link; or a file in
    /// it cannot be read.
    pub fn find(study: &Study, participant: &ParticipantId) -> Result<Self, StudyError> {
        let study = study.folder();
        let mut traces = Self {
            participant: participant.as_str().to_owned(),
            folder: None,
            folders: 0,
            files: 0,
            links: 0,
            bytes: 0,
            is_listed: false,
            exclusions: 0,
            others: Vec::new(),
        };
        let folder = study.join(participant.as_str());
        match fs::symlink_metadata(&folder) {
            Ok(metadata) if metadata.is_symlink() => return Err(StudyError::Link { path: folder }),
            Ok(metadata) if metadata.is_dir() => {
                traces.count(&folder)?;
                traces.folder = Some(folder);
            }
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => return Err(error).with_path("read", &folder)?,
        }
        let participants = read_table(study, PARTICIPANTS_FILE)?;
        let id_column = id_column(study, &participants)?;
        traces.is_listed = table_lines(&participants)
            .iter()
            .any(|line| traces.is_listed_in(line, id_column));
        traces.exclusions = table_lines(&read_table(study, EXCLUSIONS_FILE)?)
            .iter()
            .filter(|line| traces.is_excluded_by(line))
            .count();
        if traces.folder.is_none() && !traces.is_listed && traces.exclusions == 0 {
            return Err(StudyError::NoParticipant {
                path: study.to_owned(),
                participant: traces.participant,
            });
        }
        traces.search(study, SEARCHED_DEPTH)?;
        Ok(traces)
    }

    fn is_listed_in(&self, line: &TableLine, id_column: usize) -> bool {
        line.cells.get(id_column) == Some(&self.participant)
    }

    /// Returns whether a line of `exclusions.tsv` is about the participant; its columns may be in any order.
    fn is_excluded_by(&self, line: &TableLine) -> bool {
        line.cells.contains(&self.participant)
    }

    /// Counts the content of a folder; links are counted and not followed.
    fn count(&mut self, folder: &Path) -> Result<(), DiskError> {
        self.folders += 1;
        for entry in fs::read_dir(folder).with_path("list", folder)? {
            let entry = entry.with_path("list", folder)?;
            let path = entry.path();
            // Metadata of the entry itself, not of a link's target.
            let metadata = entry.metadata().with_path("read", &path)?;
            if metadata.is_symlink() {
                self.links += 1;
            } else if metadata.is_dir() {
                self.count(&path)?;
            } else {
                self.files += 1;
                self.bytes += metadata.len();
            }
        }
        Ok(())
    }

    /// Searches for the participant outside the participants' folders.
    fn search(&mut self, folder: &Path, depth: usize) -> Result<(), DiskError> {
        for entry in fs::read_dir(folder).with_path("list", folder)? {
            let entry = entry.with_path("list", folder)?;
            let (path, name) = (entry.path(), entry.file_name());
            let name = name.to_string_lossy();
            let file_type = entry.file_type().with_path("read", &path)?;
            if name == PARTICIPANTS_FILE || Some(&path) == self.folder.as_ref() {
                continue;
            }
            if file_type.is_dir() {
                if self.is_named_in(name.as_bytes()) {
                    self.others.push(path);
                } else if depth > 1 && !name.starts_with("sub-") {
                    self.search(&path, depth - 1)?;
                }
                continue;
            }
            let text = || {
                let text = bounded_files::read(&path, SEARCHED_BYTES).unwrap_or_default();
                if name != EXCLUSIONS_FILE {
                    return text;
                }
                // Lines that will remain after the removal.
                let table = String::from_utf8_lossy(&text);
                without_lines(&table, |line| self.is_excluded_by(line)).into_bytes()
            };
            if self.is_named_in(name.as_bytes()) || file_type.is_file() && self.is_named_in(&text())
            {
                self.others.push(path);
            }
        }
        self.others.sort_unstable();
        Ok(())
    }

    /// Returns whether a text contains the identifier, other than as the beginning of a longer one.
    fn is_named_in(&self, text: &[u8]) -> bool {
        let name = self.participant.as_bytes();
        text.windows(name.len()).enumerate().any(|(index, window)| {
            let next = text.get(index + name.len());
            window == name && !next.is_some_and(u8::is_ascii_alphanumeric)
        })
    }

    /// Removes these data: the folder with its current content, and the lines of `participants.tsv` and `exclusions.tsv`. A line in
    /// [`REMOVALS_FILE`] states that a participant was removed on `date`. Everything is on disk when this returns; if it was
    /// interrupted, it can be repeated.
    ///
    /// # Errors
    /// The operating system refused; [`Traces::find`] still finds the remaining data.
    pub fn remove(&self, study: &Study, date: &str) -> Result<(), StudyError> {
        let study = study.folder();
        if let Some(folder) = &self.folder {
            match fs::symlink_metadata(folder) {
                Ok(metadata) if metadata.is_symlink() => {
                    return Err(StudyError::Link {
                        path: folder.clone(),
                    });
                }
                // `remove_dir_all` does not follow links.
                _ => fs::remove_dir_all(folder).with_path("remove", folder)?,
            }
            disk::sync_folder(study)?;
        }
        // Before the last trace is removed: if the program is killed, a superfluous line is better than a missing one.
        note_removal(study, date)?;
        if self.exclusions > 0 {
            remove_lines(study, EXCLUSIONS_FILE, |line| self.is_excluded_by(line))?;
        }
        if self.is_listed {
            let id_column = id_column(study, &read_table(study, PARTICIPANTS_FILE)?)?;
            let is_listed = |line: &TableLine| self.is_listed_in(line, id_column);
            remove_lines(study, PARTICIPANTS_FILE, is_listed)?;
        }
        Ok(())
    }
}

fn remove_lines(
    study: &Path,
    name: &str,
    is_removed: impl Fn(&TableLine) -> bool,
) -> Result<(), DiskError> {
    let rest = without_lines(&read_table(study, name)?, is_removed);
    disk::replace_file(&study.join(name), rest.as_bytes())
}

/// Returns the column of the participants' identifiers in the text of `participants.tsv`, which may be empty.
fn id_column(study: &Path, text: &str) -> Result<usize, StudyError> {
    if table_lines(text).is_empty() {
        return Ok(0);
    }
    let table = TabTable::parse(text.to_owned(), ID_COLUMN).map_err(|fault| StudyError::Table {
        path: study.join(PARTICIPANTS_FILE),
        reason: fault.to_string(),
    })?;
    Ok(table.column(ID_COLUMN).unwrap_or_default())
}

fn read_table(study: &Path, name: &str) -> Result<String, DiskError> {
    let path = study.join(name);
    match bounded_files::read_text(&path, bounded_files::TEXT_LIMIT_BYTES) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(String::new()),
        table => table.with_path("read", &path),
    }
}

fn note_removal(study: &Path, date: &str) -> Result<(), DiskError> {
    let path = study.join(REMOVALS_FILE);
    let mut file = bounded_files::open_in_place(&path).with_path("open", &path)?;
    let is_new = file.metadata().with_path("read", &path)?.len() == 0;
    let header = if is_new { REMOVALS_HEADER } else { "" };
    drop(file);
    file = OpenOptions::new()
        .append(true)
        .open(&path)
        .with_path("open", &path)?;
    file.write_all(format!("{header}{date}\ta participant was removed\n").as_bytes())
        .with_path("write", &path)?;
    file.sync_all().with_path("sync", &path)?;
    disk::sync_folder(study)
}
