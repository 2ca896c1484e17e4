//! Content of the tables: each made from the analysis, and all of them written.

use std::path::{Path, PathBuf};

use analysis::{Analysis, SeriesError, SeriesSource, averaged_models};
use attempts::Attempts;
use descriptive::{Description, quantity};
use recording::disk::OnPath;
use study::exclusions::RecordingSelection;

use crate::column::Table;
use crate::csv_file::CsvFile;
#[cfg(feature = "parquet")]
use crate::parquet_file::ParquetFile;
use crate::table_error::TableError;
use crate::table_kind::TableKind;
use crate::trial_entry::TrialEntry;
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
        let entries = self.entries();
        TableKind::ALL
            .into_iter()
            .try_for_each(|kind| self.parts(kind, &entries, &mut take))
    }

    /// Returns a table.
    ///
    /// # Errors
    /// The series cannot be read.
    pub fn table(&self, kind: TableKind) -> Result<Table, SeriesError> {
        let mut table = Table {
            name: kind.name(),
            row: kind.row(),
            columns: Vec::new(),
        };
        self.parts(kind, &self.entries(), &mut |part: &Table| {
            if table.columns.is_empty() {
                table.columns.clone_from(&part.columns);
                return Ok(());
            }
            for (column, part) in table.columns.iter_mut().zip(&part.columns) {
                column.values.append(&part.values);
            }
            Ok::<(), SeriesError>(())
        })?;
        Ok(table)
    }

    fn entries(&self) -> Vec<TrialEntry<'_>> {
        trial_entry::entries(self.analysed, self.attempts, self.selection)
    }

    /// Calls `take` with the parts of a table.
    fn parts<E: From<SeriesError>>(
        &self,
        kind: TableKind,
        entries: &[TrialEntry<'_>],
        take: &mut impl FnMut(&Table) -> Result<(), E>,
    ) -> Result<(), E> {
        let method = quantity::gap_method(self.analysed);
        let mut take_columns = |columns| {
            take(&Table {
                name: kind.name(),
                row: kind.row(),
                columns,
            })
        };
        match kind {
            TableKind::Instances => {
                let instances = rows::by_method(entries, method);
                let columns = instance_table::columns(&instances, INSTANCE_METHOD, method);
                take_columns(columns)
            }
            TableKind::Trials => take_columns(group_table::trials(entries, self.description)),
            TableKind::Participants => {
                take_columns(group_table::participants(entries, self.description))
            }
            TableKind::Descriptive => take_columns(group_table::levels(entries, self.description)),
            TableKind::Estimates => {
                let estimates = rows::by_all_methods(entries);
                take_columns(instance_table::columns(&estimates, ROW_METHOD, method))
            }
            TableKind::Samples => {
                take_columns(sample_table::columns(&[], ROW_METHOD))?;
                for entry in entries {
                    let findings = entry.findings;
                    if findings.instances.is_empty() {
                        continue;
                    }
                    let series = self.series.read(entry.number)?;
                    let models = averaged_models(findings, &series, &self.analysed.settings);
                    let estimates = rows::by_all_methods(std::slice::from_ref(entry));
                    let samples = rows::samples(&estimates, &series, &models);
                    take_columns(sample_table::columns(&samples, ROW_METHOD))?;
                }
                Ok(())
            }
            TableKind::Explorations => take_columns(stroke_table::stroke_columns(
                &stroke_table::strokes(entries),
            )),
            TableKind::Friction => {
                take_columns(stroke_table::friction_columns(&[]))?;
                for entry in entries {
                    let findings = entry.findings;
                    if !findings.instances.is_empty() || findings.explorations.is_empty() {
                        continue;
                    }
                    let series = self.series.read(entry.number)?;
                    let strokes = stroke_table::strokes(std::slice::from_ref(entry));
                    let friction = stroke_table::friction(&strokes, &series);
                    take_columns(stroke_table::friction_columns(&friction))?;
                }
                Ok(())
            }
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

/// Meaning of the column `method` where a table has an instance once.
const INSTANCE_METHOD: &str = "method of the row's estimates, the same in all rows: trial if its fit can be used for any recording, \
     otherwise dynamic";
/// Meaning of the column `method` where a table has an instance once for each method.
const ROW_METHOD: &str = "method of the row's estimates: paper, dynamic or trial";
