//! A call of `analyze --each`: the attempts, exclusions and settings that belong to no single recording.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use analysis::Settings;
use analysis::assumptions::Assumptions;
use attempts::{Attempts, OmittedAttempt};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use study::exclusions::{Excluded, Exclusion, ExclusionsError};
use study::identity::Duplicate;
use study::sessions::Standing;
use study_analysis::{Found, Request};

use crate::identities::{AttemptInStudy, has_equal_inputs};
use crate::layout::Layout;
use crate::parts_error::PartsError;
use crate::stored_file::{paths, read_value};

/// A call of `analyze --each`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Call {
    version: String,
    /// Canonical paths of the folders that were asked for.
    folders: Vec<PathBuf>,
    name: String,
    assumptions: Assumptions,
    attempts: Attempts,
    /// Recordings that are analysed, in order.
    recordings: Vec<PathBuf>,
    exclusions: Vec<StoredExclusion>,
    overridden: Vec<StoredExclusion>,
    /// Recordings that were left out on purpose.
    excluded: Vec<PathBuf>,
    /// Canonical path of each recording, by its path as given.
    canonical: BTreeMap<PathBuf, PathBuf>,
    /// Recordings left out that have a folder.
    present: BTreeSet<PathBuf>,
    /// Attempt of each recording within a study, by its path as given.
    #[serde(default)]
    identities: BTreeMap<PathBuf, AttemptInStudy>,
}

/// Exclusion with its recordings; in results it has other names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct StoredExclusion {
    study: PathBuf,
    exclusion: Exclusion,
    recordings: Vec<PathBuf>,
}

impl From<&Excluded> for StoredExclusion {
    fn from(excluded: &Excluded) -> Self {
        Self {
            study: excluded.study.clone(),
            exclusion: excluded.exclusion.clone(),
            recordings: excluded.recordings.clone(),
        }
    }
}

impl From<StoredExclusion> for Excluded {
    fn from(stored: StoredExclusion) -> Self {
        Self {
            study: stored.study,
            exclusion: stored.exclusion,
            recordings: stored.recordings,
        }
    }
}

impl Call {
    /// Makes the call of a request that found these recordings.
    ///
    /// # Errors
    /// The exclusions of a study cannot be read.
    pub(crate) fn new(
        request: &Request,
        found: &Found,
        assumptions: &Assumptions,
    ) -> Result<Self, ExclusionsError> {
        let (attempts, selection) = (&found.attempts, &found.selection);
        let omitted = attempts.omissions.iter().map(|attempt| &attempt.path);
        let selected = attempts.selection.iter().map(|attempt| &attempt.path);
        let canonical = selected.chain(omitted.clone());
        Ok(Self {
            version: crate::VERSION.to_owned(),
            folders: request
                .folders
                .iter()
                .map(|path| canonical_path(path))
                .collect(),
            name: found.name.clone(),
            assumptions: assumptions.clone(),
            attempts: attempts.clone(),
            recordings: selection.recordings.clone(),
            exclusions: selection.excluded.iter().map(Into::into).collect(),
            overridden: selection.overridden.iter().map(Into::into).collect(),
            excluded: study_analysis::excluded_recordings(attempts, selection)?,
            canonical: canonical
                .map(|path| (path.clone(), canonical_path(path)))
                .collect(),
            present: omitted.filter(|path| path.exists()).cloned().collect(),
            identities: identities(&selection.recordings),
        })
    }

    /// Returns the place of the call in a folder of parts.
    pub(crate) fn path(&self, layout: &Layout) -> PathBuf {
        layout.call(&self.folders)
    }

    /// Returns whether the call asks for the recordings in a folder with this canonical path.
    pub(crate) fn asks_for(&self, folder: &Path) -> bool {
        self.folders.iter().any(|asked| folder.starts_with(asked))
    }

    /// Returns whether the call asks for all that another one asks for.
    pub(crate) fn contains(&self, other: &Self) -> bool {
        other.folders.iter().all(|folder| self.asks_for(folder))
    }

    /// Returns whether the call asks for recordings alone, each of which is analysed.
    pub(crate) fn names_recordings(&self) -> bool {
        let recordings: BTreeSet<&PathBuf> = self.recordings().collect();
        self.folders
            .iter()
            .all(|folder| recordings.contains(folder))
    }

