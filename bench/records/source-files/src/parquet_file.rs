//! Parquet: columns read by stretches, page by page.

mod arrow_durations;
mod strict_end;

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;

use decoder_panics::guarded;
use parquet::basic::{Compression, ConvertedType, LogicalType, TimeUnit, Type as PhysicalType};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, Int96};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;
use strict_end::StrictFile;

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values};
use crate::numbers::{Encoding, NumberType};

/// Number of columns that are kept open.
const MOST_OPEN: usize = 8;

/// Rows decoded at once.
const BATCH_ROWS: usize = 1 << 14;

/// Days of a date before 1970 in the calendar of `INT96` times.
const JULIAN_1970: f64 = 2_440_588.0;

const DAY_S: f64 = 86_400.0;

/// Remedy for compressions that are not read.
const CODEC_REMEDY: &str = "save the file with compression=\"snappy\" or \"gzip\", or without";

/// Reader of a Parquet file.
pub(crate) struct ParquetReader {
    file: SerializedFileReader<StrictFile>,
    /// First row of each group, and the number of all rows.
    starts: Vec<u64>,
    arrays: Vec<ArrayInfo>,
    /// Leaf of the schema and meaning of the numbers of each array.
    leaves: Vec<(usize, Meaning)>,
    open: Vec<OpenColumn>,
    attributes: BTreeMap<String, Attribute>,
}

/// Column that is read at a row.
struct OpenColumn {
    leaf: usize,
    group: usize,
    /// Next row within the group.
    row: u64,
    reader: ColumnReader,
    /// Level at which a value is there.
    level: i16,
}

/// Meaning of stored numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Meaning {
    /// The numbers themselves.
    Plain,
    /// Integers without sign.
    Unsigned,
    /// Multiples of a fraction: 1 / so many.
    Fraction(f64),
    /// Multiples.
    Multiple(f64),
    /// Floats of 16 bits.
    Half,
    /// Times of the older kind.
    Int96,
    /// Values that are not read.
    Unread,
}

impl ParquetReader {
    /// Opens a file that begins as Parquet does.
    pub(crate) fn open(file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
        let file = StrictFile::new(file)?;
        let opened = guarded(|| SerializedFileReader::new(file));
        let Some(Ok(file)) = opened else {
            return Err(SourceError::damaged(
                "its end",
                "the directory of its columns is missing or contradicts itself",
            ));
        };
        let metadata = file.metadata();
        let mut starts = vec![0u64];
        for group in metadata.row_groups() {
            let rows = u64::try_from(group.num_rows()).unwrap_or(0);
            starts.push(starts[starts.len() - 1].saturating_add(rows));
        }
        let rows = starts[starts.len() - 1];
        let (mut arrays, mut leaves) = (Vec::new(), Vec::new());
        let pairs = metadata.file_metadata().key_value_metadata();
        let pairs = pairs.map_or(&[][..], |pairs| pairs.as_slice()).iter();
        let schema = pairs.filter(|pair| pair.key == arrow_durations::KEY);
        let durations: Vec<(String, f64)> = schema
            .filter_map(|pair| pair.value.as_deref())
            .flat_map(arrow_durations::durations)
            .collect();
        for (leaf, column) in metadata
            .file_metadata()
            .schema_descr()
            .columns()
            .iter()
            .enumerate()
        {
            let name = column.path().string();
            let chunks = metadata
                .row_groups()
                .iter()
                .filter_map(|group| group.columns().get(leaf));
            let codec = chunks
                .map(|chunk| chunk.compression())
                .find(|codec| !is_read(*codec));
            let (element, meaning) = match codec {
                None => meaning(column),
                Some(_) => (Element::Opaque, Meaning::Unread),
            };
            let duration = durations.iter().find(|(column, _)| *column == name);
            let is_integer = column.physical_type() == PhysicalType::INT64;
            let (element, meaning) = match duration {
                Some((_, parts)) if is_integer && codec.is_none() => {
                    (Element::Time, Meaning::Fraction(*parts))
                }
                _ => (element, meaning),
            };
            let info = match codec {
                Some(codec) => {
                    let content = format!("a column compressed by {}", codec_name(codec));
                    ArrayInfo::unread(name, &content, CODEC_REMEDY)
                }
                None => ArrayInfo {
                    unreadable: (element == Element::Opaque).then(|| class(column)),
                    ..ArrayInfo::new(name, element, Vec::new())
                },
            };
            arrays.push(ArrayInfo {
                shape: vec![rows],
                ..info
            });
            leaves.push((leaf, meaning));
        }
        Ok(Box::new(Self {
            file,
            starts,
            arrays,
            leaves,
            open: Vec::new(),
            attributes: BTreeMap::new(),
        }))
    }

