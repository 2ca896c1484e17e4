//! Report of the exclusions, as text and as a table.

use std::path::{Path, PathBuf};

use recording::DiskError;
use recording::disk;

use crate::exclusions::selection::{Excluded, RecordingSelection};
use crate::exclusions::table::to_tsv;

/// File of the exclusions, in the folder of tables and figures; without exclusions it has only a header.
const FILE_NAME: &str = "excluded.tsv";

impl RecordingSelection {
    /// Returns a line for each exclusion, with the number of recordings.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        lines(&self.excluded)
    }

    /// Returns the lines under a heading; an empty text if nothing was excluded.
    #[must_use]
    pub fn to_text(&self) -> String {
        if !self.overridden.is_empty() {
            let n_excluded: usize = self
                .overridden
                .iter()
                .map(|exclusion| exclusion.recordings.len())
                .sum();
            let mut text = format!(
                "exclusions overridden: {n_excluded} of {} recordings are analysed all the same\n",
                self.recordings.len()
            );
            for line in lines(&self.overridden) {
                text += &format!("  {line}\n");
            }
            return text;
        }
        if self.excluded.is_empty() {
            return String::new();
        }
        let (n_excluded, n_kept) = (self.left_out(), self.recordings.len());
        let mut text = format!(
            "excluded: {n_excluded} of {} recordings\n",
            n_excluded + n_kept
        );
        for line in self.lines() {
            text += &format!("  {line}\n");
        }
        text
    }

    /// Writes the exclusions into a folder of results.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_table(&self, folder: &Path) -> Result<PathBuf, DiskError> {
        let list = self.excluded.iter().map(|excluded| &excluded.exclusion);
        let path = folder.join(FILE_NAME);
        disk::replace_file(&path, to_tsv(list).as_bytes())?;
        Ok(path)
    }
}

fn lines(exclusions: &[Excluded]) -> Vec<String> {
    let first = exclusions.first().map(|excluded| &excluded.study);
    let has_several = exclusions
        .iter()
        .any(|excluded| Some(&excluded.study) != first);
    let line = |excluded: &Excluded| {
        let n = match excluded.recordings.len() {
            1 => "1 recording".to_owned(),
            n => format!("{n} recordings"),
        };
        // The same `sub-01` in two studies is two people.
        let study = excluded.study.file_name().filter(|_| has_several);
        let study = study.map(|name| format!("{}/", name.to_string_lossy()));
        format!("{}{}, {n}", study.unwrap_or_default(), excluded.exclusion)
    };
    exclusions.iter().map(line).collect()
}
