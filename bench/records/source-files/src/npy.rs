//! NumPy's arrays: `.npy` files, and the same bytes within a `.npz` archive.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::sync::Arc;

use file_sections::{Bytes, Section, Stride};
use npyz::{DType, Endianness, NpyHeader, Order, TimeUnits, TypeChar, TypeStr};

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values, strides};
use crate::numbers::{Encoding, NumberType};

/// Maximum bytes of a header.
const MOST_HEADER_BYTES: usize = 1 << 16;

/// Maximum depth of brackets in a header, which a parser descends.
const MOST_BRACKETS: usize = 24;

/// Maximum bytes of an array that is shown as text.
const MOST_TEXT_BYTES: u64 = 1 << 12;

/// One array of NumPy with the columns of its records, and where their elements are.
pub(crate) struct NpyArray {
    /// The columns: one for plain elements, one for each number of a record.
    pub(crate) columns: Vec<Column>,
    /// Offset of the first element.
    pub(crate) start: u64,
    /// Sentences for a user.
    pub(crate) notes: Vec<String>,
}

/// Elements of one array, or of one field of its records.
pub(crate) struct Column {
    pub(crate) info: ArrayInfo,
    /// Offset of the field in the first record, bytes.
    offset: u64,
    /// Distances along each axis, bytes.
    strides: Vec<u64>,
    kind: ColumnKind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ColumnKind {
    Real(Encoding),
    Complex(Encoding),
    /// Integer multiples of a unit of time, s.
    Time(Encoding, f64),
    /// Text of so many bytes, in characters of four bytes or of one.
    Text {
        bytes: u64,
        wide: Option<Encoding>,
    },
    Unread,
}

/// Bytes of a stream that counts them.
struct Counted<R> {
    source: R,
    count: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.source.read(buffer)?;
        self.count += count as u64;
        Ok(count)
    }
}

impl NpyArray {
    /// Reads the header of an array named `name`; `n_bytes` are the bytes of header and elements together.
    pub(crate) fn open(
        source: &mut dyn Bytes,
        name: &str,
        n_bytes: u64,
    ) -> Result<Self, SourceError> {
        let header_bytes = header_bytes(source, n_bytes)?;
        let mut header = vec![0; header_bytes];
        source
            .read_at(0, &mut header)
            .map_err(|_| damaged("the header ends early"))?;
        require_plain(&header)?;
        let mut counted = Counted {
            source: header.as_slice(),
            count: 0,
        };
        let parsed = NpyHeader::from_reader(&mut counted)
            .map_err(|_| damaged("the header is not the one of NumPy"))?;
        let start = counted.count;
        let shape = parsed.shape().to_vec();
        let present = n_bytes.saturating_sub(start);
        let mut notes = Vec::new();
        let shape = match parsed.dtype().num_bytes() {
            Some(item) => shape_present(
                shape,
                parsed.order(),
                item as u64,
                present,
                name,
                &mut notes,
            )?,
            None => shape,
        };
        let columns = columns(name, &parsed, &shape);
        Ok(Self {
            columns,
            start,
            notes,
        })
    }

    /// Appends the elements of a column.
    pub(crate) fn read(
        &self,
        source: &mut dyn Bytes,
        column: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let Some(column) = self.columns.get(column) else {
            return Ok(());
        };
        let (offset, step) = place.offset_and_step(&column.strides);
        let (encoding, count) = match column.kind {
            ColumnKind::Real(encoding) | ColumnKind::Time(encoding, _) => (encoding, 1),
            ColumnKind::Complex(encoding) => (encoding, 2),
            ColumnKind::Text { .. } | ColumnKind::Unread => return Ok(()),
        };
        let stride = Stride {
            offset: self.start + column.offset + offset + range.start.saturating_mul(step),
            step,
            bytes: count * encoding.number.bytes(),
            count: range.end - range.start,
        };
        let read = stride.visit(source, |bytes| match column.kind {
            ColumnKind::Complex(_) => values.push_complex(encoding.decode_complex(bytes)),
            ColumnKind::Time(_, unit_s) => values.push(seconds(encoding.decode(bytes), unit_s)),
            _ => values.push(encoding.decode(bytes)),
        });
        read.map_err(|(offset, error)| read_error(&column.info.name, offset, &error))
    }

    /// Returns the text of a column with a single short text.
    pub(crate) fn text(
        &self,
        source: &mut dyn Bytes,
        column: usize,
    ) -> Result<Option<String>, SourceError> {
        let Some(column) = self.columns.get(column) else {
            return Ok(None);
        };
        let ColumnKind::Text { bytes, wide } = column.kind else {
            return Ok(None);
        };
        if column.info.count() != 1 || bytes > MOST_TEXT_BYTES {
            return Ok(None);
        }
        let mut text = vec![0; bytes as usize];
        let offset = self.start + column.offset;
        source
            .read_at(offset, &mut text)
            .map_err(|error| read_error(&column.info.name, offset, &error))?;
        let characters: String = match wide {
            Some(encoding) => text
                .chunks_exact(4)
                .filter_map(|character| char::from_u32(encoding.decode(character) as u32))
                .collect(),
            None => String::from_utf8_lossy(&text).into_owned(),
        };
        Ok(Some(characters.trim_end_matches('\0').to_owned()))
    }
}

