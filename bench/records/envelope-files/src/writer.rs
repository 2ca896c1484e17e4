//! Writes `envelopes.parquet`.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, Repetition, Type as PhysicalType};
use parquet::data_type::DoubleType;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::{COLUMNS, EnvelopeError, EnvelopeRow};

/// Rows of a group, which are held in memory: 5 MB.
const GROUP_ROWS: usize = 1 << 17;

/// Writer of `envelopes.parquet`; without [`finish`](Self::finish) the file cannot be read.
pub struct EnvelopeWriter {
    path: PathBuf,
    writer: SerializedFileWriter<File>,
    pending: Vec<EnvelopeRow>,
}

impl EnvelopeWriter {
    /// Creates the file, or replaces it.
    ///
    /// # Errors
    /// The operating system refused.
    pub fn create(path: &Path) -> Result<Self, EnvelopeError> {
        let file = File::create(path).map_err(|reason| EnvelopeError::Io {
            path: path.to_owned(),
            reason,
        })?;
        let writer = writer(file).map_err(|reason| EnvelopeError::Parquet {
            path: path.to_owned(),
            reason,
        })?;
        Ok(Self {
            path: path.to_owned(),
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
        let file = self
            .writer
            .into_inner()
            .map_err(|reason| EnvelopeError::Parquet {
                path: self.path.clone(),
                reason,
            })?;
        file.sync_all().map_err(|reason| EnvelopeError::Io {
            path: self.path,
            reason,
        })
    }

    fn write_group(&mut self, rows: &[EnvelopeRow]) -> Result<(), EnvelopeError> {
        let path = &self.path;
        let error = |reason| EnvelopeError::Parquet {
            path: path.clone(),
            reason,
        };
        let mut group = self.writer.next_row_group().map_err(error)?;
        let values: [fn(&EnvelopeRow) -> f64; 5] = [
            |row| row.time_s,
            |row| row.drive_v.re,
            |row| row.drive_v.im,
            |row| row.pickup_m.re,
            |row| row.pickup_m.im,
        ];
        for value in values {
            let column: Vec<f64> = rows.iter().map(value).collect();
            if let Some(mut writer) = group.next_column().map_err(error)? {
                let typed = writer.typed::<DoubleType>();
                typed.write_batch(&column, None, None).map_err(error)?;
                writer.close().map_err(error)?;
            }
        }
        group.close().map_err(error)?;
        Ok(())
    }
}

fn writer(file: File) -> Result<SerializedFileWriter<File>, ParquetError> {
    let field = |name: &str| {
        Type::primitive_type_builder(name, PhysicalType::DOUBLE)
            .with_repetition(Repetition::REQUIRED)
            .build()
            .map(Arc::new)
    };
    let fields = COLUMNS.into_iter().map(field).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("schema")
        .with_fields(fields)
        .build()?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_dictionary_enabled(false)
        .build();
    SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
}
