//! Content of the tables: each made from the analysis, and all of them written.

use std::path::{Path, PathBuf};

use analysis::Analysis;
use analysis::attempts::Attempts;
use descriptive::{Description, quantity};
use recording::disk::OnPath;
use study::exclusions::RecordingSelection;

use crate::column::Table;
#[cfg(feature = "parquet")]
use crate::parquet_file;
use crate::table_error::TableError;
use crate::{
    csv_file, dictionary, group_table, instance_table, rows, sample_table, stroke_table,
    trial_entry,
};

/// Content of the tables.
#[derive(Debug, Clone, Copy)]
pub struct Content<'a> {
    /// The analysis.
    pub analysed: &'a Analysis,
    /// Its description.
    pub description: &'a Description,
    /// Attempts found, with their standing.
    pub attempts: &'a Attempts,
    /// Exclusions, and those that were overridden.
    pub selection: &'a RecordingSelection,
}

impl Content<'_> {
    /// Calls `take` with each table; one table is in memory at a time.
    ///
    /// # Errors
    /// The first error of `take`.
    pub fn tables<E>(&self, mut take: impl FnMut(&Table) -> Result<(), E>) -> Result<(), E> {
        let entries = trial_entry::entries(self.analysed, self.attempts, self.selection);
        let method = quantity::gap_method(self.analysed);
        let described = self.description;
        let instances = rows::by_method(&entries, method);
        take(&Table {
            name: "instances",
            row: "instance; identified by participant, session, trial, attempt, instance",
            columns: instance_table::columns(&instances, INSTANCE_METHOD, method),
        })?;
        take(&Table {
            name: "trials",
            row: "trial; identified by participant, session, trial, attempt",
            columns: group_table::trials(&entries, described),
        })?;
        take(&Table {
            name: "participants",
            row: "participant and condition; identified by participant, condition",
            columns: group_table::participants(&entries, described),
        })?;
        take(&Table {
            name: "descriptive",
            row: "group of the description; identified by level, participant, condition, session, trial, attempt",
            columns: group_table::levels(&entries, described),
        })?;
        let estimates = rows::by_all_methods(&entries);
        take(&Table {
            name: "estimates",
            row: "instance and method; identified by participant, session, trial, attempt, instance, method",
            columns: instance_table::columns(&estimates, ROW_METHOD, method),
        })?;
        take(&Table {
            name: "samples",
            row: "sample of an instance and method; identified by participant, session, trial, attempt, instance, method, time_s",
            columns: sample_table::columns(&rows::samples(&estimates), ROW_METHOD),
        })?;
        let strokes = stroke_table::strokes(&entries);
        take(&Table {
            name: "explorations",
            row: "exploration; identified by participant, session, trial, attempt, exploration",
            columns: stroke_table::stroke_columns(&strokes),
        })?;
        take(&Table {
            name: "friction",
            row: "sample of an exploration of a recording without instances; identified by participant, session, trial, attempt, exploration, time_s",
            columns: stroke_table::friction_columns(&stroke_table::friction(&strokes)),
        })
    }

    /// Writes the tables as CSV and Parquet and their dictionary into `folder`, which is created if it does not exist; existing
    /// tables are replaced. Returns the paths.
    ///
    /// # Errors
    /// [`TableError`], which names the file.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, TableError> {
        std::fs::create_dir_all(folder).with_path("create", folder)?;
        #[cfg(feature = "parquet")]
        let metadata = crate::metadata::Metadata::new(self.analysed);
        let mut paths = Vec::new();
        let mut entries = Vec::new();
        self.tables(|table| {
            paths.push(csv_file::write(table, folder)?);
            #[cfg(feature = "parquet")]
            paths.push(parquet_file::write(table, &metadata, folder)?);
            entries.extend(dictionary::entries(table));
            Ok::<(), TableError>(())
        })?;
        entries.extend(dictionary::skin_entries());
        paths.push(dictionary::write(&entries, folder)?);
        Ok(paths)
    }
}

/// Meaning of the column `method` where a table has an instance once.
const INSTANCE_METHOD: &str = "method of the row's estimates, the same in all rows: trial if its fit can be used for any recording, \
     otherwise dynamic";
/// Meaning of the column `method` where a table has an instance once for each method.
const ROW_METHOD: &str = "method of the row's estimates: paper, dynamic or trial";
