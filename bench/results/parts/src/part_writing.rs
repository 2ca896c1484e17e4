//! `analyze --each`: a part for each recording, written once.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use analysis::assumptions::Assumptions;
use analysis::people::{self, Person};
use analysis::recording_analysis::analyse_with_series;
use analysis::{Analysis, KeptSeries, Settings};
use descriptive::Description;
use rayon::prelude::*;
use recording::reader::read_manifest;
use study::sessions::{RecordedSession, Sessions, Standing};
use study_analysis::{Found, Request};
use tables::column::{Column, Values};
use tables::{Content, TableKind};

use crate::call::Call;
use crate::entry::{Entry, Verdict};
use crate::inputs::{Inputs, KnownSums};
use crate::key::Key;
use crate::layout::{Layout, Place, UNKNOWN};
use crate::outdated::{laboratory, remove_outdated};
use crate::part_file;
use crate::part_outcome::{PartOutcome, PartState};
use crate::parts_error::PartsError;
use crate::stored_file::{clean, read_value, write, write_value};

/// Request for parts.
#[derive(Debug)]
pub struct PartsRequest<'a> {
    /// Request, which found the recordings.
    pub request: &'a Request,
    /// Recordings found.
    pub found: &'a Found,
    /// Assumptions, from which the settings follow.
    pub assumptions: &'a Assumptions,
    /// Name of the laboratory; `None` for the name of each study's folder.
    pub lab: Option<&'a str>,
    /// Whether the sums of all files are computed anew.
    pub verify_inputs: bool,
}

/// Writes the parts that are not yet in `folder`, and removes those of recordings that the study no longer has; `callback`
/// is called after each recording, from several threads.
///
/// # Errors
/// The folder cannot be written, or an assumption cannot be made. A recording that cannot be analysed stops no other.
pub fn write_parts(
    folder: &Path,
    request: &PartsRequest<'_>,
    callback: impl Fn(&PartOutcome) + Sync,
) -> Result<(), PartsError> {
    let layout = Layout::new(folder);
    clean(folder);
    let settings = request.assumptions.settings()?;
    let recordings = request.found.recordings();
    let sessions = Sessions::from_recordings(recordings.iter().map(PathBuf::as_path));
    for (folder, log) in &sessions.list {
        let session = RecordedSession {
            folder: folder.clone(),
            log: log.clone(),
            calibration: sessions.calibrations.get(folder).cloned(),
        };
        write_value(&layout.session(folder), &session)?;
    }
    let call = Call::new(request.request, request.found, request.assumptions)?;
    write_value(&call.path(&layout), &call)?;
    remove_outdated(&layout, &call, request.lab)?
        .iter()
        .for_each(&callback);
    let work = Work {
        layout,
        settings,
        sessions,
        verdicts: Verdicts::new(request.found),
        request,
    };
    recordings.par_iter().try_for_each(|path| {
        let outcome = work.part(path)?;
        callback(&outcome);
        Ok(())
    })
}

/// Work on the recordings of a call.
struct Work<'a> {
    layout: Layout,
    settings: Settings,
    sessions: Sessions,
    verdicts: Verdicts<'a>,
    request: &'a PartsRequest<'a>,
}

/// Recordings that were accepted, and those that are analysed though the study excludes them.
struct Verdicts<'a> {
    accepted: BTreeSet<&'a PathBuf>,
    excluded: BTreeSet<&'a PathBuf>,
}

impl<'a> Verdicts<'a> {
    fn new(found: &'a Found) -> Self {
        let selected = found.attempts.selection.iter();
        let accepted = selected.filter(|attempt| attempt.standing == Some(Standing::Accepted));
        let overridden = found.selection.overridden.iter();
        Self {
            accepted: accepted.map(|attempt| &attempt.path).collect(),
            excluded: overridden.flat_map(|row| &row.recordings).collect(),
        }
    }

    fn verdict(&self, path: &PathBuf) -> Verdict {
        Verdict {
            is_accepted: self.accepted.contains(path),
            is_excluded: self.excluded.contains(path),
        }
    }
}