    /// Returns the canonical paths of the recordings that are analysed.
    pub(crate) fn recordings(&self) -> impl Iterator<Item = &PathBuf> {
        let recordings = self.recordings.iter();
        recordings.filter_map(|path| self.canonical.get(path))
    }

    /// Returns the canonical paths of the recordings that were left out on purpose.
    pub(crate) fn excluded(&self) -> BTreeSet<PathBuf> {
        let excluded = self.excluded.iter();
        excluded
            .filter_map(|path| self.canonical.get(path).cloned())
            .collect()
    }

    /// Leaves out the recordings whose canonical paths are lost; returns whether there were any.
    pub(crate) fn leave_out(&mut self, is_lost: impl Fn(&Path) -> bool) -> bool {
        let canonical = &self.canonical;
        let is_lost = |path: &PathBuf| canonical.get(path).is_some_and(|path| is_lost(path));
        let recordings = self.recordings.iter();
        let lost: BTreeSet<PathBuf> = recordings.filter(|path| is_lost(path)).cloned().collect();
        let stays = |path: &PathBuf| !lost.contains(path);
        self.recordings.retain(stays);
        self.attempts
            .selection
            .retain(|attempt| stays(&attempt.path));
        self.canonical.retain(|path, _| stays(path));
        self.identities.retain(|path, _| stays(path));
        !lost.is_empty()
    }

    fn first_folder(&self) -> PathBuf {
        self.folders.first().cloned().unwrap_or_default()
    }
}

/// All calls of a folder of parts as one.
#[derive(Debug)]
pub(crate) struct JoinedCalls {
    pub(crate) settings: Settings,
    pub(crate) found: Found,
    /// Recordings that were left out on purpose.
    pub(crate) excluded: Vec<PathBuf>,
    /// Canonical path of each analysed recording, in their order.
    pub(crate) canonical: Vec<PathBuf>,
    /// Whether an accepted trial with a recording was not analysed.
    pub(crate) is_damaged: bool,
}

impl JoinedCalls {
    /// Reads the calls of a folder of parts. A recording that several calls found counts once, as found by the call of the first
    /// folder by name, which for a study and its sessions is the study.
    pub(crate) fn read(layout: &Layout) -> Result<Self, PartsError> {
        let mut calls = Vec::new();
        for path in paths(&layout.calls())? {
            calls.extend(read_value::<Call>(&path)?);
        }
        calls.sort_by(|a, b| a.folders.cmp(&b.folders));
        let Some(first) = calls.first() else {
            return Err(PartsError::NoParts {
                path: layout.root.clone(),
            });
        };
        let settings = first.assumptions.settings()?;
        let first_folder = first.first_folder();
        let mut joined = Self {
            settings,
            found: Found::default(),
            excluded: Vec::new(),
            canonical: Vec::new(),
            is_damaged: false,
        };
        let (mut names, mut known) = (Vec::new(), BTreeSet::new());
        let mut attempts = BTreeMap::new();
        for call in calls {
            if call.version != crate::VERSION {
                return Err(PartsError::Version {
                    folder: call.first_folder(),
                    version: call.version,
                });
            }
            let other = call.assumptions.settings()?;
            if other != settings {
                return Err(PartsError::Settings {
                    one: first_folder,
                    other: call.first_folder(),
                    names: settings.difference(&other).join(", "),
                });
            }
            names.push(call.name.clone());
            require_one_content(layout, &call, &mut attempts)?;
            joined.add(call, &mut known);
        }
        names.dedup();
        joined.found.name = names.join(", ");
        Ok(joined)
    }

