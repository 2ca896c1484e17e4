//! Subset of RIFF/WAVE for recordings, robust against headers of killed writers and truncated files.
//!
//! `hound` reads and writes WAV too, but its `Drop` discards write errors and it refuses files with inconsistent sizes;
//! the tests use it as an independent reader and writer.

use std::io::{self, Read, Seek, SeekFrom};

/// Bytes before the first sample in files written by this module.
pub const HEADER_BYTES: u64 = 58;

/// Bytes of one sample in files written by this module.
pub const SAMPLE_BYTES: u64 = 4;

/// Maximum number of sample bytes in a file written by this module: the RIFF size has 32 bits and excludes 8 bytes.
pub const MAX_DATA_BYTES: u64 = u32::MAX as u64 - (HEADER_BYTES - 8);

/// Maximum number of chunks before the samples, of channels, and sampling rate, Hz, of a file that is read.
const MAX_CHUNKS: u64 = 1000;
const MAX_CHANNELS: u64 = 256;
const MAX_SAMPLE_RATE_HZ: u64 = 2_000_000;

const TAG_PCM: u16 = 1;
const TAG_FLOAT: u16 = 3;
const TAG_EXTENSIBLE: u16 = 0xFFFE;

/// Sampling rate and number of channels of an audio stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AudioFormat {
    /// Sampling rate, Hz.
    pub sample_rate_hz: u32,
    /// Number of interleaved channels.
    pub channels: u16,
}

impl AudioFormat {
    /// Returns the bytes per frame of 32-bit samples.
    #[must_use]
    pub fn frame_bytes(self) -> u64 {
        u64::from(self.channels) * SAMPLE_BYTES
    }

    /// Returns whether the bytes per frame fit into 16 bits and the bytes per second into 32 bits.
    pub(super) fn fits_a_header(self) -> bool {
        let bytes_per_second = u64::from(self.sample_rate_hz) * self.frame_bytes();
        bytes_per_second > 0
            && self.frame_bytes() <= u64::from(u16::MAX)
            && bytes_per_second <= u64::from(u32::MAX)
    }

    /// Returns the maximum number of frames in one file.
    #[must_use]
    pub fn max_frames(self) -> u64 {
        MAX_DATA_BYTES / self.frame_bytes().max(1)
    }
}

/// Returns the header of a 32-bit float file with `frames` frames: `RIFF`, `fmt ` (18 bytes), `fact`, `data`.
///
/// `frames` must not exceed [`AudioFormat::max_frames`]; larger counts are declared as that limit.
#[must_use]
pub fn header(format: AudioFormat, frames: u64) -> [u8; HEADER_BYTES as usize] {
    let frames = frames.min(format.max_frames());
    let data_bytes = (frames * format.frame_bytes()) as u32;
    let frame_bytes = format.frame_bytes();
    let mut out = [0; HEADER_BYTES as usize];
    let mut offset = 0;
    let mut put = |bytes: &[u8]| {
        out[offset..offset + bytes.len()].copy_from_slice(bytes);
        offset += bytes.len();
    };
    put(b"RIFF");
    put(&(data_bytes + (HEADER_BYTES as u32 - 8)).to_le_bytes());
    put(b"WAVEfmt ");
    put(&18u32.to_le_bytes());
    put(&TAG_FLOAT.to_le_bytes());
    put(&format.channels.to_le_bytes());
    put(&format.sample_rate_hz.to_le_bytes());
    put(&((u64::from(format.sample_rate_hz) * frame_bytes) as u32).to_le_bytes());
    put(&(frame_bytes as u16).to_le_bytes());
    put(&32u16.to_le_bytes());
    put(&0u16.to_le_bytes());
    put(b"fact");
    put(&4u32.to_le_bytes());
    put(&(frames as u32).to_le_bytes());
    put(b"data");
    put(&data_bytes.to_le_bytes());
    out
}

