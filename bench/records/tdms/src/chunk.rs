//! The chunk of a segment: the samples of each object once, and their places in it.

use std::sync::Arc;

use crate::error::{SegmentDefect, UnreadContent};
use crate::metadata::{Scaler, Storage};
use crate::value::SampleType;

/// An object that has samples in a chunk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stored<'a> {
    pub path: &'a str,
    pub storage: &'a Storage,
}

/// Layout of a chunk.
#[derive(Debug)]
pub(crate) struct Chunk {
    pub bytes: u64,
    /// By object; `None` for text, and for objects without samples.
    pub places: Vec<Option<Place>>,
    layout: Layout,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    Contiguous,
    Interleaved,
    Daqmx,
}

/// One number of a channel in each row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Field {
    pub sample_type: SampleType,
    /// From the begin of the row, bytes.
    pub offset: u64,
    /// Bit of the number at `offset`, for a digital line.
    pub bit: Option<u8>,
    /// Scale that it is the source of; `None` outside DAQmx.
    pub scale_id: Option<u32>,
}

/// Place of an object's samples in a chunk.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub begin: u64,
    /// At least 1.
    pub row_bytes: u64,
    pub values: u64,
    pub fields: Arc<[Field]>,
}

impl Place {
    /// Returns whether rows follow rows through all chunks without a gap.
    pub fn fills(&self, chunk: &Chunk) -> bool {
        self.row_bytes.checked_mul(self.values) == Some(chunk.bytes)
    }
}

/// A chunk larger than any disk.
const TOO_LARGE: &str = "a chunk of more bytes than a file can have";

impl Chunk {
    /// Lays out the samples of `objects`, in their order.
    ///
    /// # Errors
    /// The contradiction between the objects.
    pub fn new(objects: &[Stored<'_>], is_interleaved: bool) -> Result<Self, SegmentDefect> {
        let is_daqmx = |object: &Stored<'_>| matches!(object.storage, Storage::Daqmx { .. });
        let chunk = if objects.iter().any(is_daqmx) {
            Self::daqmx(objects)
        } else if is_interleaved {
            Self::interleaved(objects)
        } else {
            Self::contiguous(objects)
        };
        chunk?.ok_or_else(|| TOO_LARGE.to_owned().into())
    }

    /// Objects one after the other.
    fn contiguous(objects: &[Stored<'_>]) -> Result<Option<Self>, SegmentDefect> {
        let mut bytes = 0_u64;
        let mut places = Vec::new();
        for object in objects {
            let &Storage::Plain {
                sample_type,
                values,
                text_bytes,
            } = object.storage
            else {
                return Err(mixed(object.path));
            };
            let begin = bytes;
            let size = match (sample_type, sample_type.size()) {
                (SampleType::Text, _) => Some(text_bytes),
                (_, Some(size)) => size.checked_mul(values),
                (_, None) if values == 0 => Some(0),
                (other, None) => return Err(unknown(object.path, other)),
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
            }));
        }
        Ok(Some(Self {
            bytes,
            places,
            layout: Layout::Contiguous,
        }))
    }

