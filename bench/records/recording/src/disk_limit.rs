//! Guarantees that a disk does not give: found by this process, and told to the user once.
//!
//! They are properties of the file system below any of the program's files, so that one list serves the whole process.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Guarantee that a disk does not give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DiskLimit {
    /// Names of new files cannot be made durable, as on CIFS and some FUSE mounts.
    FolderSync,
    /// Files cannot be locked, as on NFS without its lock service.
    Locks,
    /// Files have no rights of their own, as on FAT, exFAT and NTFS in Linux.
    Rights,
}

impl DiskLimit {
    /// Returns the limit and its cost in words.
    fn notice(self, folder: &Path) -> String {
        let folder = folder.display();
        match self {
            Self::FolderSync => format!(
                "the disk of {folder} does not confirm the names of new files, as some network shares: after a power cut, files of \
                 the last minute may be missing; record on a disk of this computer, and copy the study afterwards"
            ),
            Self::Locks => format!(
                "the disk of {folder} has no file locks, as some network shares: a file with the extension .owner marks the study \
                 as in use, and if this computer crashes, that file must be removed by hand"
            ),
            Self::Rights => format!(
                "the disk of {folder} keeps no rights of files, as FAT, exFAT and NTFS in Linux: everybody who has the disk, and every \
                 user of this computer who reaches it, can read the study; record on a disk of this computer, or encrypt that one"
            ),
        }
    }
}

/// Limits found so far, with a folder on the disk; `None` once the notice was taken.
static FOUND: Mutex<BTreeMap<DiskLimit, Option<PathBuf>>> = Mutex::new(BTreeMap::new());

/// Notes that the disk of `folder` has a limit.
pub(crate) fn note(limit: DiskLimit, folder: &Path) {
    let mut found = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    found
        .entry(limit)
        .or_insert_with(|| Some(folder.to_owned()));
}

/// Returns the notices that were not returned before, a sentence each.
#[must_use]
pub fn take_notices() -> Vec<String> {
    let mut found = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    let limits = found.iter_mut();
    limits
        .filter_map(|(limit, folder)| Some(limit.notice(&folder.take()?)))
        .collect()
}

/// Returns whether a disk refused to sync a folder because it cannot, not because it failed: EINVAL, ENOTSUP, ENOSYS, EBADF of
/// network shares and FUSE, and EACCES of a folder that its user may write and not read. EIO is a failure.
pub(crate) fn cannot_sync_folder(error: &io::Error) -> bool {
    is_unsupported(error) || error.kind() == io::ErrorKind::PermissionDenied
}

/// Returns whether a disk refused a lock because it has none.
pub(crate) fn cannot_lock(error: &io::Error) -> bool {
    #[cfg(unix)]
    if error.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error()) {
        return true;
    }
    is_unsupported(error)
}

fn is_unsupported(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidInput, Unsupported};
    #[cfg(unix)]
    if error.raw_os_error() == Some(rustix::io::Errno::BADF.raw_os_error()) {
        return true;
    }
    matches!(error.kind(), Unsupported | InvalidInput)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use rustix::io::Errno;

    #[test]
    fn what_a_disk_cannot_do_is_told_from_its_failures() {
        let error = |errno: Errno| io::Error::from(errno);
        for errno in [
            Errno::INVAL,
            Errno::NOTSUP,
            Errno::OPNOTSUPP,
            Errno::NOSYS,
            Errno::BADF,
        ] {
            assert!(cannot_sync_folder(&error(errno)), "{errno}");
            assert!(cannot_lock(&error(errno)), "{errno}");
        }
        assert!(cannot_sync_folder(&error(Errno::ACCESS)));
        assert!(cannot_lock(&error(Errno::NOLCK)));
        for errno in [Errno::IO, Errno::NOSPC, Errno::ROFS, Errno::STALE] {
            assert!(!cannot_sync_folder(&error(errno)), "{errno}");
            assert!(!cannot_lock(&error(errno)), "{errno}");
        }
        assert!(!cannot_lock(&error(Errno::ACCESS)));
    }

    #[test]
    fn a_limit_is_told_once() {
        note(DiskLimit::Rights, Path::new("stick"));
        note(DiskLimit::Rights, Path::new("stick/study"));
        let notices = take_notices();
        let of_stick = |notice: &&String| notice.starts_with("the disk of stick keeps no rights");
        assert_eq!(notices.iter().filter(of_stick).count(), 1, "{notices:?}");
        note(DiskLimit::Rights, Path::new("stick"));
        assert!(!take_notices().iter().any(|notice| of_stick(&notice)));
    }
}
