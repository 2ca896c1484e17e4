//! The folder of a user's hardware locks, which no other user can write to.

use std::path::PathBuf;

use recording::DiskError;
#[cfg(unix)]
use recording::disk::OnPath;

/// Returns the folder, created if needed: the user's runtime folder, or else a private folder of the user among the
/// temporary files.
///
/// # Errors
/// The folder among the temporary files belongs to another user, or others may write to it.
#[cfg(unix)]
pub fn lock_folder() -> Result<PathBuf, DiskError> {
    use rustix::process::geteuid;
    let user = geteuid().as_raw();
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let default = PathBuf::from(format!("/run/user/{user}"));
    let mut candidates = runtime.into_iter().chain([default]);
    if let Some(folder) = candidates.find(|folder_path| {
        folder_path.is_absolute() && unix::require_own(folder_path, user).is_ok()
    }) {
        return Ok(folder);
    }
    let folder = std::env::temp_dir().join(format!("friction-bench-{user}"));
    unix::make_own(&folder, user).with_path("use", &folder)?;
    Ok(folder)
}

/// Returns the folder for temporary files, which belongs to the user.
///
/// # Errors
/// No error occurs.
#[cfg(not(unix))]
pub fn lock_folder() -> Result<PathBuf, DiskError> {
    Ok(std::env::temp_dir())
}

#[cfg(unix)]
mod unix {
    use std::fs::{self, DirBuilder};
    use std::io;
    use std::os::unix::fs::{DirBuilderExt, MetadataExt};
    use std::path::Path;

    /// Requires a folder that is not a link, belongs to the user and is writable by no other user.
    pub(super) fn require_own(folder: &Path, user: u32) -> io::Result<()> {
        let metadata = fs::symlink_metadata(folder)?;
        if metadata.is_dir() && metadata.uid() == user && metadata.mode() & 0o022 == 0 {
            return Ok(());
        }
        Err(io::Error::other(
            "it is not a folder of this user's own, or others may write to it; remove it, or let XDG_RUNTIME_DIR name another",
        ))
    }

    pub(super) fn make_own(folder: &Path, user: u32) -> io::Result<()> {
        match DirBuilder::new().mode(0o700).create(folder) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => Err(error),
            _ => require_own(folder, user),
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;
        use rustix::process::geteuid;
        use std::os::unix::fs::{PermissionsExt, symlink};

        #[test]
        fn a_folder_that_others_may_have_planted_is_refused() {
            let room = tempfile::tempdir().unwrap();
            let path_of = |name: &str| room.path().join(name);
            let user = geteuid().as_raw();
            make_own(&path_of("own"), user).unwrap();
            make_own(&path_of("own"), user).unwrap();
            assert_eq!(fs::metadata(path_of("own")).unwrap().mode() & 0o777, 0o700);
            symlink(path_of("own"), path_of("link")).unwrap();
            fs::write(path_of("file"), "").unwrap();
            fs::create_dir(path_of("open")).unwrap();
            fs::set_permissions(path_of("open"), fs::Permissions::from_mode(0o770)).unwrap();
            for name in ["link", "file", "open"] {
                assert!(make_own(&path_of(name), user).is_err(), "{name}");
            }
            assert!(make_own(&path_of("own"), user + 1).is_err());
        }
    }
}
