//! A new folder for each demonstration.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::error::DemoError;

/// Creates the folder `wanted`, or if that name exists already, the first free one of `wanted-2`, `wanted-3`…
pub fn make(wanted: &Path) -> Result<PathBuf, DemoError> {
    let failed = |folder: &Path, source| DemoError::Folder {
        folder: folder.to_owned(),
        source,
    };
    if let Some(parent) = wanted.parent() {
        fs::create_dir_all(parent).map_err(|error| failed(parent, error))?;
    }
    let mut folder = wanted.to_owned();
    let mut number = 1;
    loop {
        match fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(failed(&folder, error)),
        }
        number += 1;
        let name = wanted.file_name().unwrap_or_default().to_string_lossy();
        folder.set_file_name(format!("{name}-{number}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_in_use_is_numbered() {
        let room = tempfile::tempdir().unwrap();
        let wanted = room.path().join("in/a room/demo");
        let folders: Vec<_> = (0..3).map(|_| make(&wanted).unwrap()).collect();
        let names = ["demo", "demo-2", "demo-3"].map(|name| wanted.with_file_name(name));
        assert_eq!(folders, names);
        assert!(folders.iter().all(|folder| folder.is_dir()));
        // Existing files and folders are never touched.
        let file = room.path().join("file");
        fs::write(&file, "mine").unwrap();
        assert_eq!(make(&file).unwrap(), room.path().join("file-2"));
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let room = tempfile::tempdir().unwrap();
        let file = room.path().join("file");
        fs::write(&file, "").unwrap();
        let refused = make(&file.join("demo")).unwrap_err().to_string();
        assert!(
            refused.contains(&file.display().to_string()) && refused.contains("name another"),
            "{refused}"
        );
    }
}
