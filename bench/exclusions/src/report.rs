//! Report of the exclusions, as text and with the results.

use std::path::Path;

use recording::DiskError;
use recording::disk;
use serde_json::{Value, json};

use crate::selection::{Excluded, Selection};
use crate::table::to_tsv;

/// File of the exclusions, in the folder of tables and figures; without exclusions it has only a header.
const FILE: &str = "excluded.tsv";

impl Selection {
    /// Returns a line for each exclusion, with the number of recordings.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        lines(&self.excluded)
    }

    /// Returns the lines under a heading; an empty text if nothing was excluded.
    #[must_use]
    pub fn to_text(&self) -> String {
        if !self.overridden.is_empty() {
            let out: usize = self.overridden.iter().map(|of| of.recordings.len()).sum();
            let mut text = format!(
                "exclusions overridden: {out} of {} recordings are analysed all the same\n",
                self.kept.len()
            );
            for line in lines(&self.overridden) {
                text += &format!("  {line}\n");
            }
            return text;
        }
        if self.excluded.is_empty() {
            return String::new();
        }
        let (out, kept) = (self.left_out(), self.kept.len());
        let mut text = format!("excluded: {out} of {} recordings\n", out + kept);
        for line in self.lines() {
            text += &format!("  {line}\n");
        }
        text
    }

    /// Returns the exclusions as `excluded` of the results.
    ///
    /// # Errors
    /// Never fails for exclusions.
    pub fn to_json(&self) -> serde_json::Result<Value> {
        json_of(&self.excluded)
    }

    /// Returns the overridden exclusions as `exclusions_overridden` of the results; `None` without overridden exclusions.
    ///
    /// # Errors
    /// Never fails for exclusions.
    pub fn overridden_to_json(&self) -> serde_json::Result<Option<Value>> {
        let some = !self.overridden.is_empty();
        some.then(|| json_of(&self.overridden)).transpose()
    }
    /// Writes the exclusions into a folder of results.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_beside(&self, folder: &Path) -> Result<(), DiskError> {
        let list = self.excluded.iter().map(|out| &out.exclusion);
        disk::replace_file(&folder.join(FILE), to_tsv(list).as_bytes())
    }
}

fn lines(of: &[Excluded]) -> Vec<String> {
    let first = of.first().map(|out| &out.study);
    let several = of.iter().any(|out| Some(&out.study) != first);
    let line = |out: &Excluded| {
        let n = match out.recordings.len() {
            1 => "1 recording".to_owned(),
            n => format!("{n} recordings"),
        };
        // The same `sub-01` in two studies is two people.
        let study = out.study.file_name().filter(|_| several);
        let study = study.map(|name| format!("{}/", name.to_string_lossy()));
        format!("{}{}, {n}", study.unwrap_or_default(), out.exclusion)
    };
    of.iter().map(line).collect()
}

fn json_of(excluded: &[Excluded]) -> serde_json::Result<Value> {
    let one = |out: &Excluded| {
        let paths = out.recordings.iter();
        let recordings: Vec<_> = paths.map(|path| path.display().to_string()).collect();
        let mut value = serde_json::to_value(&out.exclusion)?;
        value["recordings"] = json!(recordings);
        Ok(value)
    };
    let list: serde_json::Result<Vec<_>> = excluded.iter().map(one).collect();
    Ok(Value::Array(list?))
}
