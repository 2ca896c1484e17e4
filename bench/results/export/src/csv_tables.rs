//! Export as tables of text: UTF-8, commas, decimal points, a header; unknown numbers are empty.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use escaping::to_cell;

use crate::column::{ColumnValues, ExportedTable};
use crate::content::{FactValue, RecordingContent};
use crate::decimal::{number, single};
use crate::dictionary::DictionaryEntry;
use crate::export_error::ExportError;
use crate::fill_error::FillError;
use crate::identity::RecordingIdentity;
use crate::recorded_tables::{ENVELOPES, STIMULUS};
use crate::stream::{BLOCK, OpenStream};
use crate::target_folder::{FileState, TargetFolder};

/// Dictionary of the columns.
const DICTIONARY: &str = "columns.csv";
/// Tables in a recording's folder.
const TABLES: [&str; 10] = [
    "recording",
    "constants",
    "signals",
    ENVELOPES,
    "forces",
    "positions",
    STIMULUS,
    "friction",
    "intervals",
    "events",
];
/// Name of the column with the times of an even time base.
const TIME: &str = "time_s";

/// Returns the names of a recording's files.
pub(crate) fn names(identity: &RecordingIdentity, with_signals: bool) -> Vec<PathBuf> {
    let tables = TABLES
        .iter()
        .filter(|table| with_signals || **table != "signals");
    tables.map(|table| name(identity, table)).collect()
}

/// Returns the names of the files of the whole study.
pub(crate) fn study_names() -> Vec<PathBuf> {
    vec![DICTIONARY.into()]
}

fn name(identity: &RecordingIdentity, table: &str) -> PathBuf {
    Path::new(&identity.name()).join(format!("{table}.csv"))
}

/// Writes the tables of a recording.
///
/// # Errors
/// The recording cannot be read, or a file cannot be written.
pub(crate) fn write(
    content: &RecordingContent,
    target: &TargetFolder,
) -> Result<Vec<FileState>, ExportError> {
    let (identity, folder) = (&content.identity, &content.identity.folder);
    let mut states = Vec::new();
    let put = |table: &str, header: &[&str], rows: Vec<Vec<String>>| {
        target.put(&name(identity, table), folder, |out| {
            write_rows(out, header, rows.iter())
        })
    };
    let facts = content.facts().into_iter().map(|fact| {
        let value = match fact.value {
            FactValue::Text(text) => to_cell(&text),
            FactValue::Whole(number) => number.to_string(),
        };
        vec![fact.name.to_owned(), value]
    });
    let warnings = content.warnings.iter();
    let warnings = warnings.map(|text| vec!["warning".to_owned(), to_cell(text)]);
    states.push(put(
        "recording",
        &["name", "value"],
        facts.chain(warnings).collect(),
    )?);
    let constants = content.constants.iter().map(|constant| {
        let mut value = String::new();
        number(&mut value, constant.value);
        vec![constant.name.to_owned(), value, constant.unit.to_owned()]
    });
    states.push(put(
        "constants",
        &["name", "value", "unit"],
        constants.collect(),
    )?);
    for table in content.tables() {
        let name = name(identity, table.name);
        states.push(target.put(&name, folder, |out| write_table(table, out))?);
    }
    Ok(states)
}

/// Writes the dictionary of all recordings.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_dictionary(
    entries: &BTreeSet<DictionaryEntry>,
    target: &TargetFolder,
) -> Result<FileState, ExportError> {
    let rows = entries.iter().map(|entry| {
        let table = format!("{}.csv", entry.table);
        // The times of an even time base are a column here.
        let (column, unit, meaning) = match entry.column.as_str() {
            "rate_hz" => (TIME, "s", "time from sample 0 of the recording"),
            column => (column, entry.unit, entry.meaning.as_str()),
        };
        [
            table,
            column.to_owned(),
            unit.to_owned(),
            meaning.to_owned(),
        ]
    });
    let rows: Vec<_> = rows.collect();
    target.put(Path::new(DICTIONARY), Path::new(DICTIONARY), |out| {
        write_rows(out, &["table", "name", "unit", "meaning"], rows.iter())
    })
}

fn write_rows<R: AsRef<[String]>>(
    out: &mut BufWriter<File>,
    header: &[&str],
    rows: impl Iterator<Item = R>,
) -> Result<(), FillError> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(header).map_err(io_error)?;
    for row in rows {
        writer.write_record(row.as_ref()).map_err(io_error)?;
    }
    Ok(writer.flush()?)
}

fn io_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        kind => io::Error::other(format!("{kind:?}")),
    }
}

/// Column that is being read.
enum OpenColumn<'a> {
    /// Times of an even time base.
    Times { rate_hz: f64 },
    /// Numbers of a file of the recording.
    Stream {
        stream: OpenStream,
        is_single: bool,
        block: Vec<f64>,
    },
    /// Values in memory.
    Values(&'a ColumnValues),
}

impl<'a> OpenColumn<'a> {
    fn new(values: &'a ColumnValues) -> Result<Self, FillError> {
        Ok(match values {
            ColumnValues::Stream(stream) => Self::Stream {
                stream: stream.open()?,
                is_single: stream.is_single(),
                block: Vec::new(),
            },
            values => Self::Values(values),
        })
    }

    /// Appends the cell of a row; rows are asked for in their order.
    fn cell(&mut self, row: usize, cell: &mut String) -> Result<(), FillError> {
        match self {
            Self::Times { rate_hz } => number(cell, row as f64 / *rate_hz),
            Self::Stream {
                stream,
                is_single,
                block,
            } => {
                if row.is_multiple_of(BLOCK) {
                    stream.read(block)?;
                }
                let value = *block.get(row % BLOCK).ok_or(FillError::Changed)?;
                match is_single {
                    true => single(cell, value as f32),
                    false => number(cell, value),
                }
            }
            Self::Values(ColumnValues::Real(values)) => number(cell, values[row]),
            Self::Values(ColumnValues::Whole(values)) => {
                let _ = write!(cell, "{}", values[row]);
            }
            Self::Values(ColumnValues::Text(values)) => cell.push_str(&to_cell(&values[row])),
            Self::Values(ColumnValues::Stream(_)) => {}
        }
        Ok(())
    }
}

fn write_table(table: &ExportedTable, out: &mut BufWriter<File>) -> Result<(), FillError> {
    let mut writer = csv::Writer::from_writer(out);
    let times = table.rate_hz.map(|rate_hz| OpenColumn::Times { rate_hz });
    let names = table.columns.iter().map(|column| &*column.name);
    let names = times.iter().map(|_| TIME).chain(names);
    writer.write_record(names).map_err(io_error)?;
    let mut columns = Vec::from_iter(times);
    for column in &table.columns {
        columns.push(OpenColumn::new(&column.values)?);
    }
    let mut cell = String::new();
    for row in 0..table.rows as usize {
        for column in &mut columns {
            cell.clear();
            column.cell(row, &mut cell)?;
            writer.write_field(&cell).map_err(io_error)?;
        }
        writer.write_record(None::<&[u8]>).map_err(io_error)?;
    }
    Ok(writer.flush()?)
}