    /// Returns a column at a row of a group; it is taken from those that are open.
    fn column(&mut self, leaf: usize, group: usize, row: u64) -> Option<OpenColumn> {
        let is_before =
            |open: &OpenColumn| (open.leaf, open.group) == (leaf, group) && open.row <= row;
        let mut open = match self.open.iter().position(is_before) {
            Some(place) => self.open.remove(place),
            None => {
                let reader = guarded(|| self.file.get_row_group(group)?.get_column_reader(leaf));
                let schema = self.file.metadata().file_metadata().schema_descr();
                OpenColumn {
                    leaf,
                    group,
                    row: 0,
                    reader: reader?.ok()?,
                    level: schema.column(leaf).max_def_level(),
                }
            }
        };
        let gap = usize::try_from(row - open.row).ok()?;
        let skipped = guarded(|| open.skip(gap))??;
        open.row += skipped as u64;
        (skipped == gap).then_some(open)
    }
}

/// Calls a function of the column's reader, of any type.
macro_rules! typed {
    ($reader:expr, $typed:ident => $call:expr) => {
        match $reader {
            ColumnReader::BoolColumnReader($typed) => $call,
            ColumnReader::Int32ColumnReader($typed) => $call,
            ColumnReader::Int64ColumnReader($typed) => $call,
            ColumnReader::Int96ColumnReader($typed) => $call,
            ColumnReader::FloatColumnReader($typed) => $call,
            ColumnReader::DoubleColumnReader($typed) => $call,
            ColumnReader::ByteArrayColumnReader($typed) => $call,
            ColumnReader::FixedLenByteArrayColumnReader($typed) => $call,
        }
    };
}

impl OpenColumn {
    /// Passes over rows; returns their number.
    fn skip(&mut self, rows: usize) -> Option<usize> {
        if rows == 0 {
            return Some(0);
        }
        typed!(&mut self.reader, reader => reader.skip_records(rows).ok())
    }

    /// Reads the next rows, at most `rows`; NaN for those without a value.
    fn read(&mut self, rows: usize, meaning: Meaning) -> Option<Vec<f64>> {
        let level = self.level;
        match &mut self.reader {
            ColumnReader::BoolColumnReader(reader) => {
                numbers(reader, level, rows, |value| f64::from(u8::from(*value)))
            }
            ColumnReader::Int32ColumnReader(reader) => numbers(reader, level, rows, |value| {
                meaning.of_integer(i64::from(*value), i64::from(*value as u32))
            }),
            ColumnReader::Int64ColumnReader(reader) => {
                numbers(reader, level, rows, |value| match meaning {
                    Meaning::Unsigned => *value as u64 as f64,
                    meaning => meaning.of_integer(*value, *value),
                })
            }
            ColumnReader::Int96ColumnReader(reader) => numbers(reader, level, rows, int96_s),
            ColumnReader::FloatColumnReader(reader) => {
                numbers(reader, level, rows, |value| f64::from(*value))
            }
            ColumnReader::DoubleColumnReader(reader) => {
                numbers(reader, level, rows, |value| *value)
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader)
                if matches!(meaning, Meaning::Fraction(_)) =>
            {
                numbers(reader, level, rows, |value| meaning.of_bytes(value.data()))
            }
            ColumnReader::FixedLenByteArrayColumnReader(reader) => {
                let half = Encoding {
                    number: NumberType::F16,
                    is_big_endian: false,
                };
                numbers(reader, level, rows, |value| half.decode(value.data()))
            }
            ColumnReader::ByteArrayColumnReader(reader) => {
                numbers(reader, level, rows, |value| meaning.of_bytes(value.data()))
            }
        }
    }
}

impl Meaning {
    fn of_integer(self, signed: i64, unsigned: i64) -> f64 {
        match self {
            Self::Unsigned => unsigned as f64,
            Self::Fraction(parts) => signed as f64 / parts,
            Self::Multiple(factor) => signed as f64 * factor,
            _ => signed as f64,
        }
    }

    /// Returns the value of an integer of any length, its highest byte first.
    fn of_bytes(self, bytes: &[u8]) -> f64 {
        let [first, rest @ ..] = bytes else {
            return f64::NAN;
        };
        let highest = f64::from(i8::from_be_bytes([*first]));
        let number = rest
            .iter()
            .fold(highest, |number, byte| number * 256.0 + f64::from(*byte));
        match self {
            Self::Fraction(parts) => number / parts,
            _ => number,
        }
    }
}

/// Reads rows as numbers; NaN where a value is missing.
fn numbers<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    level: i16,
    rows: usize,
    number: impl Fn(&T::T) -> f64,
) -> Option<Vec<f64>> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let (n_rows, ..) = reader
        .read_records(rows, Some(&mut levels), None, &mut values)
        .ok()?;
    let mut present = values.iter().map(number);
    if level == 0 {
        return Some(present.collect());
    }
    let row = |row_level: &i16| match *row_level == level {
        true => present.next(),
        false => Some(f64::NAN),
    };
    levels.iter().take(n_rows).map(row).collect()
}

