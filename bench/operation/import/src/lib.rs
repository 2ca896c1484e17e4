//! Recordings made elsewhere, written into a study by a map.
//!
//! [`import`] reads each file that the map's pattern matches, converts it, and puts it into its place in the study; [`remove`]
//! removes the recordings of a map. Files are independent: one that is refused stops no other.

mod alignment;
mod analysis_flaws;
mod checks;
mod constants;
mod converted;
mod copies;
mod data_files;
mod derivative;
mod description;
mod envelopes;
mod figure;
mod files;
mod forces_alone;
mod intervals;
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
mod trial_space;
mod wav_file;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use force_alignment::{Estimate, joint_rate};
use import_map::{
    Assignment, Electrical, ImportMap, MapErrors, NamedFile, People, Quantity, assign,
};
use rayon::prelude::*;
use recording::manifest::ImportedMap;
use recording::study::{GeneratedBy, Study, StudyError};

use converted::Converted;
use copies::Copies;
use description::Description;
use place::{Place, State};
pub use refusal::ImportRefusal;
use sources::{Sources, Sums};
pub use trial_space::TrialSpace;

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

/// Size from which on a file is converted alone, bytes.
const LARGE_BYTES: u64 = 200_000_000;

/// Mark of a guessed line.
const CHECK_MARK: &str = "# CHECK";

/// A map with its files.
#[derive(Debug)]
pub struct Plan {
    folder: PathBuf,
    map: ImportMap,
    origin: ImportedMap,
    assignment: Assignment,
    people: Option<People>,
    notes: Vec<String>,
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
    /// The map cannot be read, or as [`parse`](Self::parse).
    pub fn read(path: &Path) -> Result<Self, ImportError> {
        let map_error = |cause| ImportError::Map {
            path: path.to_owned(),
            cause,
        };
        let bytes = bounded_files::read(path, bounded_files::TEXT_LIMIT_BYTES)
            .map_err(|error| map_error(bounded_files::cause(&error)))?;
        let text = bounded_files::as_text(&bytes).map_err(|error| map_error(error.to_string()))?;
        Self::parse(text, path)
    }

    /// Reads the map in `text`, which has its place at `path`, and finds its files below that folder.
    ///
    /// # Errors
    /// The map has errors, no file matches it, or its table of participants cannot be read.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ImportError> {
        let map = ImportMap::parse(text, &path.display().to_string())?;
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        let listing = files::list(&folder).map_err(|error| ImportError::Map {
            path: folder.clone(),
            cause: bounded_files::cause(&error),
        })?;
        let paths = &listing.paths;
        let assignment = assign(&map.pattern, paths);
        let name = path
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        if assignment.files.is_empty() && assignment.refusals.is_empty() {
            let example = paths
                .iter()
                .find(|path| Some(*path) != name.as_ref())
                .cloned();
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
        let mut notes = assignment.notes.clone();
        notes.extend(repeated_trials(&map, &assignment));
        notes.extend(other_case(&map, paths));
        notes.extend(listing.notes());
        notes.extend(unconfirmed(text, &path.display().to_string()));
        if let (Some(people), Some(table)) = (&people, &map.participants) {
            notes.extend(unmatched(people, table, &assignment));
        }
        Ok(Self {
            folder,
            notes,
            origin: ImportedMap {
                file: name.unwrap_or_default(),
                sha256: sources::sum(text.as_bytes()),
            },
            map,
            assignment,
            people,
        })
    }

    fn recorded_paths(&self) -> Vec<PathBuf> {
        let files = self.assignment.files.iter();
        let names = files.flat_map(|file| copies::recorded_files(&self.map, file));
        let names: BTreeSet<String> = names.collect();
        names.iter().map(|name| self.folder.join(name)).collect()
    }

