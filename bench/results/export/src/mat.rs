//! Export as Level 5 MAT-files: a struct for each recording.

use std::fs::File;
use std::io::BufWriter;
use std::path::PathBuf;

use escaping::ascii;

use crate::content::{FactValue, RecordingContent};
use crate::dictionary::DictionaryEntry;
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
    let states = names
        .iter()
        .map(|name| target.put(name, folder, |out| write_file(&variables, out)));
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
    let recording = structure(content, true);
    if recording.bytes(VARIABLE) <= limit_bytes {
        return vec![(VARIABLE.to_owned(), recording)];
    }
    let recording = structure(content, false);
    let mut variables = vec![(VARIABLE.to_owned(), recording)];
    if let Some(table) = &content.streams.signals {
        for column in &table.columns {
            let size = column
                .values
                .number_type()
                .map_or(8, |number| number.bytes());
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

/// Returns the struct of a recording; its signals have their samples or only their time base.
fn structure(content: &RecordingContent, with_samples: bool) -> MatArray<'_> {
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
    let constants = MatArray::Struct(constants.collect());
    fields.push(("constants".to_owned(), constants));
    for table in content.tables() {
        let mut values = Vec::new();
        if let Some(rate_hz) = table.rate_hz {
            values.push(("rate_hz".to_owned(), MatArray::Real(rate_hz)));
            values.push(("start_s".to_owned(), MatArray::Real(0.0)));
        }
        for column in &table.columns {
            if with_samples || table.rate_hz.is_none() {
                let value = MatArray::column(&column.values, table.rows);
                values.push((column.name.clone().into_owned(), value));
            }
        }
        fields.push((table.name.to_owned(), MatArray::Struct(values)));
    }
    let units = words(content, |entry| entry.unit);
    fields.push(("units".to_owned(), units));
    let meanings = words(content, |entry| &entry.meaning);
    fields.push(("meanings".to_owned(), meanings));
    fields.push(("warnings".to_owned(), MatArray::Cells(&content.warnings)));
    MatArray::Struct(fields)
}

/// Returns a struct with the fields of the recording's struct, and a word on each in place of its value. The words are ASCII, which
/// Octave needs.
fn words<'a>(content: &RecordingContent, word: impl Fn(&DictionaryEntry) -> &str) -> MatArray<'a> {
    let mut tables: Vec<(String, Vec<(String, MatArray<'a>)>)> = Vec::new();
    for entry in DictionaryEntry::of_recording(content) {
        let text = MatArray::Text(ascii(word(&entry)).into_owned());
        if tables.last().is_none_or(|(table, _)| table != entry.table) {
            tables.push((entry.table.to_owned(), Vec::new()));
        }
        if let Some((_, fields)) = tables.last_mut() {
            fields.push((entry.column, text));
        }
    }
    let tables = tables.into_iter();
    MatArray::Struct(
        tables
            .map(|(table, fields)| (table, MatArray::Struct(fields)))
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identity::RecordingIdentity;
    use recording::manifest::MINIMAL;
    use recording::writer::Ending;
    use recording::{AudioFormat, Manifest, RecordingWriter};

    #[test]
    fn samples_beyond_the_limit_are_variables_in_parts() {
        let study = tempfile::tempdir().unwrap();
        let folder = study.path().join("long");
        let manifest = Manifest::parse(MINIMAL, "recording.toml").unwrap();
        let format = AudioFormat {
            sample_rate_hz: 96_000,
            channels: 2,
        };
        let frames: u16 = 20_000;
        let mut writer = RecordingWriter::create(&folder, manifest, format).unwrap();
        let samples = (0..2 * frames).map(|n| f32::from(n) / 65_536.0);
        writer.write_audio(&samples.collect::<Vec<_>>()).unwrap();
        writer.finish(Ending::Completed).unwrap();
        let content = RecordingContent::read(&RecordingIdentity::read(&folder), true).unwrap();
        assert_eq!(variables(&content, LIMIT_BYTES).len(), 1);

        // The struct without its samples has less than 30 kB; each channel has 80 kB.
        let limit_bytes = 40_000;
        let split = variables(&content, limit_bytes);
        let names: Vec<&str> = split.iter().map(|(name, _)| name.as_str()).collect();
        let parts = ["drive_v_part1", "drive_v_part2", "drive_v_part3"];
        assert_eq!(names[..4], [&["recording"], &parts[..]].concat());
        assert_eq!(names.len(), 7);
        assert!(
            split
                .iter()
                .all(|(name, array)| array.bytes(name) <= limit_bytes)
        );
        // The parts together are the channel.
        let numbers = |arrays: &[(String, MatArray<'_>)]| {
            let mut bytes = Vec::new();
            for (_, array) in arrays {
                let MatArray::Numbers(values, range) = array else {
                    panic!("{array:?}");
                };
                crate::numbers::write_numbers(values, range.clone(), &mut bytes).unwrap();
            }
            bytes
        };
        let column = &content.streams.signals.as_ref().unwrap().columns[1].values;
        let mut whole = Vec::new();
        crate::numbers::write_numbers(column, 0..frames.into(), &mut whole).unwrap();
        assert_eq!(whole.len(), 80_000);
        assert!(numbers(&split[4..]) == whole);
    }
}
