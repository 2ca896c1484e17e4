//! Stores of content for which a file on this computer is only a placeholder.

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read, Seek};
use std::path::Path;

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