/// Returns the refusal of bytes of an array that cannot be read.
pub(crate) fn read_error(name: &str, offset: u64, error: &std::io::Error) -> SourceError {
    let place = match name {
        "" => format!("byte {offset}"),
        name => format!("array `{name}`, byte {offset} of it"),
    };
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => SourceError::damaged(place, "it ends early"),
        std::io::ErrorKind::InvalidInput | std::io::ErrorKind::InvalidData => {
            SourceError::damaged(place, "its compressed bytes contradict themselves")
        }
        _ => SourceError::at(
            place,
            crate::error::SourceFault::System {
                cause: bounded_files::cause(error),
            },
        ),
    }
}

fn damaged(finding: &str) -> SourceError {
    SourceError::damaged("byte 0", finding)
}

/// Returns the bytes of the header, the magic ones included.
fn header_bytes(source: &mut dyn Bytes, n_bytes: u64) -> Result<usize, SourceError> {
    let mut start = [0; 12];
    let most = n_bytes.min(12) as usize;
    source
        .read_at(0, &mut start[..most])
        .map_err(|_| damaged("the header ends early"))?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err(damaged("it does not begin as an array of NumPy does"));
    }
    let length = match start[6] {
        1 => 10 + usize::from(u16::from_le_bytes([start[8], start[9]])),
        _ => 12usize.saturating_add(
            u32::from_le_bytes([start[8], start[9], start[10], start[11]]) as usize,
        ),
    };
    if length > MOST_HEADER_BYTES {
        return Err(damaged("its header is longer than any of NumPy"));
    }
    if length as u64 > n_bytes {
        return Err(damaged("the header ends early"));
    }
    Ok(length)
}

/// Requires that the header has no deep brackets, and no shape of more elements than can be counted.
fn require_plain(header: &[u8]) -> Result<(), SourceError> {
    let mut depth = 0usize;
    for byte in header {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MOST_BRACKETS {
            return Err(damaged("its header has brackets deeper than any of NumPy"));
        }
    }
    // All numbers of the header multiplied are an upper bound of its sizes.
    let text = String::from_utf8_lossy(header);
    let numbers = text.split(|c: char| !c.is_ascii_digit());
    let numbers = numbers.filter(|digits| !digits.is_empty());
    let mut product = 1u64;
    for number in numbers {
        let number: u64 = number.parse().unwrap_or(u64::MAX);
        product = product
            .checked_mul(number.max(1))
            .ok_or_else(|| damaged("its shape has more elements than any file"))?;
    }
    Ok(())
}

/// Returns the shape of the elements that are there: cut along the first axis where the end of the file is missing.
fn shape_present(
    shape: Vec<u64>,
    order: Order,
    item: u64,
    present: u64,
    name: &str,
    notes: &mut Vec<String>,
) -> Result<Vec<u64>, SourceError> {
    let needed = shape
        .iter()
        .fold(item, |bytes: u64, length| bytes.saturating_mul(*length));
    if needed <= present {
        return Ok(shape);
    }
    let row: u64 = shape
        .iter()
        .skip(1)
        .fold(item, |bytes: u64, length| bytes.saturating_mul(*length));
    let is_by_rows = order == Order::C || shape.len() == 1;
    let place = match name {
        "" => "its end".to_owned(),
        name => format!("array `{name}`"),
    };
    if !is_by_rows || shape.is_empty() || present < row {
        let finding = format!("{present} bytes of elements are there of {needed}");
        return Err(SourceError::damaged(place, finding));
    }
    let rows = present / row;
    let mut shape = shape;
    notes.push(format!(
        "{place}: the file ends early: {rows} of {} rows are there and are read",
        shape[0]
    ));
    shape[0] = rows;
    Ok(shape)
}

/// Returns the columns of an array.
fn columns(name: &str, header: &NpyHeader, shape: &[u64]) -> Vec<Column> {
    let dtype = header.dtype();
    let item = dtype.num_bytes().unwrap_or(0) as u64;
    let is_column_major = header.order() == Order::Fortran;
    let strides = strides(shape, item, is_column_major);
    let mut columns = Vec::new();
    add(&mut columns, name, &dtype, 0, shape, &strides);
    columns
}

fn add(
    columns: &mut Vec<Column>,
    name: &str,
    dtype: &DType,
    offset: u64,
    shape: &[u64],
    strides: &[u64],
) {
    match dtype {
        DType::Plain(ty) => {
            let (kind, info) = plain(name, ty, shape);
            columns.push(Column {
                info,
                offset,
                strides: strides.to_vec(),
                kind,
            });
        }
        DType::Array(length, inner) => {
            let shape = [shape, &[*length]].concat();
            let step = inner.num_bytes().unwrap_or(0) as u64;
            let strides = [strides, &[step]].concat();
            add(columns, name, inner, offset, &shape, &strides);
        }
        DType::Record(fields) => {
            let mut offset = offset;
            for field in fields {
                let full = match name {
                    "" => field.name.clone(),
                    name => format!("{name}.{}", field.name),
                };
                // Bytes that align the fields have no name.
                if !field.name.is_empty() {
                    add(columns, &full, &field.dtype, offset, shape, strides);
                }
                offset = offset.saturating_add(field.dtype.num_bytes().unwrap_or(0) as u64);
            }
        }
    }
}

