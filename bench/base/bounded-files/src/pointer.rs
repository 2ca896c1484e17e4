//! Placeholders for files with content that is stored elsewhere.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read, Seek};
use std::path::Path;

use crate::refusal::{Refusal, refusal};
use crate::regular::open;

/// Largest placeholder, bytes; git-annex reads none beyond it.
const LIMIT_BYTES: u64 = 32 * 1024;
/// Bytes at the start of a placeholder that tell its store.
const START_BYTES: u64 = 512;

/// Store of the content of a file that is only a placeholder on this computer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContentStore {
    /// git-annex, also as DataLad uses it.
    Annex,
    /// Git LFS.
    Lfs,
    /// iCloud, which leaves a hidden file of another name.
    Icloud,
}

impl fmt::Display for ContentStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Annex => {
                "it is a placeholder of git-annex, and its content is elsewhere: fetch it with `git annex get`"
            }
            Self::Lfs => {
                "it is a pointer of Git LFS, and its content is elsewhere: fetch it with `git lfs pull`"
            }
            Self::Icloud => {
                "its content is in iCloud and not on this computer: open its folder in the Finder and download it"
            }
        })
    }
}

impl ContentStore {
    /// Returns the store that the file at `path` points to without its content; `None` for a file with its content, and
    /// for a file that does not exist.
    #[must_use]
    pub fn find(path: &Path) -> Option<Self> {
        let error = open(path).err()?;
        match refusal(&error) {
            Some(Refusal::Elsewhere(store)) => Some(*store),
            _ => None,
        }
    }

    /// Returns the store of a file that cannot be found: a link into the annex that leads nowhere, or a stub next to it.
    pub(crate) fn find_absent(path: &Path) -> Option<Self> {
        if let Ok(target) = fs::read_link(path) {
            let target = target.to_string_lossy().replace('\\', "/");
            return target
                .contains(".git/annex/objects/")
                .then_some(Self::Annex);
        }
        let stub = format!(".{}.icloud", path.file_name()?.to_str()?);
        path.with_file_name(stub).exists().then_some(Self::Icloud)
    }

    /// Returns the store named by the text at the start of an open file, which is then at its start again.
    pub(crate) fn find_in(file: &mut File) -> io::Result<Option<Self>> {
        let metadata = file.metadata()?;
        if !metadata.is_file() || !(1..=LIMIT_BYTES).contains(&metadata.len()) {
            return Ok(None);
        }
        let mut start = Vec::new();
        Read::by_ref(file)
            .take(START_BYTES)
            .read_to_end(&mut start)?;
        file.rewind()?;
        Ok(Self::parse(&start))
    }

    fn parse(start: &[u8]) -> Option<Self> {
        let contains = |word: &[u8]| start.windows(word.len()).any(|window| window == word);
        // A disk without symbolic links has the target of the link as a text.
        let is_link = start.starts_with(b".") && contains(b".git/annex/objects/");
        if start.starts_with(b"/annex/objects/") || is_link {
            Some(Self::Annex)
        } else if start.starts_with(b"version https://git-lfs.github.com/spec/") {
            Some(Self::Lfs)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{TEXT_LIMIT_BYTES, read_text};

    fn store_of(content: &str) -> Option<ContentStore> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("force.csv");
        fs::write(&path, content).unwrap();
        let store = ContentStore::find(&path);
        let read = read_text(&path, TEXT_LIMIT_BYTES);
        match read {
            Ok(text) => assert_eq!((text.as_str(), store), (content, None)),
            Err(error) => assert_eq!(refusal(&error).copied(), store.map(Refusal::Elsewhere)),
        }
        store
    }

    #[test]
    fn a_placeholder_is_told_from_a_text() {
        let key = "annex/objects/MD5E-s12--0123.csv";
        assert_eq!(store_of(&format!("/{key}\n")), Some(ContentStore::Annex));
        let link = format!("../../.git/{key}");
        assert_eq!(store_of(&link), Some(ContentStore::Annex));
        let lfs = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12\n";
        assert_eq!(store_of(lfs), Some(ContentStore::Lfs));
        assert_eq!(store_of("time_s,normal_n\n0.0,0.5\n"), None);
        assert_eq!(store_of(""), None);
        assert_eq!(store_of("# kept in .git/annex/objects/\n"), None);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_without_its_content_and_a_stub_are_told_from_an_absent_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("signals.wav");
        assert_eq!(ContentStore::find(&path), None);
        let error = open(&path).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        fs::write(folder.path().join(".signals.wav.icloud"), "").unwrap();
        assert_eq!(ContentStore::find(&path), Some(ContentStore::Icloud));
        std::os::unix::fs::symlink("../.git/annex/objects/a/b/c.wav", &path).unwrap();
        let error = open(&path).unwrap_err();
        let elsewhere = Refusal::Elsewhere(ContentStore::Annex);
        assert_eq!(refusal(&error), Some(&elsewhere));
    }
}