/// Error of reading a WAV file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WavError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is too short for a header, or is not RIFF/WAVE.
    #[error("not a WAV file: it starts with {found:?} instead of \"RIFF\" … \"WAVE\"")]
    NotWav {
        /// First bytes of the file.
        found: String,
    },
    /// The file has a 64-bit or big-endian format related to WAV.
    #[error("{kind} files are not supported; save it as plain RIFF/WAVE (under 4 GiB)")]
    Relative {
        /// `RF64`, `BW64` or `RIFX`.
        kind: String,
    },
    /// A required chunk is missing.
    #[error("no `{chunk}` chunk before the end of the file")]
    NoChunk {
        /// `fmt ` or `data`.
        chunk: &'static str,
    },
    /// The `fmt ` chunk is too short.
    #[error("the `fmt ` chunk has {bytes} bytes, needed are {needed}")]
    ShortFormat {
        /// Bytes in the chunk.
        bytes: u32,
        /// Bytes required by the format tag.
        needed: u32,
    },
    /// The samples are neither 16, 24 or 32-bit integers nor 32-bit floats.
    #[error(
        "sample format {bits} bits with tag {tag:#06x} is not supported; supported are 16, 24 and 32-bit integer and 32-bit float"
    )]
    SampleFormat {
        /// Format tag; for an extensible format, that of the sub-format.
        tag: u16,
        /// Bits per sample.
        bits: u16,
    },
    /// A header field has an impossible value.
    #[error("the header's {field} is {value}, which is impossible")]
    Field {
        /// Name of the field.
        field: &'static str,
        /// Value of the field.
        value: u64,
    },
    /// The file exceeds a limit.
    #[error("its {what} is {value} or more; at most {limit} is read")]
    OverLimit {
        /// Limited quantity.
        what: &'static str,
        /// Number in the file, as far as it was read.
        value: u64,
        /// Limit.
        limit: u64,
    },
}

fn require_limit(what: &'static str, value: u64, limit: u64) -> Result<(), WavError> {
    if value > limit {
        return Err(WavError::OverLimit { what, value, limit });
    }
    Ok(())
}

/// Defect of a WAV file that can still be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WavWarning {
    /// The file ends before the length in the header.
    #[error(
        "the header declares {declared_bytes} bytes of samples, the file has {present_bytes}: truncated"
    )]
    Truncated {
        /// Bytes according to the header.
        declared_bytes: u64,
        /// Bytes in the file.
        present_bytes: u64,
    },
    /// The file is longer than the length in the header: its writer was killed before it updated the header.
    #[error(
        "the header declares {declared_bytes} bytes of samples, the file has {present_bytes}: its writer was killed; all of them are read"
    )]
    StaleHeader {
        /// Bytes according to the header.
        declared_bytes: u64,
        /// Bytes in the file.
        present_bytes: u64,
    },
    /// The last frame is incomplete.
    #[error("the last {bytes} bytes are not a whole frame and are left out")]
    PartialFrame {
        /// Omitted bytes.
        bytes: u64,
    },
    /// The file has no samples.
    #[error("no samples")]
    Empty,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    I16,
    I24,
    I32,
    F32,
}

impl Encoding {
    fn bytes(self) -> u64 {
        match self {
            Self::I16 => 2,
            Self::I24 => 3,
            Self::I32 | Self::F32 => 4,
        }
    }

    /// Appends the samples to `out`; full scale of integers becomes ±1.
    fn decode(self, bytes: &[u8], out: &mut Vec<f32>) {
        match self {
            Self::I16 => out.extend(
                bytes
                    .as_chunks()
                    .0
                    .iter()
                    .map(|b| f32::from(i16::from_le_bytes(*b)) / 32_768.0),
            ),
            Self::I24 => {
                out.extend(
                    bytes.as_chunks().0.iter().map(|&[a, b, c]| {
                        (i32::from_le_bytes([0, a, b, c]) >> 8) as f32 / 8_388_608.0
                    }),
                )
            }
            Self::I32 => out.extend(
                bytes
                    .as_chunks()
                    .0
                    .iter()
                    .map(|b| i32::from_le_bytes(*b) as f32 / 2_147_483_648.0),
            ),
            Self::F32 => out.extend(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b))),
        }
    }
}

