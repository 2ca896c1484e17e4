//! Identity of recordings: the same attempt at the same trial, found in several folders, as copies of synchronisation programs
//! and backups leave it.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use recording::manifest::Manifest;
use recording::reader::read_manifest;
use recording::study::{TrialLabel, session_name};
use recording::sums;
use serde::{Deserialize, Serialize};

use crate::exclusions::study_of;

/// Length of a block in which files are compared, bytes.
const BLOCK: usize = 1 << 16;

/// Identity of a recording by its description: participant, session, trial and attempt.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct RecordingIdentity {
    participant: String,
    session: u32,
    label: TrialLabel,
}

impl RecordingIdentity {
    /// Returns the identity in a description; `None` if it names no participant or no trial.
    #[must_use]
    pub fn from_manifest(manifest: &Manifest) -> Option<Self> {
        let participant = manifest.participant.as_ref()?;
        Some(Self {
            participant: participant.id.clone(),
            session: participant.session,
            label: manifest.trial.as_ref()?.label(),
        })
    }

    /// Returns the number of folders, from the recording's upwards, that have the names of this identity.
    fn named_folders(&self, folder: &Path) -> usize {
        let names = [
            self.label.to_string(),
            session_name(self.session),
            self.participant.clone(),
        ];
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        let ancestors = folder.ancestors().map(|folder| folder.file_name());
        let matches = names.iter().zip(ancestors);
        matches
            .take_while(|(name, folder)| folder.is_some_and(|folder| folder == name.as_str()))
            .count()
    }
}

impl fmt::Display for RecordingIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            participant,
            session,
            label,
        } = self;
        write!(f, "{label} of {participant}, session {session}")
    }
}

/// A recording in a further folder.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Duplicate {
    /// Further folder.
    pub path: PathBuf,
    /// Folder with the names of its identity, or the first by name.
    pub original: PathBuf,
    /// Identity of both.
    pub identity: RecordingIdentity,
    /// Whether all files of both are equal.
    pub is_copy: bool,
}

impl fmt::Display for Duplicate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let relation = if self.is_copy {
            "a copy of"
        } else {
            "the same recording, with other contents, as"
        };
        let (path, original) = (self.path.display(), self.original.display());
        write!(f, "{path} is {relation} {original} ({})", self.identity)
    }
}

/// Returns the recordings among `folders` that another of them also contains: the same attempt in one study, or a copy from
/// anywhere. A recording with no readable description, or without a trial in it, is not compared.
#[must_use]
pub fn duplicates<'a>(folders: impl IntoIterator<Item = &'a Path>) -> Vec<Duplicate> {
    let mut groups: BTreeMap<RecordingIdentity, Vec<&Path>> = BTreeMap::new();
    for folder in folders {
        let manifest = read_manifest(folder).ok();
        let identity = manifest.as_ref().and_then(RecordingIdentity::from_manifest);
        if let Some(identity) = identity {
            groups.entry(identity).or_default().push(folder);
        }
    }
    let mut duplicates = Vec::new();
    for (identity, mut group) in groups {
        group.sort_by_key(|folder| (3 - identity.named_folders(folder), *folder));
        let mut originals: Vec<&Path> = Vec::new();
        for folder in group {
            let duplicate = |original: &Path, is_copy| Duplicate {
                path: folder.to_owned(),
                original: original.to_owned(),
                identity: identity.clone(),
                is_copy,
            };
            let is_copy = |original: &&&Path| have_equal_files(original, folder).unwrap_or(false);
            if let Some(original) = originals.iter().find(is_copy) {
                duplicates.push(duplicate(original, true));
                continue;
            }
            let study = study_of(folder);
            let same_study = |original: &&&Path| study.is_some() && study_of(original) == study;
            if let Some(original) = originals.iter().find(same_study) {
                duplicates.push(duplicate(original, false));
            }
            originals.push(folder);
        }
    }
    duplicates
}

