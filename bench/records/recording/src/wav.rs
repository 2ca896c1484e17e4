//! Subset of RIFF/WAVE for recordings, robust against headers of killed writers and truncated files.
//!
//! `hound` reads and writes WAV too, but its `Drop` discards write errors and it refuses files with inconsistent sizes;
//! the tests use it as an independent reader and writer.

mod encoding;
mod riff;
mod wav_error;

use std::io::{self, Read, Seek, SeekFrom};

pub use encoding::Encoding;
use riff::{DataChunk, RiffHeader, read_array, require_limit};
pub use wav_error::{WavError, WavWarning};

/// Bytes before the first sample in files written by this module.
pub const HEADER_BYTES: u64 = 58;

/// Bytes of one sample in files written by this module.
pub const SAMPLE_BYTES: u64 = 4;

/// Maximum number of sample bytes in a file written by this module: the RIFF size has 32 bits and excludes 8 bytes.
pub const MAX_DATA_BYTES: u64 = u32::MAX as u64 - (HEADER_BYTES - 8);

/// Maximum number of channels, and sampling rate, Hz, of a file that is read.
const MAX_CHANNELS: u64 = 256;
const MAX_SAMPLE_RATE_HZ: u64 = 2_000_000;

/// Reciprocal of the shortest tail of zeros with a warning, Hz: converters never read exactly zero that long.
const ZERO_TAILS_PER_S: u64 = 100;

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

/// Samples of a file: their format and their place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// Sampling rate and number of channels.
    pub format: AudioFormat,
    /// Encoding of each sample.
    pub encoding: Encoding,
    /// Offset of the first one, bytes.
    pub start: u64,
    /// Number of frames.
    pub frames: u64,
}

impl Samples {
    /// Reads the header and finds the samples; if the header disagrees with the file's length, the length decides.
    ///
    /// # Errors
    /// [`WavError`] describes the fault; no content causes a panic.
    pub fn find<R: Read + Seek>(source: &mut R) -> Result<(Self, Vec<WavWarning>), WavError> {
        let file_bytes = source.seek(SeekFrom::End(0))?;
        source.seek(SeekFrom::Start(0))?;
        let header = RiffHeader::read(source)?;
        let chunk = header.find_data(source, file_bytes, read_format)?;
        let (data_bytes, warning) = data_bytes(source, file_bytes, &chunk)?;
        let (samples, warnings) = Self::part(source, chunk.format, chunk.start, data_bytes)?;
        Ok((
            samples,
            Vec::from_iter(warning)
                .into_iter()
                .chain(warnings)
                .collect(),
        ))
    }

    /// Finds the samples that the content of a format chunk describes, in `bytes` bytes from `start` on.
    ///
    /// # Errors
    /// [`WavError`] describes the fault; no content causes a panic.
    pub fn described<R: Read + Seek>(
        source: &mut R,
        format_chunk: &[u8],
        start: u64,
        bytes: u64,
    ) -> Result<(Self, Vec<WavWarning>), WavError> {
        let size = u32::try_from(format_chunk.len()).unwrap_or(u32::MAX);
        let mut content = format_chunk;
        let format = read_format(&mut content, size, size.into())?;
        Self::part(source, format, start, bytes)
    }

    fn part<R: Read + Seek>(
        source: &mut R,
        (format, encoding): (AudioFormat, Encoding),
        start: u64,
        bytes: u64,
    ) -> Result<(Self, Vec<WavWarning>), WavError> {
        let mut warnings = Vec::new();
        let frame_bytes = u64::from(format.channels) * encoding.bytes();
        let frames = bytes / frame_bytes;
        if !bytes.is_multiple_of(frame_bytes) {
            warnings.push(WavWarning::PartialFrame {
                bytes: bytes % frame_bytes,
            });
        }
        if frames == 0 {
            warnings.push(WavWarning::Empty);
        }
        let zero_frames = zero_tail(source, start, frames, frame_bytes)?;
        if zero_frames > u64::from(format.sample_rate_hz) / ZERO_TAILS_PER_S {
            warnings.push(WavWarning::ZeroTail {
                first_frame: frames - zero_frames,
                frames: zero_frames,
                sample_rate_hz: format.sample_rate_hz,
            });
        }
        source.seek(SeekFrom::Start(start))?;
        let encoding = encoding.resolve(Read::by_ref(source).take(frames * frame_bytes))?;
        let samples = Self {
            format,
            encoding,
            start,
            frames,
        };
        Ok((samples, warnings))
    }
}