/// Returns how the elements of a plain type are read.
fn plain(name: &str, ty: &TypeStr, shape: &[u64]) -> (ColumnKind, ArrayInfo) {
    let encoding = |number| Encoding {
        number,
        is_big_endian: ty.endianness() == Endianness::Big,
    };
    let number = match (ty.type_char(), ty.size_field()) {
        (TypeChar::Bool, 1) | (TypeChar::Uint, 1) => Some(NumberType::U8),
        (TypeChar::Int, 1) => Some(NumberType::I8),
        (TypeChar::Int, 2) => Some(NumberType::I16),
        (TypeChar::Int, 4) => Some(NumberType::I32),
        (TypeChar::Int | TypeChar::DateTime | TypeChar::TimeDelta, 8) => Some(NumberType::I64),
        (TypeChar::Uint, 2) => Some(NumberType::U16),
        (TypeChar::Uint, 4) => Some(NumberType::U32),
        (TypeChar::Uint, 8) => Some(NumberType::U64),
        (TypeChar::Float, 2) => Some(NumberType::F16),
        (TypeChar::Float, 4) | (TypeChar::Complex, 8) => Some(NumberType::F32),
        (TypeChar::Float, 8) | (TypeChar::Complex, 16) => Some(NumberType::F64),
        _ => None,
    };
    let array = |element| ArrayInfo::new(name, element, shape.to_vec());
    let unread = |class: String| {
        let info = ArrayInfo {
            unreadable: Some(class),
            ..array(Element::Opaque)
        };
        (ColumnKind::Unread, info)
    };
    match (ty.type_char(), number) {
        (TypeChar::Bool, Some(number)) => {
            (ColumnKind::Real(encoding(number)), array(Element::Logical))
        }
        (TypeChar::DateTime | TypeChar::TimeDelta, Some(number)) => {
            match ty.time_units().and_then(unit_s) {
                Some(unit_s) => (
                    ColumnKind::Time(encoding(number), unit_s),
                    array(Element::Time),
                ),
                None => unread(format!("NumPy's {ty}")),
            }
        }
        (TypeChar::Complex, Some(number)) => (
            ColumnKind::Complex(encoding(number)),
            array(number.element(true)),
        ),
        (_, Some(number)) => (
            ColumnKind::Real(encoding(number)),
            array(number.element(false)),
        ),
        (TypeChar::ByteStr | TypeChar::UnicodeStr, None) => {
            let is_wide = ty.type_char() == TypeChar::UnicodeStr;
            let bytes = ty.num_bytes().unwrap_or(0) as u64;
            let wide = is_wide.then(|| encoding(NumberType::U32));
            (ColumnKind::Text { bytes, wide }, array(Element::Text))
        }
        (TypeChar::Object, None) => unread("object of Python, pickled".to_owned()),
        _ => unread(format!("NumPy's {ty}")),
    }
}

/// Returns a unit of time in seconds; `None` for those of varying length.
fn unit_s(unit: TimeUnits) -> Option<f64> {
    Some(match unit.to_str() {
        "W" => 604_800.0,
        "D" => 86_400.0,
        "h" => 3600.0,
        "m" => 60.0,
        "s" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        _ => return None,
    })
}

/// Returns a time in seconds; NumPy's "not a time" is NaN.
fn seconds(count: f64, unit_s: f64) -> f64 {
    if count == i64::MIN as f64 {
        return f64::NAN;
    }
    // One rounding for units below a second.
    if unit_s < 1.0 {
        count / (1.0 / unit_s).round()
    } else {
        count * unit_s
    }
}

/// Reader of a `.npy` file.
pub(crate) struct NpyReader {
    section: Section,
    array: NpyArray,
    arrays: Vec<ArrayInfo>,
    attributes: BTreeMap<String, Attribute>,
}

impl NpyReader {
    /// Opens a file that begins as NumPy's arrays do.
    pub(crate) fn open(file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
        let n_bytes = file.metadata()?.len();
        let mut section = Section::new(Arc::new(file), 0, n_bytes);
        let array = NpyArray::open(&mut section, "", n_bytes)?;
        let arrays = array.columns.iter().map(|column| column.info.clone());
        Ok(Box::new(Self {
            arrays: arrays.collect(),
            section,
            array,
            attributes: BTreeMap::new(),
        }))
    }
}

impl ArrayReader for NpyReader {
    fn format(&self) -> Format {
        Format::Npy
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn notes(&self) -> &[String] {
        &self.array.notes
    }

    fn text(&mut self, index: usize) -> Result<Option<String>, SourceError> {
        self.array.text(&mut self.section, index)
    }

    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        self.array
            .read(&mut self.section, index, place, range, values)
    }
}
