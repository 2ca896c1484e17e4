//! Places of a segment's samples.
//!
//! A segment repeats its chunk, the samples of each object once, until its end; the last chunk may be cut.

use std::sync::Arc;

use crate::metadata::{Scaler, Storage};
use crate::value::SampleType;

/// One number of a channel in each row of a piece.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub sample_type: SampleType,
    /// From the begin of the row, bytes.
    pub offset: u64,
    /// Bit of the byte at `offset`, for a digital line.
    pub bit: Option<u8>,
    /// Scale that it is the source of; `None` outside DAQmx.
    pub scale_id: Option<u32>,
}

/// Rows of equal length and distance, one after the other, with one sample of a channel each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Piece {
    /// Place of the first row, bytes in the file.
    pub byte: u64,
    /// From row to row, bytes.
    pub row_bytes: u64,
    pub values: u64,
    pub is_big_endian: bool,
    pub fields: Arc<[Field]>,
}

/// Stretch of the file that contains a segment's samples.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    pub begin: u64,
    pub end: u64,
    pub is_interleaved: bool,
    pub is_big_endian: bool,
    /// The segment's writer did not finish it.
    pub is_unfinished: bool,
}

/// Returns the pieces of each object, given the storages of a segment's objects in their order, and whether the last chunk is cut.
///
/// # Errors
/// A description of what cannot be stored so.
pub(crate) fn pieces(
    storages: &[Arc<Storage>],
    stretch: Stretch,
) -> Result<(Vec<Vec<Piece>>, bool), String> {
    let mut pieces = vec![Vec::new(); storages.len()];
    let chunk = Chunk::new(storages, stretch.is_interleaved)?;
    let available = stretch.end.saturating_sub(stretch.begin);
    if chunk.bytes == 0 {
        return Ok((pieces, false));
    }
    let whole_chunks = available / chunk.bytes;
    let remainder = available % chunk.bytes;
    for (places, pieces) in chunk.places.iter().zip(&mut pieces) {
        let Some(place) = places else { continue };
        if place.is_alone(&chunk) {
            // One object, or rows of all objects: chunks join.
            pieces.push(place.piece(&stretch, 0, place.values * whole_chunks));
        } else {
            pieces.extend(
                (0..whole_chunks).map(|n| place.piece(&stretch, n * chunk.bytes, place.values)),
            );
        }
    }
    if remainder > 0 {
        let begin = whole_chunks * chunk.bytes;
        let in_order = !stretch.is_interleaved && stretch.is_unfinished;
        for (place, pieces) in chunk.places.iter().zip(&mut pieces) {
            let Some(place) = place else { continue };
            let values = if place.rows_of_all || in_order {
                let reached = remainder.saturating_sub(place.begin);
                (reached / place.row_bytes).min(place.values)
            } else {
                // A finished segment with a part of a chunk contains that part of each object.
                u64::try_from(
                    u128::from(place.values) * u128::from(remainder) / u128::from(chunk.bytes),
                )
                .unwrap_or(0)
            };
            if values > 0 {
                let place = if place.rows_of_all || in_order {
                    place.clone()
                } else {
                    place.moved(chunk.begin_in_part(place, remainder))
                };
                pieces.push(place.piece(&stretch, begin, values));
            }
        }
    }
    for pieces in &mut pieces {
        pieces.retain(|piece| piece.values > 0);
    }
    Ok((pieces, remainder > 0))
}

#[derive(Debug)]
struct Chunk {
    bytes: u64,
    /// By object; `None` for text.
    places: Vec<Option<Place>>,
}

/// Place of an object's samples in a chunk.
#[derive(Debug, Clone)]
struct Place {
    begin: u64,
    row_bytes: u64,
    values: u64,
    fields: Arc<[Field]>,
    /// The chunk consists of rows of all objects, and nothing else.
    rows_of_all: bool,
}

impl Place {
    fn is_alone(&self, chunk: &Chunk) -> bool {
        self.rows_of_all || self.row_bytes * self.values == chunk.bytes
    }

    fn moved(&self, begin: u64) -> Self {
        Self {
            begin,
            ..self.clone()
        }
    }

    fn piece(&self, stretch: &Stretch, chunk_begin: u64, values: u64) -> Piece {
        Piece {
            byte: stretch.begin + chunk_begin + self.begin,
            row_bytes: self.row_bytes,
            values,
            is_big_endian: stretch.is_big_endian,
            fields: Arc::clone(&self.fields),
        }
    }
}

/// A chunk larger than any disk.
const TOO_LARGE: &str = "a chunk of more bytes than a file can have";

impl Chunk {
    fn new(storages: &[Arc<Storage>], is_interleaved: bool) -> Result<Self, String> {
        let is_daqmx = |storage: &Arc<Storage>| matches!(**storage, Storage::Daqmx { .. });
        let chunk = if storages.iter().any(is_daqmx) {
            Self::daqmx(storages)
        } else if is_interleaved {
            Self::interleaved(storages)
        } else {
            Self::contiguous(storages)
        };
        chunk?.ok_or_else(|| TOO_LARGE.to_owned())
    }

