//! Folder of an export: files that are complete or absent, and left alone if they are there already.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use recording::DiskError;
use recording::disk::OnPath;

use crate::export_error::ExportError;
use crate::fill_error::FillError;

/// Bytes compared or copied at a time.
const BLOCK_BYTES: usize = 1 << 18;
/// Extension of a file that is being written.
const PARTIAL: &str = "partial";

/// State of a file of an export, after the export.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileState {
    /// The file was written.
    Written,
    /// A file with other content was replaced.
    Replaced,
    /// The file was there with the same content, and is as it was.
    Unchanged,
}

/// Folder that contains nothing but one export.
#[derive(Debug)]
pub(crate) struct TargetFolder {
    folder: PathBuf,
}

impl TargetFolder {
    /// Creates the folder if it does not exist. Hidden files in it are ignored.
    ///
    /// # Errors
    /// The folder has a file that is not among `names`, which are relative to it, or cannot be listed.
    pub(crate) fn open(folder: &Path, names: &BTreeSet<PathBuf>) -> Result<Self, ExportError> {
        fs::create_dir_all(folder).with_path("create", folder)?;
        let mut foreign = BTreeSet::new();
        list(folder, Path::new(""), &mut |name| {
            if !names.contains(name) {
                foreign.insert(name.to_owned());
            }
        })?;
        match foreign.first() {
            None => Ok(Self {
                folder: folder.to_owned(),
            }),
            Some(first) => Err(ExportError::Foreign {
                folder: folder.to_owned(),
                first: first.clone(),
                count: foreign.len(),
            }),
        }
    }

    /// Writes the file `name` with the content that `fill` writes; an equal file is left as it is. `recording` is the source of the
    /// content.
    ///
    /// # Errors
    /// The recording cannot be read, or the file cannot be written; an older file remains.
    pub(crate) fn put(
        &self,
        name: &Path,
        recording: &Path,
        fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), FillError>,
    ) -> Result<FileState, ExportError> {
        let path = self.path(name)?;
        let temporary = partial(&path);
        let result = write(&temporary, &path, recording, fill);
        if result.is_err() {
            let _ = fs::remove_file(&temporary);
        }
        result
    }

    /// Writes the file `name` with this text; an equal file is left as it is.
    ///
    /// # Errors
    /// Same as [`put`](Self::put).
    pub(crate) fn put_text(&self, name: &Path, text: &str) -> Result<FileState, ExportError> {
        self.put(name, name, |out| Ok(out.write_all(text.as_bytes())?))
    }

    /// Writes the file `name` with this text, unless there is one: people complete it by hand.
    ///
    /// # Errors
    /// Same as [`put`](Self::put).
    pub(crate) fn put_draft(&self, name: &Path, text: &str) -> Result<FileState, ExportError> {
        match self.folder.join(name).exists() {
            true => Ok(FileState::Unchanged),
            false => self.put_text(name, text),
        }
    }

    /// Copies a file of the recording in the folder `recording`; an equal one is left as it is.
    ///
    /// # Errors
    /// Same as [`put`](Self::put).
    pub(crate) fn copy(
        &self,
        source: &Path,
        name: &Path,
        recording: &Path,
    ) -> Result<FileState, ExportError> {
        let path = self.path(name)?;
        if path.exists() && is_same(source, &path)? {
            return Ok(FileState::Unchanged);
        }
        let file = bounded_files::open(source).with_path("read", source)?;
        self.put(name, recording, |out| {
            let mut file = BufReader::with_capacity(BLOCK_BYTES, file);
            io::copy(&mut file, out)?;
            Ok(())
        })
    }

    /// Returns the path of a file, after the folders in it are made.
    fn path(&self, name: &Path) -> Result<PathBuf, DiskError> {
        let path = self.folder.join(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_path("create", folder)?;
        }
        Ok(path)
    }
}

/// Returns the path of a file that is being written.
fn partial(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{PARTIAL}"))
}

fn write(
    temporary: &Path,
    path: &Path,
    recording: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), FillError>,
) -> Result<FileState, ExportError> {
    let file = File::create(temporary).with_path("create", temporary)?;
    let mut out = BufWriter::with_capacity(BLOCK_BYTES, file);
    fill(&mut out).map_err(|error| match error {
        FillError::Read(error) => ExportError::Read(error),
        FillError::Envelopes(error) => ExportError::Envelopes(error),
        FillError::Changed => ExportError::Changed {
            recording: recording.to_owned(),
        },
        FillError::Write(source) => ExportError::Disk(DiskError {
            action: "write",
            path: path.to_owned(),
            source,
        }),
    })?;
    out.flush().with_path("write", path)?;
    let is_there = path.exists();
    if is_there && is_same(temporary, path)? {
        fs::remove_file(temporary).with_path("remove", temporary)?;
        return Ok(FileState::Unchanged);
    }
    out.get_ref().sync_data().with_path("sync", temporary)?;
    fs::rename(temporary, path).with_path("replace", path)?;
    Ok(match is_there {
        true => FileState::Replaced,
        false => FileState::Written,
    })
}