/// Reader of the samples of a WAV file in blocks.
#[derive(Debug)]
pub struct WavReader<R> {
    source: R,
    format: AudioFormat,
    encoding: Encoding,
    frames: u64,
    frames_left: u64,
    bytes: Vec<u8>,
}

impl<R: Read + Seek> WavReader<R> {
    /// Reads the header and finds the samples; if the header disagrees with the file's length, the length decides.
    ///
    /// # Errors
    /// [`WavError`] describes the fault; no content causes a panic.
    pub fn new(mut source: R) -> Result<(Self, Vec<WavWarning>), WavError> {
        let file_bytes = source.seek(SeekFrom::End(0))?;
        source.seek(SeekFrom::Start(0))?;
        let riff_end = read_riff(&mut source, file_bytes)?;
        let mut format = None;
        let mut offset = 12;
        let mut chunks = 0;
        let (data_start, declared_bytes) = loop {
            require_limit("number of chunks before the samples", chunks, MAX_CHUNKS)?;
            chunks += 1;
            if offset + 8 > file_bytes {
                let chunk = if format.is_none() { "fmt " } else { "data" };
                return Err(WavError::NoChunk { chunk });
            }
            source.seek(SeekFrom::Start(offset))?;
            let id: [u8; 4] = read_array(&mut source)?;
            let size = u32::from_le_bytes(read_array(&mut source)?);
            offset += 8;
            match &id {
                b"fmt " => format = Some(read_format(&mut source, size, file_bytes - offset)?),
                b"data" => break (offset, u64::from(size)),
                _ => {}
            }
            offset += u64::from(size) + u64::from(size % 2);
        };
        let (format, encoding) = format.ok_or(WavError::NoChunk { chunk: "fmt " })?;

        let mut warnings = Vec::new();
        let present_bytes = file_bytes - data_start;
        let data_end = data_start + declared_bytes;
        // Bytes after the data belong to them only if the RIFF size excludes these bytes too; otherwise they are other
        // chunks.
        let padded_end = data_end + declared_bytes % 2;
        let has_more = file_bytes > padded_end
            && if declared_bytes == 0 {
                file_bytes != riff_end
            } else {
                file_bytes > riff_end && padded_end >= riff_end
            };
        let data_bytes = if declared_bytes > present_bytes {
            warnings.push(WavWarning::Truncated {
                declared_bytes,
                present_bytes,
            });
            present_bytes
        } else if has_more {
            warnings.push(WavWarning::StaleHeader {
                declared_bytes,
                present_bytes,
            });
            present_bytes
        } else {
            declared_bytes
        };
        let frame_bytes = u64::from(format.channels) * encoding.bytes();
        let frames = data_bytes / frame_bytes;
        if data_bytes % frame_bytes != 0 {
            warnings.push(WavWarning::PartialFrame {
                bytes: data_bytes % frame_bytes,
            });
        }
        if frames == 0 {
            warnings.push(WavWarning::Empty);
        }
        source.seek(SeekFrom::Start(data_start))?;
        let reader = Self {
            source,
            format,
            encoding,
            frames,
            frames_left: frames,
            bytes: Vec::new(),
        };
        Ok((reader, warnings))
    }

    /// Returns the sampling rate and the number of channels.
    #[must_use]
    pub fn format(&self) -> AudioFormat {
        self.format
    }

