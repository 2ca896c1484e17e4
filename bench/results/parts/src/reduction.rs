//! `analyze --from`: the analysis that the parts are of, without the recordings.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use analysis::findings::{RecordingError, RecordingFindings};
use analysis::people::{self, Person};
use analysis::{RecordingAnalysis, RecordingSeries, SeriesError, SeriesSource};
use rayon::prelude::*;
use study::sessions::{RecordedSession, Sessions};
use study_analysis::StudyAnalysis;

use crate::call::JoinedCalls;
use crate::entry::Entry;
use crate::key::Key;
use crate::layout::{Layout, Place};
use crate::part_file;
use crate::parts_error::PartsError;
use crate::stored_file::read_value;

/// Returns the analysis of the recordings of which `folder` has the parts; `callback` is called after each one, from several
/// threads.
///
/// # Errors
/// [`PartsError`].
pub fn read_parts(
    folder: &Path,
    callback: impl Fn(&RecordingAnalysis) + Sync,
) -> Result<StudyAnalysis, PartsError> {
    let layout = Layout::new(folder);
    let mut calls = JoinedCalls::read(&layout)?;
    let entries = entries(&layout, &calls)?;
    let entries = without_copies(&mut calls, entries);
    let sessions = sessions(&layout, &calls)?;
    let recordings = calls.found.recordings().par_iter().zip(&entries);
    let recordings = recordings.map(|(path, entry)| {
        let recording = recording(&layout, path, entry)?;
        callback(&recording);
        Ok(recording)
    });
    let mut recordings: Vec<RecordingAnalysis> = recordings.collect::<Result<_, PartsError>>()?;
    analysis::trace(&mut recordings, &sessions);
    let people: Vec<Option<Person>> = entries.iter().map(Entry::person).collect();
    people::name_as(&mut recordings, people);
    let series = PartSeries {
        places: entries.into_iter().map(|entry| entry.part.ok()).collect(),
        layout,
    };
    let analysed = analysis::complete(recordings, &calls.settings, &series)?;
    let surroundings = (sessions, calls.excluded.as_slice());
    let mut study =
        StudyAnalysis::assemble(calls.found, (analysed, Box::new(series)), surroundings);
    study.is_damaged = calls.is_damaged;
    Ok(study)
}

/// Reads the entry of each recording.
fn entries(layout: &Layout, calls: &JoinedCalls) -> Result<Vec<Entry>, PartsError> {
    let paths = calls.canonical.par_iter();
    let entries = paths.map(|canonical| read_value::<Entry>(&layout.entry(canonical)));
    let entries: Vec<Option<Entry>> = entries.collect::<Result<_, _>>()?;
    let missing = entries.iter().zip(calls.found.recordings());
    let missing: Vec<&PathBuf> = missing
        .filter(|(entry, _)| entry.is_none())
        .map(|(_, path)| path)
        .collect();
    match missing.first() {
        Some(first) => Err(PartsError::Unfinished {
            first: (*first).clone(),
            count: missing.len(),
        }),
        None => Ok(entries.into_iter().flatten().collect()),
    }
}

/// Leaves out recordings with the part of another one: copies, which different calls found.
fn without_copies(calls: &mut JoinedCalls, entries: Vec<Entry>) -> Vec<Entry> {
    let mut numbers: BTreeMap<Key, usize> = BTreeMap::new();
    let originals = entries.iter().enumerate().map(|(number, entry)| {
        let place = entry.part.as_ref().ok()?;
        let first = *numbers.entry(place.key.clone()).or_insert(number);
        (first != number).then_some(first)
    });
    let originals: Vec<Option<usize>> = originals.collect();
    calls.leave_out_copies(&originals);
    let kept = entries.into_iter().zip(originals);
    kept.filter(|(_, original)| original.is_none())
        .map(|(entry, _)| entry)
        .collect()
}

/// Reads the sessions of the recordings, in their order.
fn sessions(layout: &Layout, calls: &JoinedCalls) -> Result<Sessions, PartsError> {
    let mut recorded: Vec<RecordedSession> = Vec::new();
    let mut places = BTreeMap::new();
    let mut known: BTreeMap<PathBuf, bool> = BTreeMap::new();
    for (path, canonical) in calls.found.recordings().iter().zip(&calls.canonical) {
        let Some(folder) = canonical.parent() else {
            continue;
        };
        let is_session = match known.get(folder) {
            Some(is_session) => *is_session,
            None => {
                let session = read_value(&layout.session(folder))?;
                known.insert(folder.to_owned(), session.is_some());
                let is_session = session.is_some();
                recorded.extend(session);
                is_session
            }
        };
        if is_session {
            places.insert(path.clone(), canonical.clone());
        }
    }
    Ok(Sessions::new(recorded, places))
}

fn recording(layout: &Layout, path: &Path, entry: &Entry) -> Result<RecordingAnalysis, PartsError> {
    let findings = match &entry.part {
        Ok(place) => Ok(RecordingFindings {
            path: path.to_owned(),
            ..part_file::read(&layout.part(place))?
        }),
        Err(reason) => Err(RecordingError::Known(reason.clone())),
    };
    Ok(RecordingAnalysis {
        path: path.to_owned(),
        participant: None,
        findings,
    })
}

/// Series of the recordings, read from their parts.
#[derive(Debug)]
struct PartSeries {
    layout: Layout,
    /// Place of the part of each recording, in their order; `None` without one.
    places: Vec<Option<Place>>,
}

impl SeriesSource for PartSeries {
    fn read(&self, recording: usize) -> Result<Arc<RecordingSeries>, SeriesError> {
        let place = self.places.get(recording).and_then(Option::as_ref);
        let place = place.ok_or(SeriesError::Absent(recording))?;
        let series = part_file::read_series(&self.layout.series(place));
        series
            .map(Arc::new)
            .map_err(|error| SeriesError::Part(error.to_string()))
    }
}
