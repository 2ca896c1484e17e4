//! Selection of the recordings to analyse.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use recording::reader;
use recording::study::{DESCRIPTION_FILE, EXCLUSIONS_FILE, TrialLabel};
use serde::{Serialize, Serializer};

use crate::exclusions::exclusion::Exclusion;
use crate::exclusions::exclusions_error::ExclusionsError;
use crate::exclusions::table::{self, Exclusions};

/// Levels of folders between a study and a recording.
const DEPTH: usize = 3;

/// Recordings split into analysed and excluded ones.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordingSelection {
    /// Folders to analyse, in the given order.
    pub recordings: Vec<PathBuf>,
    /// Exclusions that apply.
    pub excluded: Vec<Excluded>,
    /// Exclusions that were overridden: their recordings are analysed.
    pub overridden: Vec<Excluded>,
    /// Files of the studies that are named as if they held exclusions, which nothing reads.
    pub unread: Vec<PathBuf>,
}

/// Exclusion with the recordings that it covers, as in `excluded` of the results.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Excluded {
    /// Study that the exclusion belongs to.
    #[serde(skip)]
    pub study: PathBuf,
    /// The exclusion.
    #[serde(flatten)]
    pub exclusion: Exclusion,
    /// Folders of the recordings, at least one.
    #[serde(serialize_with = "serialize_paths")]
    pub recordings: Vec<PathBuf>,
}

fn serialize_paths<S: Serializer>(paths: &[PathBuf], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(paths.iter().map(|path| path.display().to_string()))
}

impl RecordingSelection {
    /// Returns the number of excluded recordings.
    #[must_use]
    pub fn left_out(&self) -> usize {
        self.excluded
            .iter()
            .map(|excluded| excluded.recordings.len())
            .sum()
    }

    /// Overrides the exclusions; `recordings` are the recordings in their order.
    #[must_use]
    pub fn overridden(self, recordings: Vec<PathBuf>) -> Self {
        Self {
            recordings,
            excluded: Vec::new(),
            overridden: self.excluded,
            unread: self.unread,
        }
    }
}

/// Splits `folders` by the exclusions of their studies. A recording that several lines exclude counts under the first.
///
/// # Errors
/// The table of a study cannot be read, or names a participant, session or trial that the study does not have.
pub fn select(folders: Vec<PathBuf>) -> Result<RecordingSelection, ExclusionsError> {
    let mut studies: BTreeMap<PathBuf, Exclusions> = BTreeMap::new();
    let mut selection = RecordingSelection::default();
    for folder in folders {
        let Some(study) = study_of(&folder) else {
            selection.recordings.push(folder);
            continue;
        };
        if !studies.contains_key(&study) {
            let exclusions = table::read(&study)?;
            exclusions.require_known()?;
            selection.unread.extend(table::unread(&study));
            studies.insert(study.clone(), exclusions);
        }
        let exclusions = &studies[&study];
        let covering_exclusion = if exclusions.list.is_empty() {
            None
        } else {
            covering_exclusion(exclusions, &folder)
        };
        match covering_exclusion {
            None => selection.recordings.push(folder),
            Some(exclusion) => {
                // The same `sub-01` in two studies is two people.
                let is_same = |excluded: &&mut Excluded| {
                    excluded.study == study && excluded.exclusion == *exclusion
                };
                match selection.excluded.iter_mut().find(is_same) {
                    Some(excluded) => excluded.recordings.push(folder),
                    None => selection.excluded.push(Excluded {
                        study,
                        exclusion: exclusion.clone(),
                        recordings: vec![folder],
                    }),
                }
            }
        }
    }
    Ok(selection)
}

/// Returns the study that contains a recording, session, participant or study folder, recognised by its description
/// or its exclusions; `None` if it is in no study.
#[must_use]
pub fn study_of(folder: &Path) -> Option<PathBuf> {
    let folder = canonical_path(folder)?;
    let is_study = |folder: &&Path| {
        [DESCRIPTION_FILE, EXCLUSIONS_FILE]
            .iter()
            .any(|file| folder.join(file).exists())
    };
    let mut ancestors = folder.ancestors().take(DEPTH + 1);
    ancestors.find(is_study).map(Path::to_owned)
}

