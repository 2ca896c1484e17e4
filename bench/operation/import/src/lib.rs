//! Recordings made elsewhere, written into a study by a map.
//!
//! [`import`] reads each file that the map's pattern matches, converts it, and puts it into its place in the study; [`remove`] takes
//! back what a map brought. Files are independent: one that is refused stops no other.

mod alignment;
mod checks;
mod constants;
mod data_files;
mod derivative;
mod description;
mod envelopes;
mod figure;
mod files;
mod forces_alone;
mod intervals;
mod modulation;
mod place;
mod plate;
mod readings;
mod refusal;
mod search;
mod series;
mod signals;
mod sources;
mod survey;
mod tare;
mod wav_file;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use import_map::{Assignment, Electrical, ImportMap, MapErrors, NamedFile, People, assign};
use rayon::prelude::*;
use recording::manifest::{FoundValue, ImportedMap};
use recording::study::{GeneratedBy, Study, StudyError};

use description::Description;
use place::{Place, State};
pub use refusal::ImportRefusal;
use sources::{Sources, Sums};

/// Reason why nothing is imported.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The map cannot be read.
    #[error("{}: {cause}", path.display())]
    Map {
        /// The map.
        path: PathBuf,
        /// Reason and remedy.
        cause: String,
    },
    /// The map has errors.
    #[error("{0}")]
    Keys(#[from] MapErrors),
    /// No file matches the map's pattern.
    #[error("no file below {} matches the map's `files`{}; the pattern is compared with the whole path relative to the map", folder.display(), .example.as_ref().map(|example| format!(", such as {example}")).unwrap_or_default())]
    NoFile {
        /// Folder of the map.
        folder: PathBuf,
        /// A file that is there.
        example: Option<String>,
    },
    /// The study cannot be opened.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The table of participants cannot be read.
    #[error("{}: {reason}", path.display())]
    People {
        /// The table.
        path: PathBuf,
        /// Reason and remedy.
        reason: String,
    },
    /// The folder for a trial run cannot be made.
    #[error("{path}: {cause}", path = path.display())]
    Trial {
        /// The folder.
        path: PathBuf,
        /// Reason.
        cause: String,
    },
}

/// A map with its files.
#[derive(Debug)]
pub struct Plan {
    folder: PathBuf,
    map: ImportMap,
    origin: ImportedMap,
    assignment: Assignment,
    people: Option<People>,
}

/// Outcome of a file.
#[derive(Debug)]
pub enum Outcome {
    /// The recording was written.
    Written,
    /// The recording replaced that of an earlier state of the map or of its files.
    Replaced,
    /// The recording was there already.
    Unchanged,
    /// The recording was converted and not written.
    Checked,
}

/// Report of a file.
#[derive(Debug)]
pub struct FileReport {
    /// Path relative to the map's folder.
    pub file: String,
    /// Recording within the study, such as `sub-01/ses-01/trial-001_attempt-1`; empty if the file has no place.
    pub recording: String,
    /// Outcome.
    pub outcome: Result<Outcome, ImportRefusal>,
    /// Values found in the data, in words.
    pub found: Vec<String>,
    /// Sentences for a user.
    pub notes: Vec<String>,
}

impl Plan {
    /// Reads a map and finds its files.
    ///
    /// # Errors
    /// The map has errors, no file matches it, or its table of participants cannot be read.
    pub fn read(path: &Path) -> Result<Self, ImportError> {
        let map_error = |cause| ImportError::Map {
            path: path.to_owned(),
            cause,
        };
        let bytes = bounded_files::read(path, bounded_files::TEXT_LIMIT_BYTES)
            .map_err(|error| map_error(bounded_files::cause(&error)))?;
        let text = bounded_files::as_text(&bytes).map_err(|error| map_error(error.to_string()))?;
        let map = ImportMap::parse(text, &path.display().to_string())?;
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        let paths = files::list(&folder).map_err(|error| ImportError::Map {
            path: folder.clone(),
            cause: bounded_files::cause(&error),
        })?;
        let assignment = assign(&map.pattern, &paths);
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        if assignment.files.is_empty() && assignment.refusals.is_empty() {
            let example = paths.into_iter().find(|other| Some(other) != name.as_ref());
            return Err(ImportError::NoFile { folder, example });
        }
        let people = match &map.participants {
            None => None,
            Some(table) => {
                let path = folder.join(table);
                let people_error = |reason| ImportError::People {
                    path: path.clone(),
                    reason,
                };
                let text = bounded_files::read_text(&path, bounded_files::TEXT_LIMIT_BYTES)
                    .map_err(|error| people_error(bounded_files::cause(&error)))?;
                Some(People::parse(&text).map_err(people_error)?)
            }
        };
        Ok(Self {
            folder,
            origin: ImportedMap {
                file: name.unwrap_or_default(),
                sha256: sources::sum(&bytes),
            },
            map,
            assignment,
            people,
        })
    }

