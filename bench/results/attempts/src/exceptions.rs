//! Folders of which the recordings are left out of an analysis.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::{Attempts, canonical_path};

/// Folder to be left out in which no recording was found.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot leave out {}: no recording to analyse is in it; {}",
    path.display(),
    match nearest {
        Some(folder) => format!("did you mean {}?", escaping::quoted(folder)),
        None => "name a folder as `friction-bench list` prints it, or one above".to_owned(),
    }
)]
pub struct UnusedException {
    /// Folder given.
    pub path: PathBuf,
    /// Folder with recordings that was probably meant.
    pub nearest: Option<PathBuf>,
}

/// Folder of which the recordings are left out.
struct Exception {
    path: PathBuf,
    canonical: PathBuf,
    is_used: bool,
}

/// Folders of which the recordings are left out, and the folders that could have been meant.
pub(crate) struct Exceptions {
    list: Vec<Exception>,
    folders: BTreeSet<PathBuf>,
}

impl Exceptions {
    pub(crate) fn new(paths: &[PathBuf]) -> Self {
        let list = paths.iter().map(|path| Exception {
            path: path.clone(),
            canonical: canonical_path(path),
            is_used: false,
        });
        Self {
            list: list.collect(),
            folders: BTreeSet::new(),
        }
    }

    /// Removes the attempts and sessions in these folders from those found in `folder`.
    pub(crate) fn remove_from(&mut self, folder: &Path, attempts: &mut Attempts) {
        if self.list.is_empty() {
            return;
        }
        let mut stays = |path: &Path| {
            self.folders.extend(folders_between(folder, path));
            let path = canonical_path(path);
            let mut is_kept = true;
            for exception in &mut self.list {
                let is_inside = path.starts_with(&exception.canonical);
                exception.is_used |= is_inside;
                is_kept &= !is_inside;
            }
            is_kept
        };
        attempts.selection.retain(|attempt| stays(&attempt.path));
        attempts.omissions.retain(|attempt| stays(&attempt.path));
        attempts
            .empty_sessions
            .retain(|session| stays(&session.path));
        attempts.unread_logs.retain(|(log, _)| stays(log));
    }

    /// Requires that each of the folders had attempts.
    ///
    /// # Errors
    /// One had none; the error names the folder that was probably meant.
    pub(crate) fn require_all_used(self) -> Result<(), UnusedException> {
        let mut unused = self.list.iter().filter(|exception| !exception.is_used);
        match unused.next() {
            None => Ok(()),
            Some(exception) => Err(UnusedException {
                path: exception.path.clone(),
                nearest: self.nearest(&exception.path),
            }),
        }
    }

    /// Returns the only folder with the names of `path` at its end, or else the one with the most similar name.
    fn nearest(&self, path: &Path) -> Option<PathBuf> {
        let mut endings = self.folders.iter().filter(|folder| folder.ends_with(path));
        if let (Some(folder), None) = (endings.next(), endings.next()) {
            return Some(folder.clone());
        }
        let names = self.folders.iter().filter_map(|folder| folder.file_name());
        let names: Vec<&str> = names.filter_map(OsStr::to_str).collect();
        let name = strict_toml::nearest(path.file_name()?.to_str()?, &names)?;
        let sibling = path.with_file_name(&name);
        if self.folders.contains(&sibling) {
            return Some(sibling);
        }
        let mut folders = self.folders.iter().filter(|folder| folder.ends_with(&name));
        folders.next().filter(|_| folders.next().is_none()).cloned()
    }
}

/// Returns the folders from `path` up to the one below `folder`.
fn folders_between<'a>(folder: &'a Path, path: &'a Path) -> impl Iterator<Item = PathBuf> + 'a {
    let folders = path.ancestors().take_while(move |path| *path != folder);
    folders.filter(|path| path.is_dir()).map(Path::to_owned)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::find::{TrialFilter, attempts_except};
    use recording::MANIFEST_FILE;
    use recording::manifest::MINIMAL;

    /// Makes a study `st` of two people with a recording each.
    fn study() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path().join("st");
        for participant in ["sub-01", "sub-02"] {
            let recording = study.join(participant).join("ses-01/made_elsewhere");
            fs::create_dir_all(&recording).unwrap();
            let text = MINIMAL.replace("force_factor_n_per_v = 0.1", "force_factor_n_per_v = 0.2");
            let text = if participant == "sub-01" {
                MINIMAL
            } else {
                &text
            };
            fs::write(recording.join(MANIFEST_FILE), text).unwrap();
        }
        (folder, study)
    }

    #[test]
    fn a_folder_to_leave_out_without_a_recording_is_refused_with_the_one_meant() {
        let (_folder, study) = study();
        let refusal = |exception: &Path| {
            let folders = std::slice::from_ref(&study);
            let found = attempts_except(folders, TrialFilter::default(), &[exception.to_owned()]);
            found.map_or_else(
                |error| error.to_string(),
                |found| found.recordings().len().to_string(),
            )
        };
        assert_eq!(refusal(&study.join("sub-02")), "1");
        assert_eq!(refusal(&study.join("sub-02/ses-01/made_elsewhere")), "1");
        let meant = |name: &str| format!("did you mean {}?", study.join(name).display());
        let refused = refusal(Path::new("sub-02"));
        assert!(
            refused.starts_with("cannot leave out sub-02: "),
            "{refused}"
        );
        assert!(refused.ends_with(&meant("sub-02")), "{refused}");
        assert!(refusal(&study.join("sbu-02")).ends_with(&meant("sub-02")));
        // Both have it.
        assert!(refusal(Path::new("xyz")).ends_with("or one above"));
        let all = refusal(&study);
        assert!(all.starts_with("nothing is left of "), "{all}");
    }
}
