//! MATLAB v4: matrices one after the other, each with a header of 20 bytes.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::sync::Arc;

use file_sections::{Bytes, Section, Stride};
use num_complex::Complex64;

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values, strides};
use crate::npy::read_error;
use crate::numbers::{Encoding, NumberType};

/// Bytes of a header.
const HEADER_BYTES: u64 = 20;

/// Maximum bytes of a name.
const MOST_NAME_BYTES: u64 = 256;

/// Maximum number of matrices.
const MOST_MATRICES: usize = 100_000;

/// Maximum characters of a matrix that is read as text.
const MOST_CHARACTERS: u64 = 1 << 16;

/// Reader of a file of MATLAB v4.
pub(crate) struct Matlab4Reader {
    file: Section,
    arrays: Vec<ArrayInfo>,
    contents: Vec<Content>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
}

/// Numbers of a matrix.
#[derive(Debug, Clone, Copy)]
struct Content {
    offset: u64,
    encoding: Encoding,
    /// Bytes of the real parts.
    bytes: u64,
    is_complex: bool,
}

/// Header of a matrix.
struct Header {
    encoding: Encoding,
    /// Numbers, text, or sparse.
    kind: u32,
    rows: u64,
    columns: u64,
    is_complex: bool,
    name_bytes: u64,
}

impl Matlab4Reader {
    /// Opens a file that begins with a header of MATLAB v4.
    pub(crate) fn open(file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
        let file_bytes = file.metadata()?.len();
        let mut reader = Self {
            file: Section::new(Arc::new(file), 0, file_bytes),
            arrays: Vec::new(),
            contents: Vec::new(),
            attributes: BTreeMap::new(),
            notes: Vec::new(),
        };
        let mut offset = 0;
        while offset < file_bytes && reader.arrays.len() < MOST_MATRICES {
            offset = match reader.matrix(offset, file_bytes)? {
                Some(next) => next,
                None => break,
            };
        }
        Ok(Box::new(reader))
    }

    /// Reads the header of the matrix at an offset; returns the offset of the next one, `None` for one that is cut off.
    fn matrix(&mut self, offset: u64, file_bytes: u64) -> Result<Option<u64>, SourceError> {
        let place = format!("byte {offset}");
        let mut bytes = [0; HEADER_BYTES as usize];
        if offset + HEADER_BYTES > file_bytes {
            self.note_cut(offset);
            return Ok(None);
        }
        self.file.read_at(offset, &mut bytes)?;
        let header = Header::read(&bytes)
            .ok_or_else(|| SourceError::damaged(&place, "the header of a matrix is impossible"))?;
        let mut name = vec![0; header.name_bytes as usize];
        let start = offset + HEADER_BYTES + header.name_bytes;
        let size = header.encoding.number.bytes() as u64;
        let real_bytes = (header.rows * header.columns).saturating_mul(size);
        let parts = if header.is_complex { 2 } else { 1 };
        let end = start.saturating_add(real_bytes.saturating_mul(parts));
        if end > file_bytes {
            self.note_cut(offset);
            return Ok(None);
        }
        self.file.read_at(offset + HEADER_BYTES, &mut name)?;
        let name = String::from_utf8_lossy(&name);
        let name = name.split('\0').next().unwrap_or_default();
        let shape = vec![header.rows, header.columns];
        self.arrays.push(match header.kind {
            0 => ArrayInfo::new(
                name,
                header.encoding.number.element(header.is_complex),
                shape,
            ),
            1 => ArrayInfo::new(name, Element::Text, shape),
            _ => ArrayInfo::opaque(name, "sparse matrix"),
        });
        self.contents.push(Content {
            offset: start,
            encoding: header.encoding,
            bytes: real_bytes,
            is_complex: header.is_complex,
        });
        Ok(Some(end))
    }

    fn note_cut(&mut self, offset: u64) {
        self.notes.push(format!(
            "the file ends within the matrix that begins at byte {offset}; it is left out"
        ));
    }
}

impl Header {
    fn read(bytes: &[u8; HEADER_BYTES as usize]) -> Option<Self> {
        let words = |is_big_endian: bool| {
            let word = |bytes: &[u8; 4]| match is_big_endian {
                true => u32::from_be_bytes(*bytes),
                false => u32::from_le_bytes(*bytes),
            };
            let (words, _) = bytes.as_chunks::<4>();
            words.iter().map(word).collect::<Vec<u32>>()
        };
        let little = words(false);
        let is_big_endian = little[0] > 9999;
        let [kind, rows, columns, imaginary, name_bytes] = words(is_big_endian)[..] else {
            return None;
        };
        let number = match kind / 10 % 10 {
            0 => NumberType::F64,
            1 => NumberType::F32,
            2 => NumberType::I32,
            3 => NumberType::I16,
            4 => NumberType::U16,
            5 => NumberType::U8,
            _ => return None,
        };
        let is_ieee = kind / 1000 == u32::from(is_big_endian);
        let is_plausible = is_ieee
            && kind / 100 % 10 == 0
            && kind % 10 <= 2
            && rows <= i32::MAX as u32
            && columns <= i32::MAX as u32
            && imaginary <= 1
            && u64::from(name_bytes) <= MOST_NAME_BYTES;
        is_plausible.then_some(Self {
            encoding: Encoding {
                number,
                is_big_endian,
            },
            kind: kind % 10,
            rows: rows.into(),
            columns: columns.into(),
            is_complex: imaginary == 1,
            name_bytes: name_bytes.into(),
        })
    }
}

impl ArrayReader for Matlab4Reader {
    fn format(&self) -> Format {
        Format::Matlab4
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
        let (Some(content), Some(info)) = (self.contents.get(index), self.arrays.get(index)) else {
            return Ok(None);
        };
        let is_line = info.element == Element::Text && info.shape.first() == Some(&1);
        if !is_line || info.count() > MOST_CHARACTERS {
            return Ok(None);
        }
        let mut bytes = vec![0; content.bytes as usize];
        self.file.read_at(content.offset, &mut bytes)?;
        let codes = bytes.chunks_exact(content.encoding.number.bytes());
        let characters = codes.map(|code| char::from_u32(content.encoding.decode(code) as u32));
        Ok(characters.collect())
    }

    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let (Some(&content), Some(info)) = (self.contents.get(index), self.arrays.get(index))
        else {
            return Ok(());
        };
        let size = content.encoding.number.bytes();
        let (offset, step) = place.offset_and_step(&strides(&info.shape, size as u64, true));
        let stride = Stride {
            offset: content.offset + offset + range.start.saturating_mul(step),
            step,
            bytes: size,
            count: range.end - range.start,
        };
        let failed =
            |(offset, error): (u64, std::io::Error)| read_error(&info.name, offset, &error);
        if !content.is_complex {
            let push = |bytes: &[u8]| values.push(content.encoding.decode(bytes));
            return stride.visit(&mut self.file, push).map_err(failed);
        }
        let (mut re, mut im) = (Vec::new(), Vec::new());
        let imaginary = Stride {
            offset: stride.offset + content.bytes,
            ..stride
        };
        let push = |bytes: &[u8]| re.push(content.encoding.decode(bytes));
        stride.visit(&mut self.file, push).map_err(failed)?;
        let push = |bytes: &[u8]| im.push(content.encoding.decode(bytes));
        imaginary.visit(&mut self.file, push).map_err(failed)?;
        for (re, im) in re.into_iter().zip(im) {
            values.push_complex(Complex64::new(re, im));
        }
        Ok(())
    }
}
