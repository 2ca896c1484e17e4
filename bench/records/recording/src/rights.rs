//! Rights of files, which say who can read them.

use std::path::Path;

/// Name of the file that tests whether the disk keeps rights; it exists for a moment.
pub(crate) const PROBE_FILE: &str = ".friction-bench.rights";

/// Returns whether a new file in `folder` can be closed to other users. `true` if that cannot be determined, and on systems
/// other than Unix, where a file has the rights of its folder.
#[must_use]
pub fn are_kept(folder: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::fs::{self, OpenOptions};
        use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
        let path = folder.join(PROBE_FILE);
        let mut options = OpenOptions::new();
        options.write(true).create_new(true).mode(0o600);
        let metadata = options.open(&path).and_then(|file| file.metadata());
        // Also one that a killed program left.
        let _ = fs::remove_file(&path);
        metadata.map_or(true, |metadata| metadata.mode() & 0o077 == 0)
    }
    #[cfg(not(unix))]
    {
        let _ = folder;
        true
    }
}

/// Returns who can read the study in `folder` besides its owner, as a sentence; `None` if the rights of its files close it.
/// `file` is a file of the study that the program wrote.
#[must_use]
pub fn other_readers(folder: &Path, file: &Path) -> Option<String> {
    #[cfg(unix)]
    {
        use std::fs;
        use std::os::unix::fs::MetadataExt;
        let mode = |path: &Path| fs::metadata(path).map(|metadata| metadata.mode() & 0o777);
        let file_mode = mode(file).ok()?;
        // The program makes no file executable: a disk without rights shows them all alike.
        if file_mode & 0o104 == 0o104 {
            return Some(
                "its disk keeps no rights of files, as FAT, exFAT and NTFS in Linux: everybody who has the disk can read the study"
                    .to_owned(),
            );
        }
        let folder = folder.canonicalize().ok()?;
        let folder_mode = mode(&folder).ok()?;
        let is_open = folder_mode & 0o005 == 0o005 && file_mode & 0o004 != 0;
        let mut parents = folder.ancestors().skip(1);
        let is_reached = parents.all(|parent| mode(parent).is_ok_and(|mode| mode & 0o001 != 0));
        (is_open && is_reached).then(|| {
            format!(
                "every user of this computer can read the study (rights {folder_mode:o} of its folder); `chmod -R go= {}` closes it",
                folder.display()
            )
        })
    }
    #[cfg(not(unix))]
    {
        let _ = (folder, file);
        None
    }
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, Permissions};
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_disk_with_rights_closes_a_new_file() {
        let folder = tempfile::tempdir().unwrap();
        assert!(are_kept(folder.path()));
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
        assert!(are_kept(&folder.path().join("absent")));
    }

    #[test]
    fn readers_follow_from_the_rights_of_files_and_folders() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        fs::write(&file, "{}").unwrap();
        let readers = |folder_mode, file_mode| {
            fs::set_permissions(&file, Permissions::from_mode(file_mode)).unwrap();
            fs::set_permissions(folder.path(), Permissions::from_mode(folder_mode)).unwrap();
            other_readers(folder.path(), &file)
        };
        assert_eq!(readers(0o700, 0o600), None);
        assert_eq!(readers(0o700, 0o644), None);
        assert_eq!(readers(0o770, 0o660), None);
        let words = readers(0o755, 0o777).unwrap();
        assert!(words.contains("keeps no rights"), "{words}");
        let words = readers(0o755, 0o644);
        assert!(
            words.is_none_or(|words| words.contains("rights 755 of its folder")),
            "the parents of the folder decide"
        );
    }
}
