//! Reads `envelopes.parquet` in blocks.

use std::fmt;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use num_complex::Complex64;
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::{COLUMNS, EnvelopeError, EnvelopeRow};

/// Reader of `envelopes.parquet`.
pub struct EnvelopeReader {
    path: PathBuf,
    file: SerializedFileReader<File>,
    /// Place of each column in the file.
    places: [usize; 5],
    next_group: usize,
    /// Readers of the columns of the current group.
    columns: Vec<ColumnReader>,
}

impl fmt::Debug for EnvelopeReader {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("EnvelopeReader")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl EnvelopeReader {
    /// Opens the file and finds its columns, which may be in any order and among others.
    ///
    /// # Errors
    /// The file cannot be read, or a column is missing.
    pub fn open(path: &Path) -> Result<Self, EnvelopeError> {
        let source = bounded_files::open(path).map_err(|reason| {
            let path = path.to_owned();
            match reason.kind() {
                ErrorKind::NotFound => EnvelopeError::Absent { path },
                _ => EnvelopeError::Io { path, reason },
            }
        })?;
        let file = SerializedFileReader::new(source).map_err(|reason| EnvelopeError::Parquet {
            path: path.to_owned(),
            reason,
        })?;
        let schema = file.metadata().file_metadata().schema_descr_ptr();
        let mut places = [0; 5];
        for (place, column) in places.iter_mut().zip(COLUMNS) {
            let mut columns = schema.columns().iter();
            *place = columns
                .position(|descriptor| descriptor.path().string() == column)
                .ok_or_else(|| EnvelopeError::NoColumn {
                    path: path.to_owned(),
                    column,
                })?;
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            places,
            next_group: 0,
            columns: Vec::new(),
        })
    }

    /// Returns the number of rows.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.file.metadata().file_metadata().num_rows().max(0) as u64
    }

    /// Appends at most `max_rows` of the next rows; returns their number, 0 at the end. Missing values are NaN.
    ///
    /// # Errors
    /// The file is damaged, or a column has no numbers.
    pub fn read(
        &mut self,
        max_rows: usize,
        rows: &mut Vec<EnvelopeRow>,
    ) -> Result<usize, EnvelopeError> {
        loop {
            if self.columns.is_empty() && !self.open_group()? {
                return Ok(0);
            }
            let mut values: [Vec<f64>; 5] = Default::default();
            for ((reader, values), column) in self.columns.iter_mut().zip(&mut values).zip(COLUMNS)
            {
                let result = match reader {
                    ColumnReader::DoubleColumnReader(reader) => {
                        read_column(reader, max_rows, values)
                    }
                    ColumnReader::FloatColumnReader(reader) => {
                        read_column(reader, max_rows, values)
                    }
                    _ => {
                        return Err(EnvelopeError::NoNumbers {
                            path: self.path.clone(),
                            column,
                        });
                    }
                };
                result.map_err(|reason| EnvelopeError::Parquet {
                    path: self.path.clone(),
                    reason,
                })?;
            }
            let [time_s, drive_re, drive_im, pickup_re, pickup_im] = &values;
            // A damaged group may have columns of different lengths.
            let count = values.iter().map(Vec::len).min().unwrap_or(0);
            if count == 0 {
                self.columns.clear();
                continue;
            }
            rows.extend((0..count).map(|i| EnvelopeRow {
                time_s: time_s[i],
                drive_v: Complex64::new(drive_re[i], drive_im[i]),
                pickup_m: Complex64::new(pickup_re[i], pickup_im[i]),
            }));
            return Ok(count);
        }
    }

    /// Opens the columns of the next group; returns whether there is one.
    fn open_group(&mut self) -> Result<bool, EnvelopeError> {
        if self.next_group >= self.file.num_row_groups() {
            return Ok(false);
        }
        let group = self.file.get_row_group(self.next_group);
        self.next_group += 1;
        let columns = group.and_then(|group| {
            let columns = self
                .places
                .iter()
                .map(|place| group.get_column_reader(*place));
            columns.collect::<Result<Vec<_>, _>>()
        });
        self.columns = columns.map_err(|reason| EnvelopeError::Parquet {
            path: self.path.clone(),
            reason,
        })?;
        Ok(true)
    }
}

/// Appends at most `max_rows` values, NaN where the column has none.
fn read_column<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    max_rows: usize,
    values: &mut Vec<f64>,
) -> Result<(), ParquetError>
where
    T::T: Copy + Into<f64>,
{
    let (mut present, mut levels) = (Vec::new(), Vec::new());
    let (n_rows, n_values, _) =
        reader.read_records(max_rows, Some(&mut levels), None, &mut present)?;
    if levels.is_empty() || n_values == n_rows {
        values.extend(present.into_iter().map(Into::into));
        return Ok(());
    }
    let greatest = levels.iter().copied().max().unwrap_or(0);
    let mut present = present.into_iter();
    for level in levels {
        let value = (level == greatest && greatest > 0)
            .then(|| present.next())
            .flatten();
        values.push(value.map_or(f64::NAN, Into::into));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_no_parquet_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("envelopes.parquet");
        std::fs::write(&path, b"time_s,drive_re_v\n").unwrap();
        let error = EnvelopeReader::open(&path).unwrap_err().to_string();
        assert!(error.contains("cannot be read as Parquet"), "{error}");
        let error = EnvelopeReader::open(&folder.path().join("none")).unwrap_err();
        assert!(matches!(error, EnvelopeError::Absent { .. }), "{error}");
    }
}