    /// Returns sentences for a user about all files.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.assignment.notes
    }

    /// Returns the number of files.
    #[must_use]
    pub fn file_count(&self) -> usize {
        self.assignment.files.len() + self.assignment.refusals.len()
    }
}

/// Program that imports.
#[derive(Debug, Clone, Copy)]
pub struct Program<'a> {
    /// Version.
    pub version: &'a str,
}

/// Imports the files of a plan into the study, or, without one, converts them and writes nothing; `report` is called after each
/// file, from several threads. Returns true if no file was refused.
///
/// # Errors
/// The study cannot be opened or continued.
pub fn import(
    plan: &Plan,
    study: Option<&Path>,
    program: Program<'_>,
    report: impl Fn(&FileReport) + Sync,
) -> Result<bool, ImportError> {
    let opened = match study {
        None => None,
        Some(folder) => Some(Study::open_or_create(
            folder,
            GeneratedBy {
                name: "friction-bench".to_owned(),
                version: program.version.to_owned(),
            },
        )?),
    };
    let trial_folder = tempfile::tempdir().map_err(|error| ImportError::Trial {
        path: std::env::temp_dir(),
        cause: bounded_files::cause(&error),
    })?;
    let folder = study.unwrap_or(trial_folder.path());
    let mut is_whole = true;
    for (file, _) in &plan.assignment.refusals {
        is_whole = false;
        let error = plan
            .assignment
            .refusals
            .iter()
            .find(|(other, _)| other == file);
        if let Some((_, error)) = error {
            report(&FileReport {
                file: file.clone(),
                recording: String::new(),
                outcome: Err(error.clone().into()),
                found: Vec::new(),
                notes: Vec::new(),
            });
        }
    }
    let copies = copies(plan);
    let outcomes: Vec<(&NamedFile, bool)> = plan
        .assignment
        .files
        .par_iter()
        .map(|file| {
            let mut file_report = FileReport {
                file: file.path.clone(),
                recording: Place::name(file),
                outcome: Ok(Outcome::Checked),
                found: Vec::new(),
                notes: Vec::new(),
            };
            file_report.outcome = match copies.get(&file.path) {
                Some(other) => Err(ImportRefusal::SameBytes {
                    other: other.clone(),
                }),
                None => import_file(
                    plan,
                    file,
                    (folder, study.is_some()),
                    program,
                    &mut file_report,
                ),
            };
            report(&file_report);
            (file, file_report.outcome.is_ok())
        })
        .collect();
    is_whole &= outcomes.iter().all(|(_, is_done)| *is_done);
    if let Some(study) = opened {
        let done = outcomes.iter().filter(|(_, is_done)| *is_done);
        let mut participants: Vec<_> = done.map(|(file, _)| &file.participant).collect();
        participants.dedup();
        for participant in participants {
            let row = plan
                .people
                .as_ref()
                .and_then(|people| people.row(participant));
            study.list_imported(participant, &row.unwrap_or_default())?;
        }
    }
    Ok(is_whole)
}

/// Returns the files that have the bytes of a file of another participant, with that file.
fn copies(plan: &Plan) -> BTreeMap<String, String> {
    let sums: Vec<(&NamedFile, Option<String>)> = plan
        .assignment
        .files
        .par_iter()
        .map(|file| (file, Sums::default().of(&plan.folder.join(&file.path)).ok()))
        .collect();
    let mut by_sum: BTreeMap<&str, Vec<&NamedFile>> = BTreeMap::new();
    for (file, sum) in &sums {
        if let Some(sum) = sum {
            by_sum.entry(sum).or_default().push(file);
        }
    }
    let mut copies = BTreeMap::new();
    for files in by_sum.values() {
        for file in files {
            let other = files
                .iter()
                .find(|other| other.participant != file.participant);
            if let Some(other) = other {
                copies.insert(file.path.clone(), other.path.clone());
            }
        }
    }
    copies
}

