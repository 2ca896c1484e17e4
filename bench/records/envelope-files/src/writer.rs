//! Writes `envelopes.parquet`.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, GzipLevel, Repetition, Type as PhysicalType};
use parquet::data_type::{DoubleType, FloatType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::{COLUMNS, EnvelopeError, EnvelopeRow};

/// Rows of a group, which are held in memory: 5 MB.
const GROUP_ROWS: usize = 1 << 17;

/// Precision of the envelopes in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Precision {
    /// Doubles, compressed by Snappy.
    Double,
    /// Floats, their bytes apart and compressed by gzip.
    Single,
}

/// Writer of `envelopes.parquet`; without [`finish`](Self::finish) the file cannot be read.
pub struct EnvelopeWriter {
    path: PathBuf,
    precision: Precision,
    writer: SerializedFileWriter<File>,
    pending: Vec<EnvelopeRow>,
}

/// Returns the error of a file that could not be written: the operating system's, as of a full disk, if it refused.
fn unwritten(path: &Path, reason: ParquetError) -> EnvelopeError {
    let path = path.to_owned();
    match reason {
        ParquetError::External(cause) => match cause.downcast::<std::io::Error>() {
            Ok(reason) => EnvelopeError::Io {
                path,
                reason: *reason,
            },
            Err(cause) => EnvelopeError::Parquet {
                path,
                reason: ParquetError::External(cause),
            },
        },
        reason => EnvelopeError::Parquet { path, reason },
    }
}

impl EnvelopeWriter {
    /// Creates the file, or replaces it.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create(path: &Path) -> Result<Self, EnvelopeError> {
        Self::with_precision(path, Precision::Double)
    }

    /// Creates a small file, or replaces it: the envelopes are single-precision floats, and values that are rounded take few bytes.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create_small(path: &Path) -> Result<Self, EnvelopeError> {
        Self::with_precision(path, Precision::Single)
    }

    fn with_precision(path: &Path, precision: Precision) -> Result<Self, EnvelopeError> {
        let file = File::create(path).map_err(|reason| EnvelopeError::Io {
            path: path.to_owned(),
            reason,
        })?;
        let writer = writer(file, precision).map_err(|reason| unwritten(path, reason))?;
        Ok(Self {
            path: path.to_owned(),
            precision,
            writer,
            pending: Vec::new(),
        })
    }

    /// Writes rows in time order.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn write(&mut self, rows: &[EnvelopeRow]) -> Result<(), EnvelopeError> {
        self.pending.extend_from_slice(rows);
        while self.pending.len() >= GROUP_ROWS {
            let rest = self.pending.split_off(GROUP_ROWS);
            let group = std::mem::replace(&mut self.pending, rest);
            self.write_group(&group)?;
        }
        Ok(())
    }

    /// Completes the file.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn finish(mut self) -> Result<(), EnvelopeError> {
        let rows = std::mem::take(&mut self.pending);
        self.write_group(&rows)?;
        let file = self.writer.into_inner();
        let file = file.map_err(|reason| unwritten(&self.path, reason))?;
        file.sync_all().map_err(|reason| EnvelopeError::Io {
            path: self.path,
            reason,
        })
    }

    fn write_group(&mut self, rows: &[EnvelopeRow]) -> Result<(), EnvelopeError> {
        let path = &self.path;
        let error = |reason| unwritten(path, reason);
        let mut group = self.writer.next_row_group().map_err(error)?;
        let values: [fn(&EnvelopeRow) -> f64; 5] = [
            |row| row.time_s,
            |row| row.drive_v.re,
            |row| row.drive_v.im,
            |row| row.pickup_m.re,
            |row| row.pickup_m.im,
        ];
        for (value, type_) in values.into_iter().zip(self.precision.types()) {
            let Some(mut writer) = group.next_column().map_err(error)? else {
                continue;
            };
            let column = rows.iter().map(value);
            let result = match type_ {
                PhysicalType::FLOAT => {
                    let column: Vec<f32> = column.map(|value| value as f32).collect();
                    let typed = writer.typed::<FloatType>();
                    typed.write_batch(&column, None, None)
                }
                _ => {
                    let column: Vec<f64> = column.collect();
                    let typed = writer.typed::<DoubleType>();
                    typed.write_batch(&column, None, None)
                }
            };
            result.map_err(error)?;
            writer.close().map_err(error)?;
        }
        group.close().map_err(error)?;
        Ok(())
    }
}

impl Precision {
    /// Returns the types of the columns; times are doubles.
    fn types(self) -> [PhysicalType; 5] {
        let value = match self {
            Self::Double => PhysicalType::DOUBLE,
            Self::Single => PhysicalType::FLOAT,
        };
        [PhysicalType::DOUBLE, value, value, value, value]
    }

    fn properties(self) -> WriterProperties {
        let properties = WriterProperties::builder().set_dictionary_enabled(false);
        let properties = match self {
            Self::Double => properties.set_compression(Compression::SNAPPY),
            Self::Single => properties
                .set_compression(Compression::GZIP(GzipLevel::default()))
                .set_encoding(Encoding::BYTE_STREAM_SPLIT),
        };
        properties.build()
    }
}

fn writer(file: File, precision: Precision) -> Result<SerializedFileWriter<File>, ParquetError> {
    let field = |(name, type_)| {
        Type::primitive_type_builder(name, type_)
            .with_repetition(Repetition::REQUIRED)
            .build()
            .map(Arc::new)
    };
    let fields = COLUMNS.into_iter().zip(precision.types());
    let fields = fields.map(field).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("schema")
        .with_fields(fields)
        .build()?;
    SerializedFileWriter::new(file, Arc::new(schema), Arc::new(precision.properties()))
}
