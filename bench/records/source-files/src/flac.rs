//! FLAC: integers of up to 32 bits, decoded by stretches. Full scale reads as ±1.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::sync::Arc;

use file_sections::{Bytes, Section};
use flac_stream::FlacStream;

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::SourceError;
use crate::format::{ArrayReader, Format, Place, Values};

/// Bytes of the block that describes the stream.
const STREAM_INFO_BYTES: u32 = 34;

/// Maximum number of blocks before the samples.
const MOST_BLOCKS: usize = 1000;

/// Reader of a FLAC file.
pub(crate) struct FlacReader {
    stream: FlacStream,
    rate_hz: f64,
    arrays: Vec<ArrayInfo>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
}

/// Description of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Description {
    rate_hz: u32,
    channels: u64,
    bits: u8,
    /// Number of frames; `None` if the file does not state it.
    frames: Option<u64>,
}

impl FlacReader {
    /// Opens a file that begins as FLAC does.
    pub(crate) fn open(file: File) -> Result<Box<dyn ArrayReader>, SourceError> {
        let n_bytes = file.metadata()?.len();
        let mut section = Section::new(Arc::new(file), 0, n_bytes);
        let (description, others) = blocks(&mut section)?;
        let mut stream = FlacStream::open(section, others, description.channels as usize)?;
        let present = stream.count(description.frames)?;
        let mut notes = vec!["its samples are integers, and full scale reads as 1".to_owned()];
        match description.frames {
            Some(stated) if present < stated => notes.push(format!(
                "the file ends early: {present} of {stated} samples a channel are there and are read"
            )),
            _ => {}
        }
        let rate_hz = f64::from(description.rate_hz);
        let element = Element::Integer {
            bits: description.bits,
            is_signed: true,
        };
        let info = ArrayInfo {
            rate_hz: Some(rate_hz),
            ..ArrayInfo::new("", element, vec![present, description.channels])
        };
        Ok(Box::new(Self {
            stream,
            rate_hz,
            arrays: vec![info],
            attributes: BTreeMap::new(),
            notes,
        }))
    }
}

/// Reads the description of the samples; returns it with the offsets of the other blocks before them.
fn blocks(section: &mut Section) -> Result<(Description, Vec<u64>), SourceError> {
    let damaged =
        |offset: u64, finding: &str| SourceError::damaged(format!("byte {offset}"), finding);
    let (mut description, mut others) = (None, Vec::new());
    let mut offset = 4;
    for _ in 0..MOST_BLOCKS {
        let mut head = [0; 4];
        section
            .read_at(offset, &mut head)
            .map_err(|_| damaged(offset, "the blocks before the samples end early"))?;
        let [kind, high, middle, low] = head;
        let bytes = u32::from_be_bytes([0, high, middle, low]);
        if kind & 0x7f == 0 && bytes >= STREAM_INFO_BYTES && description.is_none() {
            let mut info = [0; STREAM_INFO_BYTES as usize];
            section
                .read_at(offset + 4, &mut info)
                .map_err(|_| damaged(offset, "the description of the samples ends early"))?;
            description = Some(Description::read(&info));
        } else {
            others.push(offset);
        }
        offset += 4 + u64::from(bytes);
        if kind & 0x80 != 0 {
            let description = description
                .ok_or_else(|| damaged(4, "the description of the samples is missing"))?;
            if description.rate_hz == 0 {
                return Err(damaged(4, "its sampling rate is 0"));
            }
            return Ok((description, others));
        }
    }
    Err(damaged(
        offset,
        "it has more than 1000 blocks before the samples",
    ))
}

impl Description {
    fn read(info: &[u8; STREAM_INFO_BYTES as usize]) -> Self {
        // Rate of 20 bits, channels of 3, bits of 5, frames of 36.
        let packed = info[10..18]
            .iter()
            .fold(0u64, |packed, byte| packed << 8 | u64::from(*byte));
        let frames = packed & 0xf_ffff_ffff;
        Self {
            rate_hz: (packed >> 44) as u32,
            channels: (packed >> 41 & 7) + 1,
            bits: (packed >> 36 & 31) as u8 + 1,
            frames: (frames > 0).then_some(frames),
        }
    }
}

impl ArrayReader for FlacReader {
    fn format(&self) -> Format {
        Format::Flac
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn stated_rate_hz(&self) -> Option<f64> {
        Some(self.rate_hz)
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn read(
        &mut self,
        _index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let fixed = place.fixed.first().copied().unwrap_or(0);
        if place.axis == 0 {
            let stream = &mut self.stream;
            stream.read(range, fixed as usize, |value| values.push(value))?;
            return Ok(());
        }
        // All channels of one moment.
        for channel in range {
            self.stream
                .read(fixed..fixed + 1, channel as usize, |value| {
                    values.push(value)
                })?;
        }
        Ok(())
    }
}
