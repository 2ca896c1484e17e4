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
use crate::table_kind::TableKind;
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
        TableKind::ALL
            .into_iter()
            .try_for_each(|kind| take(&self.table(kind)))
    }

    /// Returns a table.
    #[must_use]
    pub fn table(&self, kind: TableKind) -> Table {
        let entries = trial_entry::entries(self.analysed, self.attempts, self.selection);
        let method = quantity::gap_method(self.analysed);
        let columns = match kind {
            TableKind::Instances => {
                let instances = rows::by_method(&entries, method);
                instance_table::columns(&instances, INSTANCE_METHOD, method)
            }
            TableKind::Trials => group_table::trials(&entries, self.description),
            TableKind::Participants => group_table::participants(&entries, self.description),
            TableKind::Descriptive => group_table::levels(&entries, self.description),
            TableKind::Estimates => {
                instance_table::columns(&rows::by_all_methods(&entries), ROW_METHOD, method)
            }
            TableKind::Samples => {
                let estimates = rows::by_all_methods(&entries);
                sample_table::columns(&rows::samples(&estimates), ROW_METHOD)
            }
            TableKind::Explorations => {
                stroke_table::stroke_columns(&stroke_table::strokes(&entries))
            }
            TableKind::Friction => {
                let strokes = stroke_table::strokes(&entries);
                stroke_table::friction_columns(&stroke_table::friction(&strokes))
            }
        };
        Table {
            name: kind.name(),
            row: kind.row(),
            columns,
        }
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
