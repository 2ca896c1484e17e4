//! Files of other programs as named arrays: listed when opened, read by stretches.
//!
//! [`SourceFile::open`] finds the format by content. [`SourceFile::locate`] finds a vector by its name, [`SourceFile::read`]
//! appends a stretch of it. A refusal names the file, the place in it and the remedy.

mod array;
mod error;
mod file_format;
mod flac;
mod format;
mod hdf5;
mod kind;
mod lvm;
mod matlab;
mod matlab4;
mod matlab73;
mod name;
mod npy;
mod npz;
mod numbers;
mod parquet_file;
mod place;
mod tdms;
mod text;
mod wave;

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use num_complex::Complex64;

pub use array::{ArrayInfo, Attribute, Element, Vector};
pub use error::{SourceError, SourceFault};
pub use file_format::Format;
use format::{ArrayReader, Values};
use kind::Kind;

/// File of another program.
pub struct SourceFile {
    path: PathBuf,
    reader: Box<dyn ArrayReader>,
}

impl std::fmt::Debug for SourceFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SourceFile")
            .field("path", &self.path)
            .field("format", &self.format())
            .field("arrays", &self.arrays())
            .finish()
    }
}

impl SourceFile {
    /// Opens a file by its content, not by its name, and lists its arrays.
    ///
    /// # Errors
    /// [`SourceError`] for a file that is absent, damaged, of a kind that is not read, or without numbers.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        let reader = open_reader(path).map_err(|error| with_file(error, path))?;
        let has_numbers = reader.arrays().iter().any(|info| info.element.is_numeric())
            || reader.arrays().iter().any(|info| info.unreadable.is_some())
            || !reader.attributes().is_empty();
        if !has_numbers {
            let mut notes = reader.notes().iter();
            if let Some(cut) = notes.find(|note| note.starts_with("the file ends within")) {
                let finding = cut.split(';').next().unwrap_or(cut);
                return Err(with_file(SourceError::damaged("its end", finding), path));
            }
            let format = reader.format();
            return Err(with_file(SourceFault::NoNumbers { format }.into(), path));
        }
        Ok(Self {
            path: path.to_owned(),
            reader,
        })
    }

    /// Returns the path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the format.
    #[must_use]
    pub fn format(&self) -> Format {
        self.reader.format()
    }

    /// Returns the arrays, in the order of the file.
    #[must_use]
    pub fn arrays(&self) -> &[ArrayInfo] {
        self.reader.arrays()
    }

    /// Returns the attributes, by names as `/g/x@fs`.
    pub fn attributes(&self) -> impl Iterator<Item = (&str, &Attribute)> {
        let attributes = self.reader.attributes().iter();
        attributes.map(|(name, attribute)| (name.as_str(), attribute))
    }

    /// Returns the sampling rate that the file states for all its arrays, Hz.
    #[must_use]
    pub fn stated_rate_hz(&self) -> Option<f64> {
        self.reader.stated_rate_hz()
    }

    /// Returns sentences for a user about the content: a cut end, decimal commas, two columns of time.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        self.reader.notes()
    }

    /// Finds the vector that `name` means: `U`, `/U`, `S.F[:,2]`, `group/channel`, a column's name or number, `[:,0]`.
    ///
    /// # Errors
    /// No array of numbers has the name, or its indices do not choose one vector.
    pub fn locate(&self, name: &str) -> Result<Vector, SourceError> {
        let vector = name::vector(self.arrays(), self.format().is_table(), name);
        vector.map_err(|fault| with_file(self.with_cell(fault), &self.path))
    }

    /// Returns a refusal; that of a column of texts names the first cell that is no number.
    fn with_cell(&self, fault: SourceFault) -> SourceError {
        let SourceFault::NoValues { name, .. } = &fault else {
            return fault.into();
        };
        let mut arrays = self.arrays().iter();
        let index = arrays.position(|info| info.name == *name && info.element == Element::Text);
        let cell = index.map(|index| self.reader.first_text(index));
        match cell {
            Some(Ok(Some(refusal)) | Err(refusal)) => refusal,
            Some(Ok(None)) | None => fault.into(),
        }
    }

    /// Reads a single number: an array of one element, an element (`p[3]`), a text that is a number, or an attribute
    /// (`/g/x@fs`).
    ///
    /// # Errors
    /// No array or attribute has the name, or it is not a single number.
    pub fn scalar(&mut self, name: &str) -> Result<f64, SourceError> {
        self.read_scalar(name)
            .map_err(|error| with_file(error, &self.path))
    }

    fn read_scalar(&mut self, name: &str) -> Result<f64, SourceError> {
        if name.contains('@') {
            return Ok(attribute(&*self.reader, name)?);
        }
        let single = name::single(self.arrays(), self.format().is_table(), name)?;
        let info = &self.arrays()[single.array];
        if info.element == Element::Text
            && let Some(text) = self.reader.text(single.array)?
        {
            return Ok(number(name, &text)?);
        }
        let info = &self.arrays()[single.array];
        name::require_values(info)?;
        require_real(info.element, name)?;
        let mut values = Vec::new();
        let range = single.index..single.index + 1;
        self.reader.read(
            single.array,
            &single.place,
            range,
            &mut Values::Real(&mut values),
        )?;
        values
            .first()
            .copied()
            .ok_or_else(|| SourceError::damaged(format!("array `{name}`"), "it has no value"))
    }

    /// Returns the text that the array `name` consists of; `None` where its elements are not texts.
    ///
    /// # Errors
    /// No array has the name, or the file cannot be read there.
    pub fn text(&mut self, name: &str) -> Result<Option<String>, SourceError> {
        let single = name::single(self.arrays(), self.format().is_table(), name);
        let text = match single {
            Ok(single) => self.reader.text(single.array),
            Err(fault) => Err(fault.into()),
        };
        text.map_err(|error| with_file(error, &self.path))
    }

    /// Appends the values `range` of a vector with real values.
    ///
    /// # Errors
    /// The vector is complex or shorter, or the file cannot be read there.
    pub fn read(
        &mut self,
        vector: &Vector,
        range: Range<u64>,
        values: &mut Vec<f64>,
    ) -> Result<(), SourceError> {
        require_real(vector.element, &vector.name)
            .map_err(|fault| with_file(fault.into(), &self.path))?;
        self.read_values(vector, range, &mut Values::Real(values))
    }

    /// Appends the values `range` of a vector as complex numbers.
    ///
    /// # Errors
    /// The vector is shorter, or the file cannot be read there.
    pub fn read_complex(
        &mut self,
        vector: &Vector,
        range: Range<u64>,
        values: &mut Vec<Complex64>,
    ) -> Result<(), SourceError> {
        self.read_values(vector, range, &mut Values::Complex(values))
    }

    fn read_values(
        &mut self,
        vector: &Vector,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let error = |error| with_file(error, &self.path);
        if range.end > vector.length {
            return Err(error(
                SourceFault::Range {
                    name: vector.name.clone(),
                    length: vector.length,
                    end: range.end,
                }
                .into(),
            ));
        }
        let count = range.end.saturating_sub(range.start);
        if count == 0 {
            return Ok(());
        }
        let before = values.len();
        self.reader
            .read(vector.array, &vector.place, range, values)
            .map_err(error)?;
        let appended = (values.len() - before) as u64;
        if appended != count {
            let place = format!("array `{}`", vector.name);
            let finding = format!("{appended} values are there of {count}");
            return Err(error(SourceError::damaged(place, finding)));
        }
        Ok(())
    }
}

