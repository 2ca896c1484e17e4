//! Folder of an archive: a new or empty one, or one that an earlier run began for the same study.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use recording::disk::{self, OnPath, entries};
use recording::study::DESCRIPTION_FILE;
use recording::sums::file_sum;

use crate::archive_error::ArchiveError;

/// Mark of an archive, with the sum of its study's description.
const MARK_FILE: &str = ".friction-bench-archive";
/// Content of the mark without a study.
const NO_STUDY: &str = "no study";

/// Creates the folder of an archive, or continues one.
///
/// # Errors
/// The folder has other files, or is the archive of another study.
pub(crate) fn open(target: &Path, study: Option<&Path>) -> Result<(), ArchiveError> {
    let mark = study.map(|study| study.join(DESCRIPTION_FILE));
    let mark = match mark.filter(|description| description.exists()) {
        Some(description) => file_sum(&description).with_path("read", &description)?.1,
        None => NO_STUDY.to_owned(),
    };
    fs::create_dir_all(target).with_path("create", target)?;
    let path = target.join(MARK_FILE);
    match fs::read_to_string(&path) {
        Ok(text) if text.trim_end() == mark => Ok(()),
        Ok(_) => Err(ArchiveError::OtherStudy {
            target: target.to_owned(),
        }),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            if let Some(file) = entries(target)?
                .into_iter()
                .find(|name| !name.starts_with('.'))
            {
                return Err(ArchiveError::Occupied {
                    target: target.to_owned(),
                    file,
                });
            }
            Ok(disk::replace_file(&path, format!("{mark}\n").as_bytes())?)
        }
        Err(error) => Ok(Err(error).with_path("read", &path)?),
    }
}