/// Calls `take` with each file in `folder`, relative to it and preceded by `prefix`.
fn list(folder: &Path, prefix: &Path, take: &mut impl FnMut(&Path)) -> Result<(), DiskError> {
    for entry in fs::read_dir(folder).with_path("list", folder)? {
        let entry = entry.with_path("list", folder)?;
        if entry.file_name().to_string_lossy().starts_with('.') {
            continue;
        }
        let name = prefix.join(entry.file_name());
        match entry.file_type().with_path("list", folder)?.is_dir() {
            true => list(&entry.path(), &name, take)?,
            false => take(&name),
        }
    }
    Ok(())
}

/// Returns whether two files have the same content.
fn is_same(first: &Path, second: &Path) -> Result<bool, DiskError> {
    let open = |path: &Path| bounded_files::open(path).with_path("read", path);
    let (mut one, mut other) = (open(first)?, open(second)?);
    let length = |file: &File| file.metadata().map(|metadata| metadata.len());
    if length(&one).with_path("read", first)? != length(&other).with_path("read", second)? {
        return Ok(false);
    }
    let (mut block, mut other_block) = (vec![0; BLOCK_BYTES], vec![0; BLOCK_BYTES]);
    loop {
        let n = one.read(&mut block).with_path("read", first)?;
        if n == 0 {
            return Ok(true);
        }
        match other.read_exact(&mut other_block[..n]) {
            Ok(()) if block[..n] == other_block[..n] => {}
            Ok(()) => return Ok(false),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(false),
            Err(error) => return Err(error).with_path("read", second),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(names: &[&str]) -> BTreeSet<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    #[test]
    fn a_file_is_written_once_and_replaced_when_it_differs() {
        let folder = tempfile::tempdir().unwrap();
        let target = TargetFolder::open(folder.path(), &names(&["a/b.txt"])).unwrap();
        let name = Path::new("a/b.txt");
        for (text, state) in [
            ("one", FileState::Written),
            ("one", FileState::Unchanged),
            ("two", FileState::Replaced),
        ] {
            assert_eq!(target.put_text(name, text).unwrap(), state);
        }
        assert_eq!(
            target.put_draft(name, "three").unwrap(),
            FileState::Unchanged
        );
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(text, "two");
        // Nothing else remains.
        TargetFolder::open(folder.path(), &names(&["a/b.txt"])).unwrap();
        assert_eq!(fs::read_dir(folder.path().join("a")).unwrap().count(), 1);
    }

    #[test]
    fn a_failure_leaves_the_older_file() {
        let folder = tempfile::tempdir().unwrap();
        let target = TargetFolder::open(folder.path(), &names(&[])).unwrap();
        let name = Path::new("a.txt");
        target.put_text(name, "one").unwrap();
        let error = target.put(name, Path::new("recording"), |out| {
            out.write_all(b"tw")?;
            Err(FillError::Changed)
        });
        assert!(matches!(error, Err(ExportError::Changed { .. })));
        assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), "one");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn foreign_files_are_refused_by_name_and_hidden_ones_ignored() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("a")).unwrap();
        for name in ["a/own.csv", "a/notes.txt", "z.txt", ".hidden"] {
            fs::write(folder.path().join(name), "x").unwrap();
        }
        let error = TargetFolder::open(folder.path(), &names(&["a/own.csv"])).unwrap_err();
        let ExportError::Foreign { first, count, .. } = error else {
            panic!("{error}");
        };
        assert_eq!((first, count), (PathBuf::from("a/notes.txt"), 2));
    }

    #[test]
    fn a_copy_that_is_there_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let source = folder.path().join("source");
        fs::write(&source, vec![7; BLOCK_BYTES + 3]).unwrap();
        let target = TargetFolder::open(&folder.path().join("to"), &names(&[])).unwrap();
        let copy = || {
            target
                .copy(&source, Path::new("copy"), folder.path())
                .unwrap()
        };
        assert_eq!(copy(), FileState::Written);
        assert_eq!(copy(), FileState::Unchanged);
        let mut bytes = vec![7; BLOCK_BYTES + 3];
        bytes[BLOCK_BYTES + 1] = 8;
        fs::write(&source, bytes).unwrap();
        assert_eq!(copy(), FileState::Replaced);
    }
}