/// Returns the canonical path of a folder, even if a recording's folder does not exist.
fn canonical_path(folder: &Path) -> Option<PathBuf> {
    let missing_path = || {
        let parent = folder.parent()?.canonicalize().ok()?;
        Some(parent.join(folder.file_name()?))
    };
    folder.canonicalize().ok().or_else(missing_path)
}

/// Returns the first exclusion of the recording in `folder`, which is identified by the names of its folders, or
/// else by its description.
fn covering_exclusion<'a>(exclusions: &'a Exclusions, folder: &Path) -> Option<&'a Exclusion> {
    let folder = canonical_path(folder)?;
    let names: Vec<String> = folder
        .ancestors()
        .filter_map(|folder| Some(folder.file_name()?.to_string_lossy().into_owned()))
        .take(DEPTH)
        .collect();
    let names_identity = || {
        let [trial, session, participant] = names.as_slice() else {
            return None;
        };
        let label: TrialLabel = trial.parse().ok()?;
        let session = session.strip_prefix("ses-")?.parse().ok()?;
        Some((participant.clone(), Some(session), Some(label.into())))
    };
    let description_identity = || {
        let manifest = reader::read_manifest(&folder).ok()?;
        let participant = manifest.participant?;
        let trial = manifest.trial.map(|trial| trial.label().into());
        Some((participant.id, Some(participant.session), trial))
    };
    let (participant, session, trial) = names_identity().or_else(description_identity)?;
    let covers = |exclusion: &&Exclusion| exclusion.covers(&participant, session, trial);
    exclusions.list.iter().find(covers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn study(table: &str) -> (tempfile::TempDir, Vec<PathBuf>) {
        let study = tempfile::tempdir().unwrap();
        fs::write(study.path().join(DESCRIPTION_FILE), "{}").unwrap();
        let header = "participant_id\tsession\ttrial\treason\tby\n";
        fs::write(
            study.path().join(EXCLUSIONS_FILE),
            format!("{header}{table}"),
        )
        .unwrap();
        let mut folders = Vec::new();
        for participant in ["sub-07", "sub-071"] {
            for session in ["ses-01", "ses-02"] {
                for trial in ["practice-01_attempt-1", "trial-001_attempt-2"] {
                    let folder = study.path().join(participant).join(session).join(trial);
                    fs::create_dir_all(&folder).unwrap();
                    folders.push(folder);
                }
            }
        }
        (study, folders)
    }

    fn left_out(table: &str) -> Vec<usize> {
        let (_study, folders) = study(table);
        let selection = select(folders.clone()).unwrap();
        let is_excluded = |folder: &PathBuf| !selection.recordings.contains(folder);
        let left_out: Vec<_> = (0..folders.len())
            .filter(|i| is_excluded(&folders[*i]))
            .collect();
        assert_eq!(selection.left_out(), left_out.len());
        left_out
    }

    #[test]
    fn a_line_excludes_its_recordings_only() {
        assert!(left_out("").is_empty());
        assert_eq!(left_out("sub-07\tall\tall\tx\ty\n"), [0, 1, 2, 3]);
        assert_eq!(left_out("sub-07\t2\tall\tx\ty\n"), [2, 3]);
        assert_eq!(left_out("sub-07\tall\t1\tx\ty\n"), [1, 3]);
        assert_eq!(left_out("sub-071\t2\tpractice-1\tx\ty\n"), [6]);
    }

    #[test]
    fn recordings_outside_a_study_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let deep_folder = folder.path().join("a/b/c/d/e");
        fs::create_dir_all(&deep_folder).unwrap();
        assert_eq!(
            select(vec![deep_folder.clone()]).unwrap().recordings,
            [deep_folder]
        );
    }

    #[test]
    fn a_recording_of_another_laboratory_is_identified_by_its_description() {
        let (study, _) = study("sub-07\tall\t5\tx\ty\n");
        fs::create_dir_all(study.path().join("sub-07/ses-01/trial-005_attempt-1")).unwrap();
        let folder = study.path().join("monday-third");
        fs::create_dir(&folder).unwrap();
        let text = recording::manifest::MINIMAL.to_owned()
            + r#"participant = { id = "sub-07", session = 1 }
trial = { number = 5, attempt = 1, practice = false, condition = "am", protocol = "p", seed = 1 }"#;
        fs::write(folder.join(recording::MANIFEST_FILE), text).unwrap();
        let selection = select(vec![folder.clone()]).unwrap();
        assert_eq!(selection.excluded[0].recordings, [folder]);
    }
}
