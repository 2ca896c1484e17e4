//! Archives of NumPy's arrays, stored or deflated.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::ops::Range;
use std::sync::Arc;

use file_sections::{Bytes, Compression, Inflated, Section, Sources};
use zip::{CompressionMethod, ZipArchive};

use crate::array::{ArrayInfo, Attribute};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values};
use crate::kind::foreign;
use crate::npy::NpyArray;

/// Maximum number of entries of an archive.
const MOST_ENTRIES: usize = 10_000;

/// Reader of a `.npz` file.
pub(crate) struct NpzReader {
    archive: ZipArchive<BufReader<File>>,
    sources: Sources,
    entries: Vec<NpyArray>,
    /// Place of each entry in the archive, until its checksum was compared.
    unchecked: Vec<Option<usize>>,
    arrays: Vec<ArrayInfo>,
    /// Entry and column of each array; `None` for an entry that is not read.
    places: Vec<Option<(usize, usize)>>,
    notes: Vec<String>,
    attributes: BTreeMap<String, Attribute>,
}

impl NpzReader {
    /// Opens a ZIP archive.
    pub(crate) fn open(file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
        let file_bytes = file.metadata()?.len();
        let archive = ZipArchive::new(BufReader::new(file.try_clone()?)).map_err(|_| {
            SourceError::damaged(
                "its end",
                "the table of contents of this ZIP archive is missing",
            )
        })?;
        if archive.len() > MOST_ENTRIES {
            return Err(foreign(
                "a ZIP archive of many files",
                "unpack it, and name a file in it",
            )
            .into());
        }
        let file = Arc::new(file);
        let mut reader = Self {
            archive,
            sources: Sources::default(),
            entries: Vec::new(),
            unchecked: Vec::new(),
            arrays: Vec::new(),
            places: Vec::new(),
            notes: Vec::new(),
            attributes: BTreeMap::new(),
        };
        let mut is_workbook = false;
        for index in 0..reader.archive.len() {
            let Ok(entry) = reader.archive.by_index_raw(index) else {
                let place = format!("entry {index} of the archive");
                return Err(SourceError::damaged(place, "its header is missing"));
            };
            let Ok(name) = entry.name().map(std::borrow::Cow::into_owned) else {
                continue;
            };
            is_workbook |= name == "[Content_Types].xml";
            let Some(stem) = name.strip_suffix(".npy") else {
                continue;
            };
            let compression = match entry.compression() {
                _ if entry.encrypted() => None,
                CompressionMethod::Stored => Some(None),
                CompressionMethod::Deflated => Some(Some(Compression::Deflate)),
                _ => None,
            };
            let (Some(compression), Some(start)) = (compression, entry.data_start()) else {
                let class = "array that is encrypted or compressed by a method other than deflate";
                reader.arrays.push(ArrayInfo::opaque(stem, class));
                reader.places.push(None);
                continue;
            };
            let end = start
                .saturating_add(entry.compressed_size())
                .min(file_bytes);
            let section = Section::new(Arc::clone(&file), start, end);
            let n_bytes = match compression {
                None => section.len(),
                Some(_) => entry.size(),
            };
            let bytes: Box<dyn Bytes> = match compression {
                None => Box::new(section),
                Some(compression) => Box::new(Inflated::new(section, compression)),
            };
            let stem = stem.to_owned();
            drop(entry);
            reader.add(&stem, bytes, n_bytes)?;
            reader.unchecked.push(Some(index));
        }
        if reader.arrays.is_empty() {
            return Err(match is_workbook {
                true => foreign("an Excel workbook", "save the sheet as CSV"),
                false => foreign(
                    "a ZIP archive without NumPy's arrays",
                    "unpack it, and name a file in it",
                ),
            }
            .into());
        }
        Ok(Box::new(reader))
    }

    fn add(
        &mut self,
        name: &str,
        mut bytes: Box<dyn Bytes>,
        n_bytes: u64,
    ) -> Result<(), SourceError> {
        let array = NpyArray::open(&mut *bytes, name, n_bytes).map_err(|error| SourceError {
            place: Some(format!("array `{name}`")),
            ..error
        })?;
        for (column, content) in array.columns.iter().enumerate() {
            self.arrays.push(content.info.clone());
            self.places.push(Some((self.entries.len(), column)));
        }
        self.notes.extend(array.notes.iter().cloned());
        self.entries.push(array);
        bytes.close();
        self.sources.push(bytes);
        Ok(())
    }

    /// Compares the checksum of an array's entry before its first values are read.
    fn check(&mut self, index: usize) -> Result<(), SourceError> {
        let Some((entry, _)) = self.places.get(index).copied().flatten() else {
            return Ok(());
        };
        let Some(archived) = self.unchecked.get_mut(entry).and_then(Option::take) else {
            return Ok(());
        };
        let content = self.archive.by_index(archived);
        let is_whole =
            content.is_ok_and(|mut content| io::copy(&mut content, &mut io::sink()).is_ok());
        if is_whole {
            return Ok(());
        }
        self.unchecked[entry] = Some(archived);
        let name = self
            .arrays
            .get(index)
            .map_or("", |array| array.name.as_str());
        Err(SourceError::damaged(
            format!("array `{name}`"),
            "its bytes differ from those that were written, by their checksum (CRC-32)",
        ))
    }

    /// Returns the entry of an array, its bytes, and the array's column.
    fn entry(&mut self, index: usize) -> Option<(&NpyArray, &mut dyn Bytes, usize)> {
        let (entry, column) = self.places.get(index).copied().flatten()?;
        Some((self.entries.get(entry)?, self.sources.get(entry), column))
    }
}

impl ArrayReader for NpzReader {
    fn format(&self) -> Format {
        Format::Npz
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn text(&mut self, index: usize) -> Result<Option<String>, SourceError> {
        self.check(index)?;
        match self.entry(index) {
            Some((array, bytes, column)) => array.text(bytes, column),
            None => Ok(None),
        }
    }

    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        self.check(index)?;
        match self.entry(index) {
            Some((array, bytes, column)) => array.read(bytes, column, place, range, values),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Seek, Write};

    use zip::write::SimpleFileOptions;

    use super::*;

    /// Returns an archive of one array, with this byte of its file turned.
    fn archive(method: CompressionMethod, turned: Option<usize>) -> File {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (512,), }";
        let header = format!("{header:<117}\n");
        let mut npy = b"\x93NUMPY\x01\x00".to_vec();
        npy.extend((header.len() as u16).to_le_bytes());
        npy.extend(header.as_bytes());
        npy.extend((0..512).flat_map(|n| f64::from(n).sin().to_le_bytes()));
        let mut writer = zip::ZipWriter::new(io::Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(method);
        writer.start_file("force.npy", options).unwrap();
        writer.write_all(&npy).unwrap();
        let mut bytes = writer.finish().unwrap().into_inner();
        if let Some(place) = turned {
            bytes[place] ^= 0x10;
        }
        let mut file = tempfile::tempfile().unwrap();
        file.write_all(&bytes).unwrap();
        file.rewind().unwrap();
        file
    }

    #[test]
    fn an_archive_with_other_bytes_than_were_written_is_refused() {
        for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
            let read = |turned: Option<usize>| {
                let mut reader = NpzReader::open(archive(method, turned)).unwrap();
                assert_eq!(reader.arrays()[0].name, "force");
                reader.text(0).map(|_| ())
            };
            read(None).unwrap();
            let words = read(Some(1500)).unwrap_err().to_string();
            assert!(
                words.contains("array `force`") && words.contains("checksum"),
                "{words}"
            );
        }
    }
}
