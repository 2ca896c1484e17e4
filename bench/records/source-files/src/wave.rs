//! WAV, RF64, BW64 and Wave64: samples of integers and floats. Full scale of integers reads as ±1.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use file_sections::{Section, Stride};
use wav_files::{Encoding, Samples, WavError, WavWarning};

use crate::array::{ArrayInfo, Attribute, Element};
use crate::error::{SourceError, SourceFault};
use crate::format::{ArrayReader, Format, Place, Values, strides};
use crate::npy::read_error;

/// Identifiers of chunks of Wave64 begin with four letters and end alike; that of the file differs.
const WAVE64_FILE: [u8; 16] = *b"riff\x2e\x91\xcf\x11\xa5\xd6\x28\xdb\x04\xc1\x00\x00";
const WAVE64_END: [u8; 12] = *b"\xf3\xac\xd3\x11\x8c\xd1\x00\xc0\x4f\x8e\xdb\x8a";

/// Maximum number of chunks before the samples of Wave64.
const MOST_CHUNKS: usize = 1000;

/// Maximum bytes of a chunk that describes samples.
const MOST_FORMAT_BYTES: u64 = 1 << 12;

/// Reader of a sound file without compression.
pub(crate) struct WaveReader {
    format: Format,
    samples: Samples,
    section: Section,
    arrays: Vec<ArrayInfo>,
    attributes: BTreeMap<String, Attribute>,
    notes: Vec<String>,
}

impl WaveReader {
    /// Opens a file that begins as one of the formats does.
    pub(crate) fn open(mut file: File, head: &[u8]) -> Result<Box<dyn ArrayReader>, SourceError> {
        let format = match head.first_chunk::<4>() {
            Some(b"RF64") => Format::Rf64,
            Some(b"BW64") => Format::Bw64,
            Some(b"riff") => Format::Wave64,
            _ => Format::Wav,
        };
        let found = match format {
            Format::Wave64 => wave64(&mut file)?,
            _ => Samples::find(&mut file),
        };
        let (samples, warnings) = found.map_err(error)?;
        let bits = 8 * samples.encoding.bytes() as u8;
        let element = match samples.encoding {
            Encoding::F32 | Encoding::F64 => Element::Float { bits },
            Encoding::U8 => Element::Integer {
                bits,
                is_signed: false,
            },
            Encoding::I24In32 | Encoding::LowI24 => Element::Integer {
                bits: 24,
                is_signed: true,
            },
            _ => Element::Integer {
                bits,
                is_signed: true,
            },
        };
        let rate_hz = f64::from(samples.format.sample_rate_hz);
        let channels = u64::from(samples.format.channels);
        let info = ArrayInfo {
            rate_hz: Some(rate_hz),
            ..ArrayInfo::new("", element, vec![samples.frames, channels])
        };
        // The end of a file that is being written is read as far as it is there; zeros and empty files are for checks.
        let mut notes: Vec<String> = warnings.iter().map(WavWarning::to_string).collect();
        if samples.encoding.is_integer() {
            notes.push("its samples are integers, and full scale reads as 1".to_owned());
        }
        let bytes = file.metadata()?.len();
        Ok(Box::new(Self {
            format,
            samples,
            section: Section::new(Arc::new(file), samples.start, bytes),
            arrays: vec![info],
            attributes: BTreeMap::new(),
            notes,
        }))
    }
}

/// Finds the samples of a Wave64 file.
fn wave64(file: &mut File) -> Result<Result<(Samples, Vec<WavWarning>), WavError>, SourceError> {
    let file_bytes = file.metadata()?.len();
    let damaged =
        |offset: u64, finding: &str| SourceError::damaged(format!("byte {offset}"), finding);
    let mut start = [0; 40];
    file.read_exact(&mut start)
        .map_err(|_| damaged(0, "its header of 40 bytes ends early"))?;
    if start[..16] != WAVE64_FILE || start[24..28] != *b"wave" {
        return Err(damaged(0, "its header is not the one of Wave64"));
    }
    let mut description = None;
    let mut offset = 40;
    for _ in 0..MOST_CHUNKS {
        if file_bytes < offset + 24 {
            break;
        }
        file.seek(SeekFrom::Start(offset))?;
        let mut head = [0; 24];
        file.read_exact(&mut head)?;
        let size = head[16..]
            .first_chunk()
            .map_or(0, |size| u64::from_le_bytes(*size));
        let content = size
            .checked_sub(24)
            .ok_or_else(|| damaged(offset, "a chunk is shorter than its header"))?;
        let is_chunk = head[4..16] == WAVE64_END;
        match head.first_chunk::<4>() {
            Some(b"fmt ") if is_chunk && content <= MOST_FORMAT_BYTES => {
                let mut bytes = vec![0; content as usize];
                file.read_exact(&mut bytes)
                    .map_err(|_| damaged(offset, "the description of its samples ends early"))?;
                description = Some(bytes);
            }
            Some(b"data") if is_chunk => {
                let description = description
                    .ok_or_else(|| damaged(offset, "the description of its samples is missing"))?;
                let present = file_bytes - offset - 24;
                let bytes = content.min(present);
                let found = Samples::described(file, &description, offset + 24, bytes);
                return Ok(found.map(|(samples, mut warnings)| {
                    if content > present {
                        warnings.push(WavWarning::Truncated {
                            declared_bytes: content,
                            present_bytes: present,
                        });
                    }
                    (samples, warnings)
                }));
            }
            _ => {}
        }
        // Chunks begin at multiples of eight bytes.
        offset = offset.saturating_add(size).next_multiple_of(8);
    }
    Err(damaged(offset.min(file_bytes), "its samples are missing"))
}

fn error(error: WavError) -> SourceError {
    match error {
        WavError::Io(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            SourceError::damaged("its header", "it ends early")
        }
        WavError::Io(error) => error.into(),
        WavError::NoChunk { .. } | WavError::ShortFormat { .. } | WavError::OverLimit { .. } => {
            SourceError::damaged("its header", error.to_string())
        }
        error => SourceFault::Sound {
            fault: error.to_string(),
        }
        .into(),
    }
}

impl ArrayReader for WaveReader {
    fn format(&self) -> Format {
        self.format
    }

    fn arrays(&self) -> &[ArrayInfo] {
        &self.arrays
    }

    fn attributes(&self) -> &BTreeMap<String, Attribute> {
        &self.attributes
    }

    fn stated_rate_hz(&self) -> Option<f64> {
        Some(f64::from(self.samples.format.sample_rate_hz))
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn read(
        &mut self,
        index: usize,
        place: &Place,
        range: Range<u64>,
        values: &mut Values<'_>,
    ) -> Result<(), SourceError> {
        let encoding = self.samples.encoding;
        let strides = strides(&self.arrays[index].shape, encoding.bytes(), false);
        let (offset, step) = place.offset_and_step(&strides);
        let stride = Stride {
            offset: offset + range.start.saturating_mul(step),
            step,
            bytes: encoding.bytes() as usize,
            count: range.end - range.start,
        };
        let push = |bytes: &[u8]| encoding.visit(bytes, |sample| values.push(sample));
        let read = stride.visit(&mut self.section, push);
        let start = self.samples.start;
        read.map_err(|(offset, error)| read_error("", start + offset, &error))
    }
}