    /// Objects one after the other.
    fn contiguous(storages: &[Arc<Storage>]) -> Result<Option<Self>, String> {
        let mut bytes = 0_u64;
        let mut places = Vec::new();
        for storage in storages {
            let Storage::Plain {
                sample_type,
                values,
                text_bytes,
            } = **storage
            else {
                return Err("DAQmx samples beside others".to_owned());
            };
            let begin = bytes;
            let size = match (sample_type, sample_type.size()) {
                (SampleType::Text, _) => Some(text_bytes),
                (_, Some(size)) => size.checked_mul(values),
                (other, None) => {
                    return Err(format!("samples of a type that is not known ({other:?})"));
                }
            };
            let Some(next) = size.and_then(|size| bytes.checked_add(size)) else {
                return Ok(None);
            };
            bytes = next;
            places.push(sample_type.size().map(|row_bytes| Place {
                begin,
                row_bytes,
                values,
                fields: plain_field(sample_type, 0),
                rows_of_all: false,
            }));
        }
        Ok(Some(Self { bytes, places }))
    }

    /// Rows with one sample of each object.
    fn interleaved(storages: &[Arc<Storage>]) -> Result<Option<Self>, String> {
        let mut row_bytes = 0_u64;
        let mut offsets = Vec::new();
        for storage in storages {
            let Storage::Plain { sample_type, .. } = **storage else {
                return Err("DAQmx samples beside others".to_owned());
            };
            let Some(size) = sample_type.size() else {
                return Err(format!("interleaved samples of type {sample_type:?}"));
            };
            offsets.push((sample_type, row_bytes));
            row_bytes += size;
        }
        let values = storages.first().map_or(0, |storage| storage.values());
        if storages.iter().any(|storage| storage.values() != values) {
            return Err("interleaved channels of different lengths".to_owned());
        }
        let Some(bytes) = row_bytes.checked_mul(values) else {
            return Ok(None);
        };
        let places = offsets.into_iter().map(|(sample_type, offset)| {
            Some(Place {
                begin: 0,
                row_bytes,
                values,
                fields: plain_field(sample_type, offset),
                rows_of_all: true,
            })
        });
        Ok(Some(Self {
            bytes,
            places: places.collect(),
        }))
    }

    /// A task's buffers one after the other, in rows.
    fn daqmx(storages: &[Arc<Storage>]) -> Result<Option<Self>, String> {
        let mut widths: Vec<u64> = Vec::new();
        let mut rows: Vec<u64> = Vec::new();
        for storage in storages {
            let Storage::Daqmx {
                values,
                ref scalers,
                ref row_bytes,
            } = **storage
            else {
                return Err("DAQmx samples beside others".to_owned());
            };
            if !widths.is_empty() && widths != *row_bytes {
                return Err("channels of a DAQmx task with buffers of different widths".to_owned());
            }
            widths.clone_from(row_bytes);
            rows.resize(widths.len(), 0);
            for scaler in scalers {
                let rows = rows
                    .get_mut(scaler.buffer)
                    .ok_or("a buffer that is missing")?;
                if *rows != 0 && *rows != values {
                    return Err("channels of one DAQmx buffer with different lengths".to_owned());
                }
                *rows = values;
            }
        }
        let mut begins = Vec::new();
        let mut bytes = 0_u64;
        for (width, rows) in widths.iter().zip(&rows) {
            begins.push(bytes);
            let Some(next) = width
                .checked_mul(*rows)
                .and_then(|size| bytes.checked_add(size))
            else {
                return Ok(None);
            };
            bytes = next;
        }
        let buffer_count = rows.iter().filter(|rows| **rows > 0).count();
        let mut places = Vec::new();
        for storage in storages {
            let Storage::Daqmx {
                values,
                ref scalers,
                ..
            } = **storage
            else {
                continue;
            };
            let Some(buffer) = scalers.first().map(|scaler| scaler.buffer) else {
                places.push(None);
                continue;
            };
            if scalers.iter().any(|scaler| scaler.buffer != buffer) {
                return Err("a DAQmx channel in two buffers".to_owned());
            }
            places.push(Some(Place {
                begin: begins.get(buffer).copied().unwrap_or(0),
                row_bytes: widths.get(buffer).copied().unwrap_or(0),
                values,
                fields: scalers.iter().map(daqmx_field).collect(),
                rows_of_all: buffer_count == 1,
            }));
        }
        Ok(Some(Self { bytes, places }))
    }

    /// Begin of an object in a part of a chunk, in which each object before it has its part.
    fn begin_in_part(&self, place: &Place, part_bytes: u64) -> u64 {
        let before = self.places.iter().flatten();
        before
            .take_while(|other| other.begin < place.begin)
            .map(|other| {
                let values =
                    u128::from(other.values) * u128::from(part_bytes) / u128::from(self.bytes);
                u64::try_from(values).unwrap_or(0) * other.row_bytes
            })
            .sum()
    }
}

fn plain_field(sample_type: SampleType, offset: u64) -> Arc<[Field]> {
    [Field {
        sample_type,
        offset,
        bit: None,
        scale_id: None,
    }]
    .into()
}

fn daqmx_field(scaler: &Scaler) -> Field {
    let (offset, bit) = if scaler.is_line {
        (scaler.offset / 8, Some((scaler.offset % 8) as u8))
    } else {
        (scaler.offset, None)
    };
    Field {
        sample_type: scaler.sample_type,
        offset,
        bit,
        scale_id: Some(scaler.scale_id),
    }
}
