//! Participants of the analysed recordings: a pseudonym is unique only within its study.
//!
//! As a rule, `sub-01` in two studies is two people. A study is identified by its own folder; recordings outside any study
//! share one name space within an analysis.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use recording::study::TrialLabel;
use recording::{Manifest, reader};

use crate::findings::RecordingAnalysis;

/// Person in an analysis: the study's own folder, and the pseudonym.
pub type Person = (Option<PathBuf>, String);

/// Names the participant of each recording: by the pseudonym alone if all recordings are from one study, otherwise preceded by
/// the study's name.
pub fn name(recordings: &mut [RecordingAnalysis]) {
    let people = recordings.iter().map(|recording| {
        let findings = recording.findings.as_ref().ok();
        // That of a recording that can be read says all; the folders' names complete that of another one.
        let read_again =
            || Some(reader::read_manifest(&recording.path).ok()?).filter(has_participant);
        match findings {
            Some(findings) => person(&recording.path, Some(&findings.manifest)),
            None => person(&recording.path, read_again().as_ref()),
        }
    });
    let people = people.collect();
    name_as(recordings, people);
}

/// Returns whether a description names its participant.
#[must_use]
pub fn has_participant(manifest: &Manifest) -> bool {
    manifest.participant.is_some()
}

/// Names the participant of each recording, who is the person at its place in `people`.
pub fn name_as(recordings: &mut [RecordingAnalysis], people: Vec<Option<Person>>) {
    let names = names(people.iter().flatten());
    for (recording, person) in recordings.iter_mut().zip(people) {
        let name = person.and_then(|person| names.get(&person).cloned());
        if let Ok(findings) = &mut recording.findings {
            findings.participant.clone_from(&name);
        }
        recording.participant = name;
    }
}

/// Returns the person of a recording, from its description, or from the names of its folders if that cannot be read.
#[must_use]
pub fn person(recording: &Path, manifest: Option<&Manifest>) -> Option<Person> {
    let id = match manifest {
        Some(manifest) => manifest.participant.as_ref()?.id.clone(),
        None => study_and_participant(recording)?.1,
    };
    Some((study(recording), id))
}

/// Returns the folder of a recording's study: the one that contains a study's description, or else by the names of the folders.
#[must_use]
pub fn study(recording: &Path) -> Option<PathBuf> {
    study::exclusions::study_of(recording)
        .or_else(|| study_and_participant(recording).map(|(study, _)| study))
}

/// Returns study and participant of a recording in `STUDY/sub-01/ses-01/trial-001_attempt-1`.
fn study_and_participant(recording: &Path) -> Option<(PathBuf, String)> {
    let folder = recording.canonicalize().ok()?;
    let name = |folder: &Path| Some(folder.file_name()?.to_str()?.to_owned());
    let label: Result<TrialLabel, _> = name(&folder)?.parse();
    let session = folder.parent()?;
    let participant = session.parent()?;
    let is_session = label.is_ok() && name(session)?.starts_with("ses-");
    let id = name(participant)?;
    (is_session && id.starts_with("sub-")).then_some((participant.parent()?.to_owned(), id))
}

fn names<'a>(people: impl Iterator<Item = &'a Person>) -> BTreeMap<Person, String> {
    let people: BTreeSet<&Person> = people.collect();
    let studies: BTreeSet<&Option<PathBuf>> = people.iter().map(|(study, _)| study).collect();
    // The smallest number of last path components that distinguishes the studies.
    let path_tail = |path: &Path, n: usize| {
        let names: Vec<_> = path.iter().map(|name| name.to_string_lossy()).collect();
        names[names.len().saturating_sub(n)..].join("/")
    };
    let is_distinctive = |n: &usize| {
        let tails: BTreeSet<String> = studies
            .iter()
            .copied()
            .flatten()
            .map(|study| path_tail(study, *n))
            .collect();
        tails.len() == studies.iter().copied().flatten().count()
    };
    let n = (1..64).find(is_distinctive).unwrap_or(64);
    let mut used_names = BTreeSet::new();
    let mut names = BTreeMap::new();
    for person in people {
        let (study, id) = person;
        let study = study.as_deref().filter(|_| studies.len() > 1);
        let plain_name = study.map_or_else(
            || id.clone(),
            |study| format!("{}/{id}", path_tail(study, n)),
        );
        // A pseudonym from elsewhere may contain a slash.
        let numbered_names = (2..).map(|number| format!("{plain_name} ({number})"));
        let mut candidates = std::iter::once(plain_name.clone()).chain(numbered_names);
        let name = candidates
            .find(|name| !used_names.contains(name))
            .unwrap_or(plain_name);
        used_names.insert(name.clone());
        names.insert(person.clone(), name);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    fn participant_names(people: &[(Option<&str>, &str)]) -> Vec<String> {
        let people: Vec<Person> = people
            .iter()
            .map(|(study, id)| (study.map(PathBuf::from), (*id).to_owned()))
            .collect();
        let names = names(people.iter());
        people.iter().map(|person| names[person].clone()).collect()
    }

    /// Regression test: `sub-01` of two studies was one person, with an n of 1 and means over two people's trials.
    ///
    /// Fault 52.
    #[test]
    fn one_pseudonym_in_two_studies_is_two_people() {
        assert_eq!(
            participant_names(&[(Some("/d/b"), "sub-01"), (Some("/d/b"), "sub-02")]),
            ["sub-01", "sub-02"]
        );
        assert_eq!(
            participant_names(&[(Some("/d/b"), "sub-01"), (Some("/d/c"), "sub-01")]),
            ["b/sub-01", "c/sub-01"]
        );
        assert_eq!(
            participant_names(&[(Some("/d/b"), "sub-01"), (Some("/e/b"), "sub-01")]),
            ["d/b/sub-01", "e/b/sub-01"]
        );
        assert_eq!(
            participant_names(&[(None, "sub-01"), (Some("/d/b"), "sub-01")]),
            ["sub-01", "b/sub-01"]
        );
        assert_eq!(
            participant_names(&[(None, "b/sub-01"), (Some("/d/b"), "sub-01")]),
            ["b/sub-01", "b/sub-01 (2)"]
        );
    }
}
