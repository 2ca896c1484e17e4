//! Recordings of a study.

use std::path::{Path, PathBuf};

use anyhow::bail;
use recording::MANIFEST_FILE;
use study::listing;

/// Returns all recordings in the study, participant or session at `folder`, in order, including interrupted and repeated
/// trials; `None` if `folder` is a recording itself, or not a folder.
///
/// # Errors
/// If a folder cannot be listed, or contains no recording.
pub fn list_recordings(folder: &Path) -> anyhow::Result<Option<Vec<PathBuf>>> {
    if !folder.is_dir() || folder.join(MANIFEST_FILE).exists() {
        return Ok(None);
    }
    let recordings = listing::recordings(folder)?;
    if recordings.is_empty() {
        bail!(
            "{} is neither a recording (it has no {MANIFEST_FILE}) nor a study with recordings{}",
            folder.display(),
            listing::empty_cause(folder)
        );
    }
    Ok(Some(recordings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_study_is_listed_and_a_recording_is_not() {
        let study = tempfile::tempdir().unwrap();
        let study = study.path();
        let trial = |path: &str| {
            let folder = study.join(path);
            fs::create_dir_all(&folder).unwrap();
            fs::write(folder.join(MANIFEST_FILE), "").unwrap();
            folder
        };
        let second = trial("sub-02/ses-01/trial-001_attempt-1");
        let first = trial("sub-01/ses-01/trial-001_attempt-1");
        let listed = list_recordings(study).unwrap().unwrap();
        assert_eq!(listed, [first.clone(), second]);
        let listed = list_recordings(&study.join("sub-01")).unwrap().unwrap();
        assert_eq!(listed, std::slice::from_ref(&first));
        assert_eq!(list_recordings(&first).unwrap(), None);
        assert_eq!(list_recordings(&study.join("absent")).unwrap(), None);
        fs::create_dir(study.join("sub-03")).unwrap();
        let error = list_recordings(&study.join("sub-03")).unwrap_err();
        assert!(error.to_string().contains("sub-03 is neither"), "{error}");
    }
}
