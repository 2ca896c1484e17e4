//! Export as NPZ: an archive of NPY arrays for each recording, without pickled objects.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::column::ColumnValues;
use crate::content::{FactValue, RecordingContent};
use crate::dictionary::DictionaryEntry;
use crate::export_error::ExportError;
use crate::fill_error::FillError;
use crate::identity::RecordingIdentity;
use crate::numbers::{NumberType, write_numbers};
use crate::target_folder::{FileState, TargetFolder};

/// Bytes from which a member needs the fields of a large archive.
const LARGE_BYTES: u64 = u32::MAX as u64 - 4096;
/// Bytes before the header of an NPY array: magic, version and length.
const PREFIX_BYTES: usize = 10;

/// Returns the name of a recording's file.
pub(crate) fn names(identity: &RecordingIdentity) -> Vec<PathBuf> {
    vec![format!("{}.npz", identity.name()).into()]
}

/// Writes the file of a recording.
///
/// # Errors
/// The recording cannot be read, or the file cannot be written.
pub(crate) fn write(
    content: &RecordingContent,
    target: &TargetFolder,
) -> Result<Vec<FileState>, ExportError> {
    let names = names(&content.identity);
    let folder = &content.identity.folder;
    let states = names
        .iter()
        .map(|name| target.put(name, folder, |out| write_archive(content, out)));
    states.collect()
}

fn write_archive(content: &RecordingContent, out: &mut BufWriter<File>) -> Result<(), FillError> {
    let mut archive = Archive {
        zip: ZipWriter::new(out),
    };
    for fact in content.facts() {
        match fact.value {
            FactValue::Text(text) => archive.texts(fact.name, "", &[text])?,
            FactValue::Whole(number) => {
                archive.numbers(fact.name, "", &ColumnValues::Whole(vec![number]), 1)?;
            }
        }
    }
    for constant in &content.constants {
        let value = ColumnValues::Real(vec![constant.value]);
        archive.numbers(constant.name, "", &value, 1)?;
    }
    for table in content.tables() {
        if let Some(rate_hz) = table.rate_hz {
            let name = format!("{}_rate_hz", table.name);
            archive.numbers(&name, "", &ColumnValues::Real(vec![rate_hz]), 1)?;
        }
        for column in &table.columns {
            let name = format!("{}_{}", table.name, column.name);
            let shape = format!("{},", table.rows);
            match &column.values {
                ColumnValues::Text(texts) => archive.texts(&name, &shape, texts)?,
                values => archive.numbers(&name, &shape, values, table.rows)?,
            }
        }
    }
    let shape = format!("{},", content.warnings.len());
    archive.texts("warnings", &shape, &content.warnings)?;
    let entries: Vec<DictionaryEntry> = DictionaryEntry::of_recording(content).collect();
    let shape = format!("{},", entries.len());
    let array_name = |entry: &DictionaryEntry| match entry.table {
        "recording" | "constants" => entry.column.clone(),
        table => format!("{table}_{}", entry.column),
    };
    for (name, words) in [
        (
            "dictionary_array",
            entries.iter().map(array_name).collect::<Vec<_>>(),
        ),
        (
            "dictionary_unit",
            entries.iter().map(|entry| entry.unit.to_owned()).collect(),
        ),
        (
            "dictionary_meaning",
            entries.iter().map(|entry| entry.meaning.clone()).collect(),
        ),
    ] {
        archive.texts(name, &shape, &words)?;
    }
    archive.zip.finish().map_err(std::io::Error::from)?;
    Ok(())
}

/// Archive that is being written.
struct Archive<'a> {
    zip: ZipWriter<&'a mut BufWriter<File>>,
}

impl Archive<'_> {
    /// Begins an array of this NPY type and shape, with `bytes` of data.
    fn begin(&mut self, name: &str, kind: &str, shape: &str, bytes: u64) -> Result<(), FillError> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::DEFAULT)
            .large_file(bytes >= LARGE_BYTES);
        let member = format!("{name}.npy");
        self.zip
            .start_file(member, options)
            .map_err(std::io::Error::from)?;
        Ok(self.zip.write_all(&header(kind, shape))?)
    }

    fn numbers(
        &mut self,
        name: &str,
        shape: &str,
        values: &ColumnValues,
        rows: u64,
    ) -> Result<(), FillError> {
        let number = values.number_type().unwrap_or(NumberType::Double);
        let kind = match number {
            NumberType::Single => "<f4",
            NumberType::Double => "<f8",
            NumberType::Whole => "<i8",
        };
        self.begin(name, kind, shape, rows * number.bytes())?;
        write_numbers(values, 0..rows, &mut self.zip)
    }

    /// Writes texts as an array of UTF-32 of equal lengths.
    fn texts(&mut self, name: &str, shape: &str, texts: &[String]) -> Result<(), FillError> {
        let lengths = texts.iter().map(|text| text.chars().count());
        let width = lengths.max().unwrap_or(0).max(1);
        let mut bytes = Vec::with_capacity(4 * width * texts.len());
        for text in texts {
            let end = bytes.len() + 4 * width;
            bytes.extend(text.chars().flat_map(|c| u32::from(c).to_le_bytes()));
            bytes.resize(end, 0);
        }
        self.begin(name, &format!("<U{width}"), shape, bytes.len() as u64)?;
        Ok(self.zip.write_all(&bytes)?)
    }
}

/// Returns the header of an NPY array, version 1.0: a length that is a multiple of 64.
fn header(kind: &str, shape: &str) -> Vec<u8> {
    let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
    let length = (PREFIX_BYTES + text.len() + 1).next_multiple_of(64) - PREFIX_BYTES;
    text.extend(std::iter::repeat_n(' ', length - text.len() - 1));
    text.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(text.into_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_ends_at_a_multiple_of_64_bytes() {
        for shape in ["", "3,", "123456789012,"] {
            let bytes = header("<f8", shape);
            assert_eq!(bytes.len() % 64, 0);
            assert_eq!(bytes.last(), Some(&b'\n'));
            let length = u16::from_le_bytes([bytes[8], bytes[9]]);
            assert_eq!(usize::from(length), bytes.len() - PREFIX_BYTES);
        }
    }
}