/// Returns a time of the older kind in seconds since 1970: nanoseconds of a day, and the day.
fn int96_s(value: &Int96) -> f64 {
    let &[low, high, day] = value.data() else {
        return f64::NAN;
    };
    let nanoseconds = u64::from(high) << 32 | u64::from(low);
    (f64::from(day) - JULIAN_1970) * DAY_S + nanoseconds as f64 / 1e9
}

/// Returns the name of a compression.
fn codec_name(codec: Compression) -> &'static str {
    match codec {
        Compression::ZSTD(_) => "Zstandard",
        Compression::BROTLI(_) => "Brotli",
        Compression::LZ4 | Compression::LZ4_RAW => "LZ4",
        Compression::LZO => "LZO",
        Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::GZIP(_) => "a known codec",
    }
}

fn is_read(codec: Compression) -> bool {
    matches!(
        codec,
        Compression::UNCOMPRESSED | Compression::SNAPPY | Compression::GZIP(_)
    )
}

/// Returns how a column's numbers are read.
fn meaning(column: &ColumnDescriptor) -> (Element, Meaning) {
    if column.max_rep_level() > 0 {
        return (Element::Opaque, Meaning::Unread);
    }
    let time = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1e3,
        TimeUnit::MICROS => 1e6,
        TimeUnit::NANOS => 1e9,
    };
    let logical = column.logical_type_ref();
    match logical {
        Some(LogicalType::Timestamp(kind)) => {
            return (Element::Time, Meaning::Fraction(time(&kind.unit)));
        }
        Some(LogicalType::Time(kind)) => {
            return (Element::Time, Meaning::Fraction(time(&kind.unit)));
        }
        Some(LogicalType::Date) => return (Element::Time, Meaning::Multiple(DAY_S)),
        Some(LogicalType::Float16) => return (Element::Float { bits: 16 }, Meaning::Half),
        Some(LogicalType::Integer(kind)) => {
            let element = Element::Integer {
                bits: kind.bit_width as u8,
                is_signed: kind.is_signed,
            };
            let meaning = match kind.is_signed {
                true => Meaning::Plain,
                false => Meaning::Unsigned,
            };
            return (element, meaning);
        }
        _ => {}
    }
    match column.converted_type() {
        ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS => {
            return (Element::Time, Meaning::Fraction(1e3));
        }
        ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS => {
            return (Element::Time, Meaning::Fraction(1e6));
        }
        _ => {}
    }
    let is_decimal = matches!(logical, Some(LogicalType::Decimal { .. }))
        || column.converted_type() == ConvertedType::DECIMAL;
    let decimal = || Meaning::Fraction(10f64.powi(column.type_scale()));
    match column.physical_type() {
        PhysicalType::BOOLEAN => (Element::Logical, Meaning::Plain),
        PhysicalType::FLOAT => (Element::Float { bits: 32 }, Meaning::Plain),
        PhysicalType::DOUBLE => (Element::Float { bits: 64 }, Meaning::Plain),
        PhysicalType::INT96 => (Element::Time, Meaning::Int96),
        _ if is_decimal => (Element::Float { bits: 64 }, decimal()),
        PhysicalType::INT32 => (NumberType::I32.element(false), Meaning::Plain),
        PhysicalType::INT64 => (NumberType::I64.element(false), Meaning::Plain),
        PhysicalType::BYTE_ARRAY => (Element::Text, Meaning::Unread),
        _ => (Element::Opaque, Meaning::Unread),
    }
}

/// Returns the class of a column that is not read.
fn class(column: &ColumnDescriptor) -> String {
    match column.max_rep_level() {
        0 => format!("column of {}", column.physical_type()),
        _ => "column of lists".to_owned(),
    }
}

impl ArrayReader for ParquetReader {
    fn format(&self) -> Format {
        Format::Parquet
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn read(
        &mut self,
        index: usize,
        _place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let Some(&(leaf, meaning)) = self.leaves.get(index) else {
            return Ok(());
        };
        let mut row = range.start;
        while row < range.end {
            let undecoded = |name: &str| {
                let place = format!("row {row}, column `{name}`");
                SourceError::damaged(place, "the rows from here on cannot be decoded")
            };
            let group = self.starts.partition_point(|start| *start <= row) - 1;
            let end = range.end.min(self.starts[group + 1]);
            let Some(mut column) = self.column(leaf, group, row - self.starts[group]) else {
                return Err(undecoded(&self.arrays[index].name));
            };
            let wanted = BATCH_ROWS.min((end - row) as usize);
            let read = guarded(|| column.read(wanted, meaning)).flatten();
            let Some(numbers) = read.filter(|numbers| numbers.len() == wanted) else {
                return Err(undecoded(&self.arrays[index].name));
            };
            column.row += wanted as u64;
            row += wanted as u64;
            for number in numbers {
                values.push(number);
            }
            if self.open.len() >= MOST_OPEN {
                self.open.remove(0);
            }
            self.open.push(column);
        }
        Ok(())
    }
}
