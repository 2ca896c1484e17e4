//! Placeholders for files with content that is stored elsewhere.

use std::path::Path;

use crate::content_store::ContentStore;
use crate::refusal::{Refusal, refusal};
use crate::regular::open;

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
}

#[cfg(test)]
mod tests {
    use std::{fs, io};

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
