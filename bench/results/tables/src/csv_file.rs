//! A table as CSV: UTF-8, commas, a header, decimal points; unknown values are empty.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use recording::DiskError;
use recording::disk::OnPath;

use crate::column::Table;
use crate::temporary_file::TemporaryFile;

/// File of a table that is being written.
pub(crate) struct CsvFile {
    writer: csv::Writer<BufWriter<File>>,
    file: TemporaryFile,
}

impl CsvFile {
    /// Creates the file of a table in `folder`, with the header alone.
    ///
    /// # Errors
    /// The operating system refused.
    pub(crate) fn create(table: &Table, folder: &Path) -> Result<Self, DiskError> {
        let (file, handle) = TemporaryFile::create(folder.join(format!("{}.csv", table.name)))?;
        let mut csv = Self {
            writer: csv::Writer::from_writer(BufWriter::new(handle)),
            file,
        };
        csv.write(table.columns.iter().map(|column| &*column.name))?;
        Ok(csv)
    }

    /// Writes rows.
    ///
    /// # Errors
    /// The operating system refused.
    pub(crate) fn append(&mut self, table: &Table) -> Result<(), DiskError> {
        for row in 0..table.len() {
            self.write(table.columns.iter().map(|column| column.values.cell(row)))?;
        }
        Ok(())
    }

    fn write(
        &mut self,
        cells: impl IntoIterator<Item = impl AsRef<[u8]>>,
    ) -> Result<(), DiskError> {
        let csv_error = |error: csv::Error| match error.into_kind() {
            csv::ErrorKind::Io(error) => error,
            kind => std::io::Error::other(format!("{kind:?}")),
        };
        let result = self.writer.write_record(cells).map_err(csv_error);
        result.with_path("write", self.file.temporary())
    }

    /// Replaces an existing file, and returns the path.
    ///
    /// # Errors
    /// The operating system refused.
    pub(crate) fn close(self) -> Result<PathBuf, DiskError> {
        let path = self.file.temporary();
        let mut buffer = self
            .writer
            .into_inner()
            .map_err(|error| std::io::Error::other(error.to_string()))
            .with_path("write", path)?;
        buffer.flush().with_path("write", path)?;
        self.file.replace(buffer.get_ref())
    }
}
