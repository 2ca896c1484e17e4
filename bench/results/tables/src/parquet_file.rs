//! A table as Parquet.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use analysis::Analysis;
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::column::{Column, Table, Values};
use crate::dictionary;
use crate::metadata::{METADATA_KEYS, Metadata};
use crate::table_error::TableError;
use crate::temporary_file::TemporaryFile;

/// Most rows of a row group but for those of one recording: some 40 MB of samples.
const GROUP_ROWS: usize = 100_000;

/// File of a table that is being written. Its rows are gathered to row groups.
pub(crate) struct ParquetFile {
    writer: SerializedFileWriter<File>,
    file: TemporaryFile,
    rows: Vec<Column>,
    has_group: bool,
}

impl ParquetFile {
    /// Creates the file of a table in `folder`, without rows.
    ///
    /// # Errors
    /// The table cannot be encoded, or the operating system refused.
    pub(crate) fn create(
        table: &Table,
        metadata: &Metadata,
        folder: &Path,
    ) -> Result<Self, TableError> {
        let path = folder.join(format!("{}.parquet", table.name));
        let (file, handle) = TemporaryFile::create(path)?;
        let writer =
            writer(handle, table, metadata).map_err(|reason| encode_error(&file, reason))?;
        let mut rows = table.columns.clone();
        rows.iter_mut().for_each(|column| column.values.clear());
        Ok(Self {
            writer,
            file,
            rows,
            has_group: false,
        })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// The rows cannot be encoded, or the operating system refused.
    pub(crate) fn append(&mut self, table: &Table) -> Result<(), TableError> {
        for (column, part) in self.rows.iter_mut().zip(&table.columns) {
            column.values.append(&part.values);
        }
        let rows = self.rows.first().map_or(0, |column| column.values.len());
        if rows >= GROUP_ROWS {
            self.write_group()?;
        }
        Ok(())
    }

    fn write_group(&mut self) -> Result<(), TableError> {
        let result = group(&mut self.writer, &self.rows);
        result.map_err(|reason| encode_error(&self.file, reason))?;
        let columns = self.rows.iter_mut();
        columns.for_each(|column| column.values.clear());
        self.has_group = true;
        Ok(())
    }

    /// Replaces an existing file, and returns the path.
    ///
    /// # Errors
    /// The rows cannot be encoded, or the operating system refused.
    pub(crate) fn close(mut self) -> Result<PathBuf, TableError> {
        let is_empty = self
            .rows
            .first()
            .is_none_or(|column| column.values.is_empty());
        if !(is_empty && self.has_group) {
            self.write_group()?;
        }
        let Self { writer, file, .. } = self;
        let handle = writer.into_inner();
        let handle = handle.map_err(|reason| encode_error(&file, reason))?;
        Ok(file.replace(&handle)?)
    }
}

fn encode_error(file: &TemporaryFile, reason: ParquetError) -> TableError {
    TableError::Encode {
        path: file.temporary().to_owned(),
        reason: Box::new(reason),
    }
}

/// Returns the table of an analysis as the bytes of a Parquet file, with further texts in its metadata; `path` names it in errors.
///
/// # Errors
/// The table cannot be encoded.
pub fn to_parquet(
    table: &Table,
    analysed: &Analysis,
    texts: Vec<(String, String)>,
    path: &Path,
) -> Result<Vec<u8>, TableError> {
    let encode = || {
        let mut writer = writer(Vec::new(), table, &Metadata::new(analysed))?;
        for (key, text) in texts {
            writer.append_key_value_metadata(KeyValue::new(key, text));
        }
        group(&mut writer, &table.columns)?;
        writer.into_inner()
    };
    encode().map_err(|reason| TableError::Encode {
        path: path.to_owned(),
        reason: Box::new(reason),
    })
}

fn writer<W: Write + Send>(
    handle: W,
    table: &Table,
    metadata: &Metadata,
) -> Result<SerializedFileWriter<W>, ParquetError> {
    let fields = table.columns.iter().map(field);
    let schema = Type::group_type_builder("schema")
        .with_fields(fields.collect::<Result<_, _>>()?)
        .build()?;
    let json_error = |error: serde_json::Error| ParquetError::External(Box::new(error));
    let texts = [
        serde_json::to_string(&metadata.settings).map_err(json_error)?,
        serde_json::to_string(&metadata.provenance).map_err(json_error)?,
        serde_json::to_string(&dictionary::entries(table)).map_err(json_error)?,
    ];
    let pairs = METADATA_KEYS.iter().zip(texts);
    let pairs = pairs.map(|(key, text)| KeyValue::new((*key).to_owned(), text));
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(pairs.collect()))
        .build();
    SerializedFileWriter::new(handle, Arc::new(schema), Arc::new(properties))
}

/// Writes a row group.
fn group<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    columns: &[Column],
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for column in columns {
        let Some(mut column_writer) = group.next_column()? else {
            break;
        };
        match &column.values {
            Values::Flag(values) => column_writer
                .typed::<BoolType>()
                .write_batch(values, None, None)?,
            Values::Text(values) => {
                let values = values
                    .iter()
                    .map(|text| ByteArray::from(text.as_bytes().to_vec()));
                column_writer.typed::<ByteArrayType>().write_batch(
                    &values.collect::<Vec<_>>(),
                    None,
                    None,
                )?
            }
            Values::Integer(values) => column_writer
                .typed::<Int64Type>()
                .write_batch(values, None, None)?,
            Values::Real(values) => column_writer
                .typed::<DoubleType>()
                .write_batch(values, None, None)?,
        };
        column_writer.close()?;
    }
    group.close()?;
    Ok(())
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical_type, logical_type) = match &column.values {
        Values::Flag(_) => (PhysicalType::BOOLEAN, None),
        Values::Text(_) => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        Values::Integer(_) => (PhysicalType::INT64, None),
        Values::Real(_) => (PhysicalType::DOUBLE, None),
    };
    Type::primitive_type_builder(&column.name, physical_type)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(logical_type)
        .build()
        .map(Arc::new)
}