    /// Rows with one sample of each object.
    fn interleaved(objects: &[Stored<'_>]) -> Result<Option<Self>, SegmentDefect> {
        let mut row_bytes = 0_u64;
        let mut offsets = Vec::new();
        for object in objects {
            let &Storage::Plain { sample_type, .. } = object.storage else {
                return Err(mixed(object.path));
            };
            let Some(size) = sample_type.size() else {
                return Err(unknown(object.path, sample_type));
            };
            offsets.push((sample_type, row_bytes));
            row_bytes += size;
        }
        let values = objects.first().map_or(0, |object| object.storage.values());
        if let Some(other) = objects.iter().find(|o| o.storage.values() != values) {
            return Err(
                format!("interleaved channels of different lengths ({})", other.path).into(),
            );
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
            })
        });
        Ok(Some(Self {
            bytes,
            places: places.collect(),
            layout: Layout::Interleaved,
        }))
    }

    /// A task's buffers one after the other, in rows.
    fn daqmx(objects: &[Stored<'_>]) -> Result<Option<Self>, SegmentDefect> {
        let mut widths: Option<&Vec<u64>> = None;
        let mut rows: Vec<u64> = Vec::new();
        for object in objects {
            let Storage::Daqmx {
                values,
                scalers,
                row_bytes,
            } = object.storage
            else {
                return Err(mixed(object.path));
            };
            if widths.is_some_and(|widths| widths != row_bytes) {
                return Err(format!(
                    "channels of one DAQmx task with buffers of different widths ({})",
                    object.path
                )
                .into());
            }
            widths = Some(row_bytes);
            rows.resize(row_bytes.len(), 0);
            for scaler in scalers {
                let rows = rows
                    .get_mut(scaler.buffer)
                    .ok_or_else(|| format!("{} lies in a buffer that is missing", object.path))?;
                if *rows != 0 && *rows != *values {
                    return Err(format!(
                        "channels of one DAQmx buffer with different lengths ({})",
                        object.path
                    )
                    .into());
                }
                *rows = *values;
            }
        }
        let widths = widths.map_or(&[][..], Vec::as_slice);
        let mut begins = Vec::new();
        let mut bytes = 0_u64;
        for (width, rows) in widths.iter().zip(&rows) {
            begins.push(bytes);
            let size = width.checked_mul(*rows);
            let Some(next) = size.and_then(|size| bytes.checked_add(size)) else {
                return Ok(None);
            };
            bytes = next;
        }
        let mut places = Vec::new();
        for object in objects {
            let Storage::Daqmx {
                values, scalers, ..
            } = object.storage
            else {
                continue;
            };
            let Some(buffer) = scalers.first().map(|scaler| scaler.buffer) else {
                places.push(None);
                continue;
            };
            if scalers.iter().any(|scaler| scaler.buffer != buffer) {
                return Err(format!("{} lies in two DAQmx buffers", object.path).into());
            }
            let at = (begins.get(buffer), widths.get(buffer));
            places.push(match at {
                (Some(begin), Some(row_bytes)) if *row_bytes > 0 => Some(Place {
                    begin: *begin,
                    row_bytes: *row_bytes,
                    values: *values,
                    fields: scalers.iter().map(daqmx_field).collect(),
                }),
                _ => None,
            });
        }
        Ok(Some(Self {
            bytes,
            places,
            layout: Layout::Daqmx,
        }))
    }

    /// Returns whether a cut chunk contains its first bytes, and not a part of each object.
    pub fn is_sequential_when_cut(&self, is_unfinished: bool) -> bool {
        is_unfinished || self.layout != Layout::Contiguous
    }

    /// Returns the number of an object's values in a part of a chunk that contains a part of each object; 0 beside text, since
    /// the size of a part of a text is unknown.
    pub fn values_in_part(&self, place: &Place, part_bytes: u64) -> u64 {
        if self.places.iter().any(Option::is_none) {
            return 0;
        }
        let values = u128::from(place.values) * u128::from(part_bytes) / u128::from(self.bytes);
        u64::try_from(values).unwrap_or(0)
    }

    /// Returns the begin of an object in a part of a chunk that contains a part of each object.
    pub fn begin_in_part(&self, place: &Place, part_bytes: u64) -> u64 {
        let before = self.places.iter().flatten();
        before
            .take_while(|earlier| earlier.begin < place.begin)
            .map(|earlier| self.values_in_part(earlier, part_bytes) * earlier.row_bytes)
            .sum()
    }
}

fn mixed(path: &str) -> SegmentDefect {
    format!("samples of a DAQmx task among others ({path})").into()
}

fn unknown(path: &str, sample_type: SampleType) -> SegmentDefect {
    SegmentDefect::Unread {
        path: path.to_owned(),
        unread: UnreadContent::samples(sample_type),
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