    /// Returns sentences for a user about all files.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns whether the rates of the forces' clocks are to be found.
    fn asks_for_rates(&self) -> bool {
        let normal = self.map.normal.as_ref();
        normal.is_some_and(|normal| normal.clock.ppm == Quantity::Found)
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
/// file, from several threads; once it breaks off, no further file is begun. Returns true if no file was refused, or left.
///
/// # Errors
/// The study cannot be opened or continued.
pub fn import(
    plan: &Plan,
    study: Option<&Path>,
    program: Program<'_>,
    report: impl Fn(&FileReport) -> ControlFlow<()> + Sync,
) -> Result<bool, ImportError> {
    let is_broken_off = AtomicBool::new(false);
    let report = |file: &FileReport| {
        if report(file).is_break() {
            is_broken_off.store(true, Ordering::Relaxed);
        }
    };
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
    for (file, error) in &plan.assignment.refusals {
        is_whole = false;
        report(&FileReport {
            file: file.clone(),
            recording: String::new(),
            outcome: Err(error.clone().into()),
            found: Vec::new(),
            notes: Vec::new(),
        });
    }
    let mut context = Context {
        program,
        sums: Sums::compute(plan.recorded_paths()),
        rates: CommonRates::new(),
    };
    let copies = Copies::find(
        &plan.assignment.files,
        &plan.map,
        &plan.folder,
        &context.sums,
    );
    let scratch = trial_folder.path().join("rates");
    context.rates = common_rates(plan, folder, &scratch, &context);
    let convert = |file: &'_ NamedFile| {
        if is_broken_off.load(Ordering::Relaxed) {
            return false;
        }
        let mut file_report = FileReport {
            file: file.path.clone(),
            recording: Place::name(file),
            outcome: Ok(Outcome::Checked),
            found: Vec::new(),
            notes: Vec::new(),
        };
        file_report.outcome = match copies.refusal(file) {
            Some(refusal) => Err(refusal),
            None => import_file(
                plan,
                file,
                (folder, study.is_some()),
                &context,
                &mut file_report,
            ),
        };
        file_report.notes.extend(copies.remark(file));
        report(&file_report);
        file_report.outcome.is_ok()
    };
    // Some formats are held in memory: large files follow each other.
    let files = plan.assignment.files.iter();
    let (large, small): (Vec<&NamedFile>, Vec<&NamedFile>) =
        files.partition(|file| is_large(&plan.folder, file));
    let mut outcomes: Vec<(&NamedFile, bool)> = small
        .par_iter()
        .map(|file| (*file, convert(file)))
        .collect();
    outcomes.extend(large.into_iter().map(|file| (file, convert(file))));
    is_whole &= outcomes.iter().all(|(_, is_done)| *is_done);
    if let Some(study) = opened {
        let done = outcomes.iter().filter(|(_, is_done)| *is_done);
        let participants: BTreeSet<_> = done.map(|(file, _)| &file.participant).collect();
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

/// Returns the remark about files that are one trial by their names, of which an analysis takes the last.
fn repeated_trials(map: &ImportMap, assignment: &Assignment) -> Option<String> {
    if map.pattern.groups().any(|group| group == "attempt") {
        return None;
    }
    let again = |pair: &&[NamedFile]| {
        let key = |file: &NamedFile| (file.participant.clone(), file.session, file.trial);
        key(&pair[0]) == key(&pair[1])
    };
    let pair = assignment.files.windows(2).find(again)?;
    let [first, second] = pair else { return None };
    Some(format!(
        "{} and {} are one trial by their names, and become its attempts {} and {}, of which `analyze` takes the last: let `files` \
         capture what tells them apart, as (?<session>…)",
        first.path, second.path, first.attempt, second.attempt
    ))
}

/// Returns the remark about files that the pattern would match in small letters alone.
fn other_case(map: &ImportMap, paths: &[String]) -> Option<String> {
    let is_left = |path: &&String| {
        map.pattern.captures(path).is_none() && map.pattern.captures(&path.to_lowercase()).is_some()
    };
    let left: Vec<&String> = paths.iter().filter(is_left).collect();
    let first = left.first()?;
    Some(format!(
        "{first}{} left out: `files` matches {} in small letters only; begin it with (?i)",
        if left.len() == 1 {
            " is".to_owned()
        } else {
            format!(" and {} more are", left.len() - 1)
        },
        if left.len() == 1 { "it" } else { "them" }
    ))
}

/// Returns whether a file is converted alone.
fn is_large(folder: &Path, file: &NamedFile) -> bool {
    source_bytes(folder, file) > LARGE_BYTES
}

/// Returns the size of a recording's files, bytes; a file that cannot be opened has none.
fn source_bytes(folder: &Path, file: &NamedFile) -> u64 {
    let sizes = file
        .paths()
        .map(|path| std::fs::metadata(folder.join(path)).map_or(0, |file| file.len()));
    sizes.sum()
}

/// Returns the remark about rows of the table of people that are of no file's participant, and about participants without a row.
fn unmatched(people: &People, table: &str, assignment: &Assignment) -> Option<String> {
    let participants = assignment.files.iter().map(|file| &file.participant);
    let (rows, absentees) = people.unmatched(&participants.collect());
    let absentees: Vec<&str> = absentees
        .iter()
        .map(|participant| participant.as_str())
        .collect();
    let rows = (!rows.is_empty()).then(|| {
        format!(
            "its rows {} are of no participant of the files",
            rows.join(", ")
        )
    });
    let absentees = (!absentees.is_empty()).then(|| {
        format!(
            "it has no row of {}, whose columns will be n/a",
            absentees.join(", ")
        )
    });
    let parts: Vec<String> = rows.into_iter().chain(absentees).collect();
    (!parts.is_empty()).then(|| format!("{table}: {}", parts.join("; ")))
}

/// Returns the remark about the lines of a guessed map that nobody has confirmed.
fn unconfirmed(map: &str, file: &str) -> Option<String> {
    let lines: Vec<String> = (1..)
        .zip(map.lines())
        .filter(|(_, line)| line.contains(CHECK_MARK))
        .map(|(number, _)| number.to_string())
        .collect();
    let numbers = lines.join(", ");
    match lines.len() {
        0 => None,
        1 => Some(format!(
            "{file}: line {numbers} is marked {CHECK_MARK}: its value is a guess that nobody has confirmed; remove the mark once it is right"
        )),
        count => Some(format!(
            "{file}: {count} lines are marked {CHECK_MARK} ({numbers}): their values are guesses that nobody has confirmed; remove each \
             mark once its value is right"
        )),
    }
}

/// A file on its way to its recording.
struct Job<'a> {
    sources: Sources<'a>,
    description: Description<'a>,
    place: Place,
    state: State,
}

impl<'a> Job<'a> {
    fn new(
        plan: &'a Plan,
        file: &'a NamedFile,
        study: &Path,
        context: &Context<'a>,
    ) -> Result<Self, ImportRefusal> {
        let place = Place::new(study, file);
        let mut sources = Sources::new(&plan.folder, file);
        sources.open_all(&plan.map)?;
        let origins = sources.origins(&mut context.sums.clone())?;
        Ok(Self {
            state: place.state(&plan.origin, &origins, &file.path)?,
            description: Description {
                file,
                map: &plan.origin,
                sources: origins,
                version: context.program.version,
                body: plan.map.body,
            },
            sources,
            place,
        })
    }

    /// Converts the file into a folder beside its place; returns the folder too.
    fn convert(
        &mut self,
        map: &ImportMap,
        common_ppm: Option<Estimate>,
    ) -> Result<(PathBuf, Converted), ImportRefusal> {
        let unfinished = self.place.begin()?;
        let name = Place::name(self.description.file);
        let target = (unfinished.as_path(), name.as_str());
        let (sources, description) = (&mut self.sources, &self.description);
        let converted = match &map.electrical {
            Electrical::Signals { .. } => {
                signals::convert(map, sources, target, description, common_ppm)
            }
            Electrical::Envelopes { .. } => {
                envelopes::convert(map, sources, target, description, common_ppm)
            }
            Electrical::Stimulus(_) => forces_alone::convert(map, sources, target, description),
        };
        match converted {
            Ok(converted) => Ok((unfinished, converted)),
            Err(refusal) => {
                self.place.abandon(&unfinished);
                Err(refusal)
            }
        }
    }
}

/// Data common to all files of an import.
struct Context<'a> {
    program: Program<'a>,
    /// Sums of the files with what was recorded.
    sums: Sums,
    rates: CommonRates,
}

/// Rates of the forces' clock, common to the recordings of a session, by participant and session.
type CommonRates = BTreeMap<(String, u32), Estimate>;

/// Finds the rates of the forces' clocks if the map asks for them: a session's recordings are converted once each in `scratch`, and
/// the rates that they show are averaged. Sessions with a single recording, or with nothing to import, are left out.
fn common_rates(plan: &Plan, study: &Path, scratch: &Path, context: &Context<'_>) -> CommonRates {
    if !plan.asks_for_rates() {
        return CommonRates::new();
    }
    let mut sessions: BTreeMap<(String, u32), Vec<&NamedFile>> = BTreeMap::new();
    for file in &plan.assignment.files {
        sessions
            .entry((file.participant.to_string(), file.session))
            .or_default()
            .push(file);
    }
    let is_due = |file: &&NamedFile| {
        Job::new(plan, file, study, context).is_ok_and(|job| job.state != State::Same)
    };
    let rate = |file: &&NamedFile| {
        let mut job = Job::new(plan, file, scratch, context).ok()?;
        let (unfinished, converted) = job.convert(&plan.map, None).ok()?;
        job.place.abandon(&unfinished);
        let ppm = converted.ppm?;
        Some(Estimate {
            value: 1e-6 * ppm.value,
            std: 1e-6 * ppm.std,
        })
    };
    let due = sessions
        .into_iter()
        .filter(|(_, files)| files.len() > 1 && files.iter().any(is_due));
    due.filter_map(|(session, files)| {
        let rates: Vec<Estimate> = files.par_iter().filter_map(rate).collect();
        let common = joint_rate(&rates).filter(|_| rates.len() > 1)?;
        Some((
            session,
            Estimate {
                value: 1e6 * common.value,
                std: 1e6 * common.std,
            },
        ))
    })
    .collect()
}

fn import_file(
    plan: &Plan,
    file: &NamedFile,
    (study, is_kept): (&Path, bool),
    context: &Context<'_>,
    report: &mut FileReport,
) -> Result<Outcome, ImportRefusal> {
    let mut job = Job::new(plan, file, study, context)?;
    if job.state == State::Same {
        return Ok(Outcome::Unchanged);
    }
    let common_ppm = context
        .rates
        .get(&(file.participant.to_string(), file.session));
    let (unfinished, converted) = job.convert(&plan.map, common_ppm.copied())?;
    report.found = converted.found.iter().map(figure::line).collect();
    report.notes = job.sources.notes();
    report.notes.extend(converted.notes);
    if !is_kept {
        job.place.abandon(&unfinished);
        return Ok(Outcome::Checked);
    }
    job.place.complete(&unfinished)?;
    Ok(match job.state {
        State::Earlier => Outcome::Replaced,
        _ => Outcome::Written,
    })
}

/// Outcome of a removal.
#[derive(Debug, Default)]
pub struct Removal {
    /// Recordings that were removed, within the study.
    pub removed: Vec<String>,
    /// Sentences for a user about recordings and files that stay, with the reason.
    pub notes: Vec<String>,
}

/// Removes the contribution of the map at `path` from a study: recordings whose description states the map's sum, and the rows that
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
