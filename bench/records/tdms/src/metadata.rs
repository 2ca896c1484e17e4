//! The metadata of a segment: objects, their properties, and how their samples are stored.

use crate::bytes::Bytes;
use crate::value::{SampleType, Value};

const NO_SAMPLES: u32 = 0xffff_ffff;
const AS_BEFORE: u32 = 0;
/// Format-changing scalers of DAQmx; the second as some writers order its bytes.
const DAQMX_FORMAT: [u32; 2] = [0x0000_1269, 0x6912_0000];
/// Digital lines of DAQmx: as files have the mark, as the note states it, and both with the bytes exchanged.
const DAQMX_LINES: [u32; 4] = [0x0000_126a, 0x0000_1369, 0x6a12_0000, 0x6913_0000];

/// How an object's samples in a chunk are stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Storage {
    /// Samples of one type; for text the size of a chunk, bytes.
    Plain {
        sample_type: SampleType,
        values: u64,
        text_bytes: u64,
    },
    /// Rows of a task's buffers.
    Daqmx {
        values: u64,
        scalers: Vec<Scaler>,
        /// Bytes of a row of each buffer.
        row_bytes: Vec<u64>,
    },
}

impl Storage {
    pub fn values(&self) -> u64 {
        match self {
            Self::Plain { values, .. } | Self::Daqmx { values, .. } => *values,
        }
    }
}

/// Place of a channel's integers in the rows of a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Scaler {
    pub sample_type: SampleType,
    pub buffer: usize,
    /// From the row's begin: bytes, or bits of a digital line.
    pub offset: u64,
    pub is_line: bool,
    pub scale_id: u32,
}

/// What the metadata say of an object's samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Samples {
    None,
    AsBefore,
    Stored(Storage),
}

/// An object that is listed in a segment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ListedObject {
    pub path: String,
    pub samples: Samples,
    pub properties: Vec<(String, Value)>,
}

/// Reads the metadata of a segment.
///
/// # Errors
/// A description of the defect and its place in the metadata, bytes.
pub(crate) fn read(bytes: &[u8], is_big_endian: bool) -> Result<Vec<ListedObject>, (u64, String)> {
    let mut bytes = Bytes::new(bytes, is_big_endian);
    match objects(&mut bytes) {
        Ok(Some(objects)) => Ok(objects),
        Ok(None) => Err((bytes.position(), "the metadata end too early".to_owned())),
        Err(defect) => Err((bytes.position(), defect)),
    }
}

type Read<T> = Result<Option<T>, String>;

/// Returns from the enclosing function where the bytes end.
macro_rules! present {
    ($read:expr) => {
        match $read {
            Some(value) => value,
            None => return Ok(None),
        }
    };
}

fn objects(bytes: &mut Bytes<'_>) -> Read<Vec<ListedObject>> {
    let count = present!(bytes.u32());
    let mut objects = Vec::new();
    for _ in 0..count {
        let path = present!(bytes.text());
        let samples = present!(samples(bytes)?);
        let property_count = present!(bytes.u32());
        let mut properties = Vec::new();
        for _ in 0..property_count {
            let name = present!(bytes.text());
            let sample_type = SampleType::from_code(present!(bytes.u32()));
            if sample_type.size().is_none() && sample_type != SampleType::Text {
                return Err(format!("property \"{name}\" of {path} is {sample_type}"));
            }
            properties.push((name, present!(Value::read(sample_type, bytes))));
        }
        objects.push(ListedObject {
            path,
            samples,
            properties,
        });
    }
    Ok(Some(objects))
}

fn samples(bytes: &mut Bytes<'_>) -> Read<Samples> {
    let index = present!(bytes.u32());
    let storage = match index {
        NO_SAMPLES => return Ok(Some(Samples::None)),
        AS_BEFORE => return Ok(Some(Samples::AsBefore)),
        _ if DAQMX_FORMAT.contains(&index) => present!(daqmx(bytes, false)?),
        _ if DAQMX_LINES.contains(&index) => present!(daqmx(bytes, true)?),
        _ => present!(plain(bytes)?),
    };
    Ok(Some(Samples::Stored(storage)))
}

fn require_vector(dimension: u32) -> Result<(), String> {
    if dimension == 1 {
        Ok(())
    } else {
        Err(format!("samples of {dimension} dimensions; TDMS knows one"))
    }
}

fn plain(bytes: &mut Bytes<'_>) -> Read<Storage> {
    let sample_type = SampleType::from_code(present!(bytes.u32()));
    require_vector(present!(bytes.u32()))?;
    let values = present!(bytes.u64());
    let text_bytes = match sample_type {
        SampleType::Text => present!(bytes.u64()),
        _ => 0,
    };
    Ok(Some(Storage::Plain {
        sample_type,
        values,
        text_bytes,
    }))
}

fn daqmx(bytes: &mut Bytes<'_>, is_line: bool) -> Read<Storage> {
    let _sample_type = present!(bytes.u32());
    require_vector(present!(bytes.u32()))?;
    let values = present!(bytes.u64());
    let scaler_count = present!(bytes.u32());
    let mut scalers = Vec::new();
    for _ in 0..scaler_count {
        let sample_type = daqmx_type(present!(bytes.u32()));
        let buffer = present!(bytes.u32()) as usize;
        let offset = u64::from(present!(bytes.u32()));
        // A bitmap of the sample's format; of a line one byte.
        present!(bytes.take(if is_line { 1 } else { 4 }));
        scalers.push(Scaler {
            sample_type,
            buffer,
            offset,
            is_line,
            scale_id: present!(bytes.u32()),
        });
    }
    let buffer_count = present!(bytes.u32());
    if u64::from(buffer_count) * 4 > bytes.remaining() {
        return Ok(None);
    }
    let mut row_bytes = Vec::new();
    for _ in 0..buffer_count {
        row_bytes.push(u64::from(present!(bytes.u32())));
    }
    for scaler in &scalers {
        let size = scaler.sample_type.size().unwrap_or(0);
        let first = if scaler.is_line {
            scaler.offset / 8
        } else {
            scaler.offset
        };
        let fits = row_bytes
            .get(scaler.buffer)
            .is_some_and(|row| first + size <= *row);
        if !fits {
            return Err("a DAQmx scaler lies outside its buffer".to_owned());
        }
    }
    Ok(Some(Storage::Daqmx {
        values,
        scalers,
        row_bytes,
    }))
}

/// Returns the type of DAQmx's own number for it.
fn daqmx_type(code: u32) -> SampleType {
    match code {
        0 => SampleType::U8,
        1 => SampleType::I8,
        2 => SampleType::U16,
        3 => SampleType::I16,
        4 => SampleType::U32,
        5 => SampleType::I32,
        6 => SampleType::U64,
        7 => SampleType::I64,
        8 => SampleType::F32,
        9 => SampleType::F64,
        0xffff_ffff => SampleType::Timestamp,
        other => SampleType::OtherOfDaqmx(other),
    }
}