    /// Adds the recordings of a call that are not yet `known`.
    fn add(&mut self, call: Call, known: &mut BTreeSet<PathBuf>) {
        let canonical = |path: &Path| call.canonical.get(path).cloned().unwrap_or_default();
        let new: BTreeSet<&PathBuf> = call
            .canonical
            .iter()
            .filter(|(_, canonical)| !known.contains(*canonical))
            .map(|(path, _)| path)
            .collect();
        let is_new = |path: &PathBuf| new.contains(path);
        let new_paths = |paths: Vec<PathBuf>| paths.into_iter().filter(is_new);
        let exclusions = |list: Vec<StoredExclusion>| {
            let list = list.into_iter().map(|stored| StoredExclusion {
                recordings: new_paths(stored.recordings).collect(),
                ..stored
            });
            let list = list.filter(|stored| !stored.recordings.is_empty());
            list.map(Excluded::from).collect::<Vec<_>>()
        };
        let omissions = call.attempts.omissions.into_iter();
        let omissions: Vec<OmittedAttempt> =
            omissions.filter(|attempt| is_new(&attempt.path)).collect();
        self.is_damaged |= omissions.iter().any(|attempt| {
            attempt.is_missed()
                && call.present.contains(&attempt.path)
                && !call.excluded.contains(&attempt.path)
        });
        let Found {
            attempts,
            selection,
            ..
        } = &mut self.found;
        attempts.omissions.extend(omissions);
        let selected = call.attempts.selection.into_iter();
        attempts
            .selection
            .extend(selected.filter(|attempt| is_new(&attempt.path)));
        for session in call.attempts.empty_sessions {
            if !attempts.empty_sessions.contains(&session) {
                attempts.empty_sessions.push(session);
            }
        }
        for log in call.attempts.unread_logs {
            if !attempts.unread_logs.contains(&log) {
                attempts.unread_logs.push(log);
            }
        }
        let copies = call.attempts.copies.into_iter();
        attempts
            .copies
            .extend(copies.filter(|copy| is_new(&copy.path)));
        for recording in new_paths(call.recordings) {
            self.canonical.push(canonical(&recording));
            selection.recordings.push(recording);
        }
        selection.excluded.extend(exclusions(call.exclusions));
        selection.overridden.extend(exclusions(call.overridden));
        self.excluded.extend(new_paths(call.excluded));
        known.extend(call.canonical.values().cloned());
    }
}

impl JoinedCalls {
    /// Leaves out each recording that is a copy of an earlier one; `originals` has the number of that one for each recording.
    pub(crate) fn leave_out_copies(&mut self, originals: &[Option<usize>]) {
        let recordings = std::mem::take(&mut self.found.selection.recordings);
        let canonical = std::mem::take(&mut self.canonical);
        let attempts = &mut self.found.attempts;
        for ((path, canonical), original) in recordings.iter().zip(canonical).zip(originals) {
            let Some(original) = original else {
                self.found.selection.recordings.push(path.clone());
                self.canonical.push(canonical);
                continue;
            };
            attempts.selection.retain(|attempt| attempt.path != *path);
            attempts.omissions.push(OmittedAttempt {
                path: path.clone(),
                standing: Some(Standing::Unknown),
                because: format!("it is a copy of {}", recordings[*original].display()),
            });
        }
    }
}

/// Returns the attempt of each recording within a study, by its path.
fn identities(recordings: &[PathBuf]) -> BTreeMap<PathBuf, AttemptInStudy> {
    let recordings = recordings.par_iter();
    let attempts = recordings.filter_map(|path| Some((path.clone(), AttemptInStudy::read(path)?)));
    attempts.collect()
}

/// Requires that no recording of a call is an attempt of which an earlier call found other contents, and adds its attempts to those
/// of the earlier ones, each with its recording and the canonical path of that.
fn require_one_content(
    layout: &Layout,
    call: &Call,
    attempts: &mut BTreeMap<AttemptInStudy, (PathBuf, PathBuf)>,
) -> Result<(), PartsError> {
    for (path, attempt) in &call.identities {
        let Some(canonical) = call.canonical.get(path) else {
            continue;
        };
        let Some((original, earlier)) = attempts.get(attempt) else {
            attempts.insert(attempt.clone(), (path.clone(), canonical.clone()));
            continue;
        };
        if earlier != canonical && !has_equal_inputs(layout, [earlier, canonical])? {
            return Err(PartsError::Ambiguous {
                duplicate: Box::new(Duplicate {
                    path: path.clone(),
                    original: original.clone(),
                    identity: attempt.identity.clone(),
                    is_copy: false,
                }),
                folder: call.first_folder(),
                call: call.path(layout),
            });
        }
    }
    Ok(())
}

/// Returns the canonical path of a folder; the path itself if it does not exist.
fn canonical_path(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}
