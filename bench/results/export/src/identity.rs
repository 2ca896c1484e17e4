//! Identity of a recording, which names its exported files.

use std::path::{Path, PathBuf};

use protocols::{ParticipantId, TrialLabel};
use recording::Manifest;

/// Identity of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct RecordingIdentity {
    /// Folder of the recording.
    pub(crate) folder: PathBuf,
    /// Place in its study; `None` if neither its description nor its folders' names state it.
    pub(crate) place: Option<StudyPlace>,
}

/// Place of a recording in its study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct StudyPlace {
    /// Participant.
    pub(crate) participant: ParticipantId,
    /// Number of the participant's session.
    pub(crate) session: u32,
    /// Trial and attempt.
    pub(crate) label: TrialLabel,
}

impl RecordingIdentity {
    /// Reads the identity of the recording in `folder` from its description, or from the names of its folders if that cannot be
    /// read.
    pub(crate) fn read(folder: &Path) -> Self {
        let place = match recording::reader::read_manifest(folder) {
            Ok(manifest) => stated_place(&manifest),
            Err(_) => None,
        };
        Self {
            place: place.or_else(|| named_place(folder)),
            folder: folder.to_owned(),
        }
    }

    /// Returns the name of its files: `sub-01_ses-01_trial-001_attempt-1`, or that of its folder if it is in no study.
    pub(crate) fn name(&self) -> String {
        match &self.place {
            Some(place) => format!(
                "{}_{}_{}",
                place.participant.as_str(),
                recording::study::session_name(place.session),
                place.label
            ),
            None => {
                let folder = self.folder.canonicalize();
                let folder = folder.as_deref().unwrap_or(&self.folder);
                let name = folder.file_name().unwrap_or_default();
                name.to_string_lossy().into_owned()
            }
        }
    }
}

fn stated_place(manifest: &Manifest) -> Option<StudyPlace> {
    let (person, trial) = (manifest.participant.as_ref()?, manifest.trial.as_ref()?);
    Some(StudyPlace {
        participant: person.id.parse().ok()?,
        session: person.session,
        label: trial.label(),
    })
}

fn named_place(folder: &Path) -> Option<StudyPlace> {
    let folder = folder.canonicalize().ok()?;
    let mut names = folder.iter().rev().map(|name| name.to_str());
    let label = names.next()??.parse().ok()?;
    let session = names.next()??.strip_prefix("ses-")?.parse().ok()?;
    Some(StudyPlace {
        participant: names.next()??.parse().ok()?,
        session,
        label,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::manifest::MINIMAL;
    use std::fs;

    fn recording(folder: &Path, tables: &str) -> RecordingIdentity {
        fs::create_dir_all(folder).unwrap();
        fs::write(folder.join("recording.toml"), format!("{MINIMAL}{tables}")).unwrap();
        RecordingIdentity::read(folder)
    }

    #[test]
    fn the_description_decides_then_the_folders() {
        let study = tempfile::tempdir().unwrap();
        let tables = "participant = { id = \"sub-07\", session = 2 }\n\
            trial = { number = 3, attempt = 2, practice = true, condition = \"c\", protocol = \"p\", seed = 1 }\n";
        let folder = study.path().join("sub-01/ses-01/trial-001_attempt-1");
        let name = recording(&folder, tables).name();
        assert_eq!(name, "sub-07_ses-02_practice-03_attempt-2");
        assert_eq!(
            recording(&folder, "").name(),
            "sub-01_ses-01_trial-001_attempt-1"
        );
        assert_eq!(recording(&study.path().join("alone"), "").name(), "alone");
    }
}