impl<R: Read + Seek> WavReader<R> {
    /// Reads the header and finds the samples; if the header disagrees with the file's length, the length decides.
    ///
    /// # Errors
    /// [`WavError`] describes the fault; no content causes a panic.
    pub fn new(mut source: R) -> Result<(Self, Vec<WavWarning>), WavError> {
        let (samples, warnings) = Samples::find(&mut source)?;
        let Samples {
            format,
            encoding,
            start,
            frames,
        } = samples;
        if !encoding.is_of_recordings() {
            return Err(WavError::SampleFormat {
                tag: TAG_PCM,
                bits: 8 * encoding.bytes() as u16,
            });
        }
        source.seek(SeekFrom::Start(start))?;
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

/// Returns the bytes of samples in the file, and a warning if they are not those of the header. Bytes after the declared
/// ones belong to the samples if the RIFF size excludes them too, and they are not tags.
fn data_bytes<R: Read + Seek, F>(
    source: &mut R,
    file_bytes: u64,
    chunk: &DataChunk<F>,
) -> io::Result<(u64, Option<WavWarning>)> {
    let present_bytes = file_bytes - chunk.start;
    let Some(declared_bytes) = chunk.declared_bytes else {
        return Ok((present_bytes, Some(WavWarning::NoLength { present_bytes })));
    };
    if declared_bytes > present_bytes {
        let warning = WavWarning::Truncated {
            declared_bytes,
            present_bytes,
        };
        return Ok((present_bytes, Some(warning)));
    }
    let padded_end = riff::chunk_end(source, chunk.start, declared_bytes, file_bytes)?;
    let has_more = file_bytes > padded_end
        && if declared_bytes == 0 {
            file_bytes != chunk.riff_end
        } else {
            file_bytes > chunk.riff_end && padded_end >= chunk.riff_end
        };
    if has_more && !riff::are_tags(source, padded_end, file_bytes)? {
        let warning = WavWarning::StaleHeader {
            declared_bytes,
            present_bytes,
        };
        return Ok((present_bytes, Some(warning)));
    }
    Ok((declared_bytes, None))
}

/// Returns the number of frames at the end with all bytes zero, of `frames` frames from the offset `start` on.
fn zero_tail<R: Read + Seek>(
    source: &mut R,
    start: u64,
    frames: u64,
    frame_bytes: u64,
) -> io::Result<u64> {
    let most_frames = (1 << 16) / frame_bytes + 1;
    let (mut frames_left, mut bytes) = (frames, Vec::new());
    while frames_left > 0 {
        let n_frames = frames_left.min(most_frames);
        frames_left -= n_frames;
        bytes.resize((n_frames * frame_bytes) as usize, 0);
        source.seek(SeekFrom::Start(start + frames_left * frame_bytes))?;
        source.read_exact(&mut bytes)?;
        if let Some(last) = bytes.iter().rposition(|byte| *byte != 0) {
            return Ok(frames - frames_left - (last as u64 / frame_bytes + 1));
        }
    }
    Ok(frames)
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
    let mut valid_bits = bits;
    if tag == TAG_EXTENSIBLE {
        if usable_bytes < 40 {
            return Err(short_format(40));
        }
        let _size: [u8; 2] = read_array(source)?;
        match u16::from_le_bytes(read_array(source)?) {
            0 => {}
            stated => valid_bits = stated.min(bits),
        }
        let _channel_mask: [u8; 4] = read_array(source)?;
        tag = u16::from_le_bytes(read_array(source)?);
    }
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
    let is_float = tag == TAG_FLOAT;
    if !is_float && tag != TAG_PCM {
        return Err(WavError::SampleFormat { tag, bits });
    }
    let sample_bytes = u64::from(frame_bytes) / u64::from(channels);
    let is_whole = u64::from(frame_bytes) == u64::from(channels) * sample_bytes;
    if !is_whole || sample_bytes * 8 < u64::from(bits) {
        return Err(WavError::Field {
            field: "bytes per frame",
            value: u64::from(frame_bytes),
        });
    }
    let used_bits = if is_float { bits } else { valid_bits };
    let encoding = Encoding::new(is_float, used_bits, sample_bytes)
        .ok_or(WavError::SampleFormat { tag, bits })?;
    Ok((
        AudioFormat {
            sample_rate_hz,
            channels,
        },
        encoding,
    ))
}
