//! Opening of files for writing in place.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

use crate::refusal::Refusal;
use crate::regular::{never_wait, require_regular};

/// Opens a regular file for reading and writing, or creates it. Symbolic links are not followed: another user who can
/// write to the folder could point one at a file of this user.
///
/// # Errors
/// [`Refusal`] inside the error for a link and for a file that is not regular; otherwise the operating system's reason.
pub fn open_in_place(path: &Path) -> io::Result<File> {
    match fs::symlink_metadata(path) {
        Ok(metadata) if metadata.is_symlink() => return Err(Refusal::Link.into()),
        Ok(metadata) => require_regular(&metadata)?,
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    never_wait(&mut options, true);
    // First without the flag that creates it: in a folder for temporary files, the system refuses that flag for another
    // user's file.
    let file = match options.open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => options.create(true).open(path)?,
        opened => opened?,
    };
    require_regular(&file.metadata()?)?;
    Ok(file)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::refusal::{FileKind, refusal};
    use std::os::unix::fs::symlink;

    #[test]
    fn a_link_is_not_followed_and_its_end_not_made() {
        let folder = tempfile::tempdir().unwrap();
        let path_of = |name: &str| folder.path().join(name);
        symlink(path_of("end"), path_of("link")).unwrap();
        let error = open_in_place(&path_of("link")).unwrap_err();
        assert_eq!(refusal(&error), Some(&Refusal::Link));
        assert!(!path_of("end").exists());
        open_in_place(&path_of("end")).unwrap();
        assert!(path_of("end").is_file());
        let error = open_in_place(&path_of("link")).unwrap_err();
        assert_eq!(refusal(&error), Some(&Refusal::Link));
        let error = open_in_place(folder.path()).unwrap_err();
        let kind = Refusal::NotRegular(FileKind::Folder);
        assert_eq!(refusal(&error), Some(&kind));
    }
}