fn with_file(error: SourceError, path: &Path) -> SourceError {
    SourceError {
        file: path.to_owned(),
        ..error
    }
}

fn require_real(element: Element, name: &str) -> Result<(), SourceFault> {
    if element.is_complex() {
        return Err(SourceFault::Complex {
            name: name.to_owned(),
        });
    }
    Ok(())
}

fn attribute(reader: &dyn ArrayReader, name: &str) -> Result<f64, SourceFault> {
    let plain = |name: &str| name.trim().trim_start_matches('/').to_owned();
    let attributes = reader.attributes();
    let found = attributes
        .iter()
        .find(|(other, _)| plain(other) == plain(name));
    match found {
        Some((_, Attribute::Number(value))) => Ok(*value),
        Some((_, Attribute::Text(text))) => number(name, text),
        None => Err(SourceFault::NoAttribute {
            name: name.to_owned(),
            names: name::nearest(attributes.keys().cloned(), name),
        }),
    }
}

fn number(name: &str, text: &str) -> Result<f64, SourceFault> {
    let value = text.trim().parse();
    value.map_err(|_| SourceFault::NotNumber {
        name: name.to_owned(),
        text: text.to_owned(),
    })
}

/// Bytes by which a format is found.
const HEAD_BYTES: u64 = 4096;

fn open_reader(path: &Path) -> Result<Box<dyn ArrayReader>, SourceError> {
    let mut file = bounded_files::open(path)?;
    let mut head = Vec::new();
    Read::by_ref(&mut file)
        .take(HEAD_BYTES)
        .read_to_end(&mut head)?;
    let kind = kind::find(&head, |offset, bytes| has_bytes(&mut file, offset, bytes))?;
    file.seek(SeekFrom::Start(0))?;
    match kind {
        Kind::Hdf5 => hdf5::open(file),
        Kind::Tdms => tdms::open(file),
        Kind::Matlab5 => matlab::MatlabReader::open(file),
        Kind::Matlab4 => matlab4::Matlab4Reader::open(file),
        Kind::Npy => npy::NpyReader::open(file),
        Kind::Zip => npz::NpzReader::open(file),
        Kind::Lvm => lvm::open(file, &head),
        Kind::Text => text::TextReader::open(file, &head),
        Kind::Wav => wave::WaveReader::open(file, &head),
        Kind::Flac => flac::FlacReader::open(file),
        Kind::Parquet => parquet_file::ParquetReader::open(file),
    }
}

/// Returns whether the file has the bytes at an offset.
fn has_bytes(file: &mut File, offset: u64, bytes: &[u8]) -> bool {
    let mut found = vec![0; bytes.len()];
    file.seek(SeekFrom::Start(offset)).is_ok()
        && file.read_exact(&mut found).is_ok()
        && found == bytes
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