impl Work<'_> {
    /// Writes the part of a recording, unless it is there.
    fn part(&self, path: &PathBuf) -> Result<PartOutcome, PartsError> {
        let canonical = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let entry_path = self.layout.entry(&canonical);
        // A damaged entry is written anew.
        let old: Option<Entry> = read_value(&entry_path).ok().flatten();
        let manifest = read_manifest(path).ok();
        let study = people::study(path);
        let known = KnownSums {
            cached: old.as_ref().map_or(&[], |entry| &entry.inputs),
            sessions: &self.sessions,
            is_distrusted: self.request.verify_inputs,
        };
        let mut outcome = PartOutcome::new(path, PartState::Failed);
        let verdict = self.verdicts.verdict(path);
        let inputs = match Inputs::read(path, manifest.as_ref(), &known) {
            Ok(inputs) => inputs,
            Err(error) => {
                outcome.unread = Some(error.to_string());
                Inputs::default()
            }
        };
        outcome.changed = inputs.changed;
        let part = match &outcome.unread {
            Some(reason) => Err(reason.clone()),
            None => {
                let key = Key::new(&self.settings, &inputs.files);
                outcome.key = Some(key.clone());
                let person = people::person(path, manifest.as_ref());
                let place = self.place(key, study.as_deref(), person);
                let has_verdict = old.as_ref().is_none_or(|old| old.has_verdict(verdict));
                self.part_at(place, path, has_verdict, &mut outcome)?
            }
        };
        let manifest =
            manifest.filter(|manifest| part.is_ok() || people::has_participant(manifest));
        let person = people::person(path, manifest.as_ref());
        let entry = Entry {
            recording: Some(canonical),
            verdict: Some(verdict),
            study,
            participant: person.map(|(_, id)| id),
            inputs: inputs.files,
            part,
        };
        // The entry is what remembers the superseded part, so it is replaced last.
        self.remove_superseded(old.as_ref(), &entry);
        write_value(&entry_path, &entry)?;
        Ok(outcome)
    }

    fn place(&self, key: Key, study: Option<&Path>, person: Option<Person>) -> Place {
        Place {
            lab: laboratory(self.request.lab, study),
            participant: person.map_or_else(|| UNKNOWN.to_owned(), |(_, id)| id),
            key,
        }
    }

    /// Writes a part, unless it is there with the same verdict; returns its place, or the reason why the recording has none.
    fn part_at(
        &self,
        place: Place,
        path: &Path,
        has_verdict: bool,
        outcome: &mut PartOutcome,
    ) -> Result<Result<Place, String>, PartsError> {
        let files = [self.layout.part(&place), self.layout.series(&place)];
        if has_verdict && files.iter().all(|file| file.is_file()) {
            outcome.state = PartState::Kept;
            return Ok(Ok(place));
        }
        let (analysis, series) = analyse_with_series(path, &self.settings);
        if let Err(error) = &analysis.findings {
            let reason = error.to_string();
            outcome.analysis = Some(analysis);
            return Ok(Err(reason));
        }
        part_file::write_series(&files[1], &series)?;
        let series = KeptSeries::from(series);
        let mut recordings = vec![analysis];
        analysis::trace(&mut recordings, &self.sessions);
        people::name(&mut recordings);
        let analysed = analysis::complete(recordings, &self.settings, &series)?;
        let rows = self.rows((&analysed, &series), &place, &files[0])?;
        write(&files[0], &rows)?;
        outcome.state = PartState::Done;
        outcome.analysis = analysed.recordings.into_iter().next();
        Ok(Ok(place))
    }

    /// Returns the file with the rows of the instances of a recording, and its findings.
    fn rows(
        &self,
        (analysed, series): (&Analysis, &KeptSeries),
        place: &Place,
        path: &Path,
    ) -> Result<Vec<u8>, PartsError> {
        let content = Content {
            analysed,
            series,
            description: &Description::new(analysed),
            attempts: &self.request.found.attempts,
            selection: &self.request.found.selection,
        };
        let mut table = content.table(TableKind::Instances)?;
        let labs = vec![Arc::from(place.lab.as_str()); table.len()];
        table.columns.insert(
            0,
            Column {
                name: "lab".into(),
                unit: "",
                meaning: "laboratory".into(),
                values: Values::Text(labs),
            },
        );
        let mut metadata = Vec::new();
        for findings in analysed.findings() {
            let pairs = part_file::metadata(&place.key, findings);
            metadata.extend(pairs.map_err(|reason| PartsError::Encode {
                path: path.to_owned(),
                reason,
            })?);
        }
        Ok(tables::to_parquet(&table, analysed, metadata, path)?)
    }

    /// Removes the part that the recording had before its files or the settings changed.
    fn remove_superseded(&self, old: Option<&Entry>, new: &Entry) {
        let Some(Ok(place)) = old.map(|entry| &entry.part) else {
            return;
        };
        if new.part.as_ref() != Ok(place) {
            // Another process may have removed them.
            let _ = std::fs::remove_file(self.layout.part(place));
            let _ = std::fs::remove_file(self.layout.series(place));
        }
    }
}
