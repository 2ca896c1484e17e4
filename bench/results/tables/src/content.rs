//! Content of the tables: each made from the analysis, and all of them written.

use std::path::{Path, PathBuf};

use analysis::attempts::Attempts;
use analysis::{Analysis, SeriesError, SeriesSource, averaged_models};
use descriptive::{Description, quantity};
use recording::disk::OnPath;
use study::exclusions::RecordingSelection;

use crate::column::Table;
use crate::csv_file::CsvFile;
#[cfg(feature = "parquet")]
use crate::parquet_file::ParquetFile;
use crate::rows::SampleRow;
use crate::stroke_table::FrictionRow;
use crate::table_error::TableError;
use crate::{
    dictionary, group_table, instance_table, rows, sample_table, stroke_table, trial_entry,
};

/// Content of the tables.
#[derive(Clone, Copy)]
pub struct Content<'a> {
    /// The analysis.
    pub analysed: &'a Analysis,
    /// Its series.
    pub series: &'a dyn SeriesSource,
    /// Its description.
    pub description: &'a Description,
    /// Attempts found, with their standing.
    pub attempts: &'a Attempts,
    /// Exclusions, and those that were overridden.
    pub selection: &'a RecordingSelection,
}

impl Content<'_> {
    /// Calls `take` with each table. A table of samples comes in parts, of the rows of one recording each and first of none, one
    /// after the other.
    ///
    /// # Errors
    /// The first error of `take`, or series that cannot be read.
    pub fn tables<E: From<SeriesError>>(
        &self,
        mut take: impl FnMut(&Table) -> Result<(), E>,
    ) -> Result<(), E> {
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
        drop(estimates);
        take(&samples(&[]))?;
        for entry in &entries {
            let findings = entry.findings;
            if findings.instances.is_empty() {
                continue;
            }
            let series = self.series.read(entry.number)?;
            let models = averaged_models(findings, &series, &self.analysed.settings);
            let estimates = rows::by_all_methods(std::slice::from_ref(entry));
            take(&samples(&rows::samples(&estimates, &series, &models)))?;
        }
        let strokes = stroke_table::strokes(&entries);
        take(&Table {
            name: "explorations",
            row: "exploration; identified by participant, session, trial, attempt, exploration",
            columns: stroke_table::stroke_columns(&strokes),
        })?;
        take(&friction(&[]))?;
        for entry in &entries {
            if !entry.findings.instances.is_empty() || entry.findings.explorations.is_empty() {
                continue;
            }
            let series = self.series.read(entry.number)?;
            let strokes = stroke_table::strokes(std::slice::from_ref(entry));
            take(&friction(&stroke_table::friction(&strokes, &series)))?;
        }
        Ok(())
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
        let mut open: Option<TableFiles> = None;
        self.tables(|table| {
            if let Some(files) = open.as_mut().filter(|files| files.name == table.name) {
                return files.append(table);
            }
            if let Some(files) = open.take() {
                paths.extend(files.close()?);
            }
            entries.extend(dictionary::entries(table));
            let files = TableFiles {
                name: table.name,
                csv: CsvFile::create(table, folder)?,
                #[cfg(feature = "parquet")]
                parquet: ParquetFile::create(table, &metadata, folder)?,
            };
            open.insert(files).append(table)
        })?;
        if let Some(files) = open {
            paths.extend(files.close()?);
        }
        entries.extend(dictionary::skin_entries());
        paths.push(dictionary::write(&entries, folder)?);
        Ok(paths)
    }
}

/// Files of a table that is being written.
struct TableFiles {
    name: &'static str,
    csv: CsvFile,
    #[cfg(feature = "parquet")]
    parquet: ParquetFile,
}

impl TableFiles {
    fn append(&mut self, part: &Table) -> Result<(), TableError> {
        self.csv.append(part)?;
        #[cfg(feature = "parquet")]
        self.parquet.append(part)?;
        Ok(())
    }

    fn close(self) -> Result<Vec<PathBuf>, TableError> {
        Ok(vec![
            self.csv.close()?,
            #[cfg(feature = "parquet")]
            self.parquet.close()?,
        ])
    }
}

fn samples(rows: &[SampleRow<'_>]) -> Table {
    Table {
        name: "samples",
        row: "sample of an instance and method; identified by participant, session, trial, attempt, instance, method, time_s",
        columns: sample_table::columns(rows, ROW_METHOD),
    }
}

fn friction(rows: &[FrictionRow<'_>]) -> Table {
    Table {
        name: "friction",
        row: "sample of an exploration of a recording without instances; identified by participant, session, trial, attempt, exploration, time_s",
        columns: stroke_table::friction_columns(rows),
    }
}

/// Meaning of the column `method` where a table has an instance once.
const INSTANCE_METHOD: &str = "method of the row's estimates, the same in all rows: trial if its fit can be used for any recording, \
     otherwise dynamic";
/// Meaning of the column `method` where a table has an instance once for each method.
const ROW_METHOD: &str = "method of the row's estimates: paper, dynamic or trial";
