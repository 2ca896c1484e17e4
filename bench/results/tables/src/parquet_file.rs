//! A table as Parquet. The directory of the file is at its end, so it is made in memory and written as a whole.

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
use recording::disk;

use crate::column::{Column, Table, Values};
use crate::dictionary;
use crate::metadata::{METADATA_KEYS, Metadata};
use crate::table_error::TableError;

/// Writes the table into `folder`, replacing an existing file, and returns the path.
///
/// # Errors
/// The table cannot be encoded, or the operating system refused.
pub(crate) fn write(
    table: &Table,
    metadata: &Metadata,
    folder: &Path,
) -> Result<PathBuf, TableError> {
    let path = folder.join(format!("{}.parquet", table.name));
    let bytes = to_bytes(table, metadata, Vec::new(), &path)?;
    disk::replace_file(&path, &bytes)?;
    Ok(path)
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
    to_bytes(table, &Metadata::new(analysed), texts, path)
}

fn to_bytes(
    table: &Table,
    metadata: &Metadata,
    texts: Vec<(String, String)>,
    path: &Path,
) -> Result<Vec<u8>, TableError> {
    encode(table, metadata, texts).map_err(|reason| TableError::Encode {
        path: path.to_owned(),
        reason: Box::new(reason),
    })
}

fn encode(
    table: &Table,
    metadata: &Metadata,
    further_texts: Vec<(String, String)>,
) -> Result<Vec<u8>, ParquetError> {
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
    let pairs = pairs.map(|(key, text)| ((*key).to_owned(), text));
    let pairs = pairs.chain(further_texts);
    let pairs = pairs.map(|(key, text)| KeyValue::new(key, text));
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(pairs.collect()))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
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
    writer.into_inner()
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