    /// Returns the number of frames in the file.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Replaces the content of `block` with the next frames, interleaved, at most `max_frames`; returns their number, 0
    /// at the end.
    ///
    /// # Errors
    /// The operating system refused, or the file became shorter.
    pub fn read_block(&mut self, max_frames: usize, block: &mut Vec<f32>) -> io::Result<usize> {
        block.clear();
        let frames = self
            .frames_left
            .min(u64::try_from(max_frames).unwrap_or(u64::MAX));
        let samples = frames * u64::from(self.format.channels);
        self.bytes
            .resize((samples * self.encoding.bytes()) as usize, 0);
        self.source.read_exact(&mut self.bytes)?;
        self.encoding.decode(&self.bytes, block);
        self.frames_left -= frames;
        Ok(frames as usize)
    }
}

/// Reads the 12 bytes of the RIFF header; returns the end of the RIFF chunk by its declared size, without pad byte.
fn read_riff<R: Read>(source: &mut R, file_bytes: u64) -> Result<u64, WavError> {
    let mut start = Vec::new();
    source.take(12).read_to_end(&mut start)?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    match start.first_chunk::<4>() {
        Some(kind @ (b"RF64" | b"BW64" | b"RIFX")) => {
            return Err(WavError::Relative { kind: text(kind) });
        }
        Some(b"RIFF") if file_bytes >= 12 && start[8..] == *b"WAVE" => {}
        _ => {
            return Err(WavError::NotWav {
                found: text(&start),
            });
        }
    }
    let size = u32::from_le_bytes([start[4], start[5], start[6], start[7]]);
    Ok(8 + u64::from(size))
}

fn read_format<R: Read>(
    source: &mut R,
    size: u32,
    bytes_left: u64,
) -> Result<(AudioFormat, Encoding), WavError> {
    let short_format = |needed| WavError::ShortFormat {
        bytes: size.min(u32::try_from(bytes_left).unwrap_or(u32::MAX)),
        needed,
    };
    let usable_bytes = bytes_left.min(u64::from(size));
    if usable_bytes < 16 {
        return Err(short_format(16));
    }
    let mut tag = u16::from_le_bytes(read_array(source)?);
    let channels = u16::from_le_bytes(read_array(source)?);
    let sample_rate_hz = u32::from_le_bytes(read_array(source)?);
    let _byte_rate: [u8; 4] = read_array(source)?;
    let frame_bytes = u16::from_le_bytes(read_array(source)?);
    let bits = u16::from_le_bytes(read_array(source)?);
    if tag == TAG_EXTENSIBLE {
        if usable_bytes < 40 {
            return Err(short_format(40));
        }
        let _size_valid_bits_and_mask: [u8; 8] = read_array(source)?;
        tag = u16::from_le_bytes(read_array(source)?);
    }
    let encoding = match (tag, bits) {
        (TAG_PCM, 16) => Encoding::I16,
        (TAG_PCM, 24) => Encoding::I24,
        (TAG_PCM, 32) => Encoding::I32,
        (TAG_FLOAT, 32) => Encoding::F32,
        _ => return Err(WavError::SampleFormat { tag, bits }),
    };
    if channels == 0 {
        return Err(WavError::Field {
            field: "number of channels",
            value: 0,
        });
    }
    if sample_rate_hz == 0 {
        return Err(WavError::Field {
            field: "sample rate",
            value: 0,
        });
    }
    require_limit("number of channels", channels.into(), MAX_CHANNELS)?;
    require_limit(
        "sample rate in Hz",
        sample_rate_hz.into(),
        MAX_SAMPLE_RATE_HZ,
    )?;
    if u64::from(frame_bytes) != u64::from(channels) * encoding.bytes() {
        return Err(WavError::Field {
            field: "bytes per frame",
            value: u64::from(frame_bytes),
        });
    }
    Ok((
        AudioFormat {
            sample_rate_hz,
            channels,
        },
        encoding,
    ))
}

fn read_array<const N: usize, R: Read>(source: &mut R) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    source.read_exact(&mut bytes)?;
    Ok(bytes)
}
