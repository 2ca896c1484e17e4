//! Export as Level 5 MAT-files: a struct for each recording.

use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

use crate::column::ExportedTable;
use crate::content::{FactValue, RecordingContent};
use crate::export_error::ExportError;
use crate::fill_error::FillError;
use crate::identity::RecordingIdentity;
use crate::mat_array::{LIMIT_BYTES, MatArray, write_header};
use crate::target_folder::{FileState, TargetFolder};

/// Name of the variable.
const VARIABLE: &str = "recording";
/// Bytes of the head of a variable with numbers, at most.
const HEAD_BYTES: u64 = 256;

/// Returns the name of a recording's file.
pub(crate) fn names(identity: &RecordingIdentity) -> Vec<PathBuf> {
    vec![format!("{}.mat", identity.name()).into()]
}

/// Writes the file of a recording.
///
/// # Errors
/// The recording cannot be read or is too large for the format, or the file cannot be written.
pub(crate) fn write(
    content: &RecordingContent,
    target: &TargetFolder,
) -> Result<Vec<FileState>, ExportError> {
    let folder = &content.identity.folder;
    let variables = variables(content, LIMIT_BYTES);
    let too_large = variables
        .iter()
        .find(|(name, array)| array.bytes(name) > LIMIT_BYTES);
    if let Some((name, _)) = too_large {
        return Err(ExportError::TooLarge {
            recording: folder.clone(),
            part: name.clone(),
        });
    }
    let names = names(&content.identity);
    let states = names.iter().map(|name| {
        target.put(name, folder, |out| write_file(&variables, out))
    });
    states.collect()
}

fn write_file(
    variables: &[(String, MatArray<'_>)],
    out: &mut BufWriter<File>,
) -> Result<(), FillError> {
    let program = concat!("friction-bench ", env!("CARGO_PKG_VERSION"));
    write_header(&format!("MATLAB 5.0 MAT-file, created by: {program}"), out)?;
    for (name, array) in variables {
        array.write(name, out)?;
    }
    Ok(())
}

/// Returns the variables of a recording, each of at most `limit_bytes` where its columns can be split: the struct, and the samples as
/// separate variables if the struct is too large with them.
fn variables(content: &RecordingContent, limit_bytes: u64) -> Vec<(String, MatArray<'_>)> {
    let recording = structure(content, content.signals.as_ref().map(|table| (table, true)));
    if recording.bytes(VARIABLE) <= limit_bytes {
        return vec![(VARIABLE.to_owned(), recording)];
    }
    let recording = structure(content, content.signals.as_ref().map(|table| (table, false)));
    let mut variables = vec![(VARIABLE.to_owned(), recording)];
    for table in &content.signals {
        for column in &table.columns {
            let size = column.values.number_type().map_or(8, |number| number.bytes());
            let most_rows = (limit_bytes.saturating_sub(HEAD_BYTES) / size).max(1);
            let parts = table.rows.div_ceil(most_rows);
            for part in 0..parts {
                let range = part * most_rows..table.rows.min((part + 1) * most_rows);
                let name = match parts {
                    1 => column.name.clone().into_owned(),
                    _ => format!("{}_part{}", column.name, part + 1),
                };
                variables.push((name, MatArray::Numbers(&column.values, range)));
            }
        }
    }
    variables
}

/// Returns the struct of a recording; the signals have their samples or only their time base.
fn structure<'a>(
    content: &'a RecordingContent,
    signals: Option<(&'a ExportedTable, bool)>,
) -> MatArray<'a> {
    let mut fields = Vec::new();
    for fact in content.facts() {
        let value = match fact.value {
            FactValue::Text(text) => MatArray::Text(text),
            FactValue::Whole(number) => MatArray::Whole(number),
        };
        fields.push((fact.name.to_owned(), value));
    }
    let constants = content.constants.iter();
    let constants = constants.map(|c| (c.name.to_owned(), MatArray::Real(c.value)));
    fields.push(("constants".to_owned(), MatArray::Struct(constants.collect())));
    let (mut units, mut meanings) = (constant_words(content, |c| c.unit), constant_words(content, |c| c.meaning));
    for table in content.tables() {
        let is_left_out = signals.is_some_and(|(signals, with_samples)| {
            std::ptr::eq(signals, table) && !with_samples
        });
        let columns = if is_left_out { &[] } else { table.columns.as_slice() };
        let mut values = time_base(table);
        for column in columns {
            let value = MatArray::column(&column.values, table.rows);
            values.push((column.name.clone().into_owned(), value));
        }
        fields.push((table.name.to_owned(), MatArray::Struct(values)));
        let words = |word: fn(&crate::column::ExportedColumn) -> &str| {
            let columns = table.columns.iter();
            let words = columns.map(|column| {
                let text = MatArray::Text(word(column).to_owned());
                (column.name.clone().into_owned(), text)
            });
            (table.name.to_owned(), MatArray::Struct(words.collect()))
        };
        units.push(words(|column| column.unit));
        meanings.push(words(|column| &column.meaning));
    }
    fields.push(("units".to_owned(), MatArray::Struct(units)));
    fields.push(("meanings".to_owned(), MatArray::Struct(meanings)));
    fields.push(("warnings".to_owned(), MatArray::Cells(&content.warnings)));
    MatArray::Struct(fields)
}

/// Returns the fields of an even time base.
fn time_base(table: &ExportedTable) -> Vec<(String, MatArray<'static>)> {
    match table.rate_hz {
        Some(rate_hz) => vec![
            ("rate_hz".to_owned(), MatArray::Real(rate_hz)),
            ("start_s".to_owned(), MatArray::Real(0.0)),
        ],
        None => Vec::new(),
    }
}

fn constant_words<'a>(
    content: &RecordingContent,
    word: fn(&crate::constants::Constant) -> &'static str,
) -> Vec<(String, MatArray<'a>)> {
    let constants = content.constants.iter();
    let words = constants.map(|c| (c.name.to_owned(), MatArray::Text(word(c).to_owned())));
    vec![("constants".to_owned(), MatArray::Struct(words.collect()))]
}
