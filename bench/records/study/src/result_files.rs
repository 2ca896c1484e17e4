//! Files of results, which never replace recorded data.

use std::fs;
use std::io::Read;
use std::path::Path;

use recording::MANIFEST_FILE;
use recording::study::{DESCRIPTION_FILE, EVENTS_FILE};

/// Kind of a file of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResultFile {
    /// Results or findings.
    Json,
    /// Report.
    Page,
}

impl ResultFile {
    /// Returns whether a file begins as an earlier result of this kind does.
    #[must_use]
    pub fn is_earlier(self, path: &Path) -> bool {
        let mut begin = Vec::new();
        let read = fs::File::open(path).and_then(|file| file.take(256).read_to_end(&mut begin));
        let text = String::from_utf8_lossy(&begin);
        let is_result = match self {
            Self::Json => text.starts_with('{') && text.contains("\"format\":"),
            Self::Page => text.starts_with("<!DOCTYPE html"),
        };
        read.is_ok() && (is_result || begin.is_empty())
    }
}

/// Returns what `folder` is to a study, if it has files that results must not replace.
#[must_use]
pub fn recorded_folder(folder: &Path) -> Option<&'static str> {
    let kinds = [
        (MANIFEST_FILE, "a recording"),
        (EVENTS_FILE, "a session"),
        (DESCRIPTION_FILE, "a study"),
    ];
    let kind = kinds.iter().find(|(file, _)| folder.join(file).exists());
    let is_participant = |folder: &Path| {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let study = folder.parent().map(|study| study.join(DESCRIPTION_FILE));
        name.starts_with("sub-") && study.is_some_and(|description| description.exists())
    };
    let kind = kind.map(|(_, kind)| *kind);
    kind.or_else(|| {
        folder
            .ancestors()
            .any(is_participant)
            .then_some("in a participant's folder")
    })
}
