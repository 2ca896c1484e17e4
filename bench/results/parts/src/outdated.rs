//! Parts of recordings that a study no longer has: excluded or removed since. They are removed, so that nobody who asks the parts
//! counts a person who has withdrawn.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use recording::DiskError;
use recording::disk::OnPath;

use crate::call::Call;
use crate::entry::Entry;
use crate::layout::{Layout, Place, UNKNOWN};
use crate::part_outcome::{PartOutcome, PartState};
use crate::parts_error::PartsError;
use crate::stored_file::{paths, read_value, write_value};

/// Entry of a recording, with its file.
type StoredEntry = (PathBuf, Entry);

/// Removes what a folder of parts has of recordings that `call` asked for and no call finds any more; returns the outcome of each
/// part. Parts of another laboratory stay, with the remedy.
///
/// # Errors
/// A file cannot be read, written or removed.
pub(crate) fn remove_outdated(
    layout: &Layout,
    call: &Call,
    lab: Option<&str>,
) -> Result<Vec<PartOutcome>, PartsError> {
    // Nothing else is in these folders, and the index is long where each recording has a call of its own.
    if call.names_recordings() {
        return Ok(Vec::new());
    }
    // A call is written before its entries: read in the other order, each entry has its call.
    let entries = entries(layout)?;
    let is_foreign = |entry: &Entry| {
        let place = entry.part.as_ref().ok();
        place.is_some_and(|place| place.lab != laboratory(lab, entry.study.as_deref()))
    };
    let foreign = entries.iter().filter(|(_, entry)| is_foreign(entry));
    let foreign: BTreeSet<&PathBuf> = foreign.map(|(path, _)| path).collect();
    let Some(recordings) = known_recordings(layout, call, &foreign)? else {
        return Ok(Vec::new());
    };
    let known: BTreeSet<PathBuf> = recordings.iter().map(|path| layout.entry(path)).collect();
    let sessions: BTreeSet<&Path> = recordings.iter().filter_map(|path| path.parent()).collect();
    let (current, lost): (Vec<&StoredEntry>, Vec<&StoredEntry>) =
        entries.iter().partition(|(path, _)| known.contains(path));
    let places: BTreeSet<&Place> = current.iter().flat_map(|(_, entry)| &entry.part).collect();
    let mut outcomes = Vec::new();
    for (path, entry) in lost {
        let Some(folder) = entry.folder().filter(|folder| call.asks_for(folder)) else {
            continue;
        };
        let part = entry.part.as_ref().ok();
        if foreign.contains(path) {
            outcomes.extend(part.map(|place| foreign_part(layout, folder, place)));
            continue;
        }
        if let Some(place) = part.filter(|place| !places.contains(place)) {
            outcomes.push(PartOutcome::lost_part(folder, PartState::Removed, place));
            for file in [layout.part(place), layout.series(place)] {
                remove(&file)?;
                // Another part may be in the folder.
                let _ = file.parent().map(fs::remove_dir);
            }
        }
        if let Some(session) = entry.session().filter(|folder| !sessions.contains(folder)) {
            remove(&layout.session(session))?;
        }
        // The entry is what remembers the part, so it is removed last.
        remove(path)?;
    }
    Ok(outcomes)
}

/// Returns the laboratory of a recording in a study: as named, or the name of the study's folder.
pub(crate) fn laboratory(named: Option<&str>, study: Option<&Path>) -> String {
    let study = study.and_then(Path::file_name);
    let study = study.map(|name| name.to_string_lossy().into_owned());
    let laboratory = named.map(str::to_owned).or(study);
    laboratory.unwrap_or_else(|| UNKNOWN.to_owned())
}

/// Reads the entries. A damaged one is left: its recording is analysed again.
fn entries(layout: &Layout) -> Result<Vec<StoredEntry>, DiskError> {
    let paths = paths(&layout.recordings())?.into_par_iter();
    let entries = paths.filter_map(|path| {
        let entry = read_value(&path).ok().flatten()?;
        Some((path, entry))
    });
    Ok(entries.collect())
}

/// Returns the canonical paths of the recordings that the calls ask for, after the calls for folders within those of `call` lost the recordings
/// that are gone or excluded; `None` if a call cannot be read, and with it what it asks for.
fn known_recordings(
    layout: &Layout,
    call: &Call,
    foreign: &BTreeSet<&PathBuf>,
) -> Result<Option<BTreeSet<PathBuf>>, PartsError> {
    let excluded = call.excluded();
    let is_lost = |recording: &Path| {
        (excluded.contains(recording) || !recording.exists())
            && !foreign.contains(&layout.entry(recording))
    };
    let mut known = BTreeSet::new();
    let own = call.path(layout);
    for path in paths(&layout.calls())? {
        let Ok(Some(mut other)) = read_value::<Call>(&path) else {
            return Ok(None);
        };
        if path != own && call.contains(&other) && other.leave_out(is_lost) {
            if other.recordings().next().is_none() {
                remove(&path)?;
            } else {
                write_value(&path, &other)?;
            }
        }
        known.extend(other.recordings().cloned());
    }
    Ok(Some(known))
}

/// Returns the outcome of a part that may be of a study of another laboratory at the same path.
fn foreign_part(layout: &Layout, folder: &Path, place: &Place) -> PartOutcome {
    let remedy = format!(
        "its recording is no longer in the study, but its part is of laboratory {}: if that is this study, delete {}",
        place.lab,
        layout.part(place).display()
    );
    PartOutcome {
        remedy: Some(remedy),
        ..PartOutcome::lost_part(folder, PartState::Foreign, place)
    }
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<(), DiskError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        result => result.with_path("remove", path),
    }
}