/// Returns whether the files of two recordings are equal.
fn have_equal_files(one: &Path, other: &Path) -> io::Result<bool> {
    for file in sums::FILES.into_iter().chain(recording::OTHER_FILES) {
        let (one, other) = (one.join(file), other.join(file));
        let present = one.is_file();
        if present != other.is_file() || present && !are_equal(&one, &other)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Returns whether two files have equal contents.
pub(crate) fn are_equal(one: &Path, other: &Path) -> io::Result<bool> {
    let (one, other) = (File::open(one)?, File::open(other)?);
    let length = one.metadata()?.len();
    if length != other.metadata()?.len() {
        return Ok(false);
    }
    let (mut one, mut other) = (BufReader::new(one), BufReader::new(other));
    let (mut a, mut b) = (vec![0; BLOCK], vec![0; BLOCK]);
    let mut left = length;
    while left > 0 {
        let count = left.min(BLOCK as u64) as usize;
        one.read_exact(&mut a[..count])?;
        other.read_exact(&mut b[..count])?;
        if a[..count] != b[..count] {
            return Ok(false);
        }
        left -= count as u64;
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use recording::manifest::MINIMAL;
    use recording::study::DESCRIPTION_FILE;
    use recording::{FORCE_FILE, MANIFEST_FILE, SIGNALS_FILE};

    use super::*;

    /// Makes a recording of the first attempt at a trial of sub-03's second session.
    fn recording(folder: &Path, trial: u32, signals: &str) -> PathBuf {
        fs::create_dir_all(folder).unwrap();
        let text = format!(
            "{MINIMAL}participant = {{ id = \"sub-03\", session = 2 }}\ntrial = {{ number = {trial}, attempt = 1, \
             practice = false, condition = \"c\", protocol = \"p\", seed = 1, end = \"completed\" }}\n"
        );
        fs::write(folder.join(MANIFEST_FILE), text).unwrap();
        fs::write(folder.join(SIGNALS_FILE), signals).unwrap();
        folder.to_owned()
    }

    fn study(folder: &Path) -> PathBuf {
        fs::create_dir_all(folder).unwrap();
        fs::write(folder.join(DESCRIPTION_FILE), "{}").unwrap();
        folder.to_owned()
    }

    fn names(folders: &[PathBuf]) -> Vec<(String, String, bool)> {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let list = duplicates(folders.iter().map(PathBuf::as_path));
        list.iter()
            .map(|duplicate| {
                (
                    name(&duplicate.path),
                    name(&duplicate.original),
                    duplicate.is_copy,
                )
            })
            .collect()
    }

    #[test]
    fn the_folder_with_the_names_of_its_identity_is_the_original() {
        let temp = tempfile::tempdir().unwrap();
        let study = study(&temp.path().join("study"));
        let session = study.join("sub-03/ses-02");
        let folders = [
            recording(&study.join("old/a"), 1, "x"),
            recording(&session.join("trial-001_attempt-1"), 1, "x"),
            recording(
                &session.join("trial-001_attempt-1 (conflicted copy)"),
                1,
                "x",
            ),
            recording(&session.join("trial-002_attempt-1"), 2, "x"),
        ];
        let original = "trial-001_attempt-1".to_owned();
        let copy = "trial-001_attempt-1 (conflicted copy)".to_owned();
        assert_eq!(
            names(&folders),
            [
                ("a".to_owned(), original.clone(), true),
                (copy, original, true)
            ]
        );
    }

    #[test]
    fn other_contents_under_one_identity_are_a_duplicate_within_a_study_only() {
        let temp = tempfile::tempdir().unwrap();
        let [one, two] = ["one", "two"].map(|name| study(&temp.path().join(name)));
        let label = "sub-03/ses-02/trial-001_attempt-1";
        let first = recording(&one.join(label), 1, "first");
        let edited = recording(&one.join("sub-03/ses-02/backup"), 1, "other");
        let foreign = recording(&two.join(label), 1, "third");
        let pairs = names(&[first.clone(), edited.clone(), foreign.clone()]);
        let original = "trial-001_attempt-1".to_owned();
        assert_eq!(pairs, [("backup".to_owned(), original.clone(), false)]);
        // A file that one of them lacks is a difference too.
        fs::write(edited.join(SIGNALS_FILE), "first").unwrap();
        fs::write(edited.join(FORCE_FILE), "").unwrap();
        assert_eq!(names(&[first.clone(), edited.clone()]).len(), 1);
        assert!(!names(&[first.clone(), edited])[0].2);
        // A copy in another study is a copy all the same.
        fs::write(foreign.join(SIGNALS_FILE), "first").unwrap();
        assert_eq!(
            names(&[first, foreign]),
            [(original.clone(), original, true)]
        );
    }
}