fn import_file(
    plan: &Plan,
    file: &NamedFile,
    (study, is_kept): (&Path, bool),
    program: Program<'_>,
    report: &mut FileReport,
) -> Result<Outcome, ImportRefusal> {
    let place = Place::new(study, file);
    let mut sources = Sources::new(&plan.folder, &file.path, &file.captures);
    sources.open_all(&plan.map)?;
    let origins = sources.origins(&mut Sums::default())?;
    let state = place.state(&plan.origin, &origins, &file.path)?;
    if state == State::Same {
        return Ok(Outcome::Unchanged);
    }
    let description = Description {
        file,
        map: &plan.origin,
        sources: origins,
        version: program.version,
        body: plan.map.body,
    };
    let unfinished = place.begin()?;
    let target = (unfinished.as_path(), report.recording.as_str());
    let converted = match &plan.map.electrical {
        Electrical::Signals { .. } => {
            signals::convert(&plan.map, &mut sources, target, &description)
        }
        Electrical::Envelopes { .. } => {
            envelopes::convert(&plan.map, &mut sources, target, &description)
        }
        Electrical::Stimulus(_) => {
            forces_alone::convert(&plan.map, &mut sources, target, &description)
        }
    };
    let (found, notes): (Vec<FoundValue>, Vec<String>) = match converted {
        Ok(converted) => converted,
        Err(refusal) => {
            place.abandon(&unfinished);
            return Err(refusal);
        }
    };
    report.found = found.iter().map(figure::line).collect();
    report.notes = sources.notes();
    report.notes.extend(notes);
    if !is_kept {
        place.abandon(&unfinished);
        return Ok(Outcome::Checked);
    }
    place.complete(&unfinished)?;
    Ok(match state {
        State::Earlier => Outcome::Replaced,
        _ => Outcome::Written,
    })
}

/// What a removal did.
#[derive(Debug, Default)]
pub struct Removal {
    /// Recordings that were removed, within the study.
    pub removed: Vec<String>,
    /// Sentences for a user: what stays, and why.
    pub notes: Vec<String>,
}

/// Takes back what the map at `path` brought into a study: recordings whose description states the map's sum, and the rows that
/// the import added to `participants.tsv`.
///
/// # Errors
/// The map or the study cannot be read, or the operating system refuses.
pub fn remove(path: &Path, study: &Path) -> Result<Removal, ImportError> {
    let map_error = |cause| ImportError::Map {
        path: path.to_owned(),
        cause,
    };
    let bytes = bounded_files::read(path, bounded_files::TEXT_LIMIT_BYTES)
        .map_err(|error| map_error(bounded_files::cause(&error)))?;
    let sha256 = sources::sum(&bytes);
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    let opened = Study::open(study)?;
    let disk_error = |error: recording::DiskError| ImportError::Study(error.into());
    let mut removal = Removal::default();
    for participant in recording::disk::entries(study).map_err(disk_error)? {
        let Ok(id) = participant.parse::<protocols::ParticipantId>() else {
            continue;
        };
        let folder = study.join(&participant);
        if !folder.is_dir() {
            continue;
        }
        let mut has_removed = false;
        for session in recording::disk::entries(&folder).map_err(disk_error)? {
            let session_folder = folder.join(&session);
            if !session_folder.is_dir() {
                continue;
            }
            for recording in recording::disk::entries(&session_folder).map_err(disk_error)? {
                let recording_folder = session_folder.join(&recording);
                let Some(imported) = place::imported(&recording_folder) else {
                    continue;
                };
                let name_in_study = format!("{participant}/{session}/{recording}");
                if imported.map.sha256 != sha256 {
                    if imported.map.file == name {
                        removal.notes.push(format!(
                            "{name_in_study} came from an earlier state of {name} and stays: import again, then remove"
                        ));
                    }
                    continue;
                }
                let others =
                    place::remove(&recording_folder).map_err(|error| ImportError::Map {
                        path: recording_folder.clone(),
                        cause: bounded_files::cause(&error),
                    })?;
                if !others.is_empty() {
                    removal.notes.push(format!(
                        "{name_in_study}: {} did not come from the map, and stays",
                        others.join(", ")
                    ));
                }
                removal.removed.push(name_in_study);
                has_removed = true;
            }
        }
        if has_removed && !folder.exists() {
            opened.unlist_imported(&id)?;
        }
    }
    Ok(removal)
}
