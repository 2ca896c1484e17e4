//! Chunks of a RIFF file.

use std::io::{self, Read, Seek, SeekFrom};

use crate::wav_error::WavError;

/// Maximum number of chunks before or after the samples.
pub(crate) const MAX_CHUNKS: u64 = 1000;

/// Size in a header that is stated elsewhere, or not at all.
pub(crate) const NO_SIZE: u64 = u32::MAX as u64;

/// Identifiers of chunks that usual writers place before or after the samples.
const KNOWN_CHUNKS: [&[u8; 4]; 20] = [
    b"data", b"fmt ", b"fact", b"LIST", b"bext", b"iXML", b"cue ", b"smpl", b"inst", b"id3 ",
    b"ID3 ", b"JUNK", b"junk", b"PAD ", b"FLLR", b"PEAK", b"axml", b"chna", b"_PMX", b"ds64",
];

/// Start of a RIFF or RF64 file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RiffHeader {
    /// End of the file by its declared size, without pad byte.
    pub(crate) end: u64,
    /// Declared sizes of 64 bits, in an RF64 file.
    is_64_bit: bool,
}

/// Chunk of samples, and the format chunk before it.
#[derive(Debug)]
pub(crate) struct DataChunk<F> {
    /// Content of the format chunk.
    pub(crate) format: F,
    /// Offset of the first sample.
    pub(crate) start: u64,
    /// Bytes of samples by the header; `None` if it states no length.
    pub(crate) declared_bytes: Option<u64>,
    /// End of the RIFF chunk by its declared size.
    pub(crate) riff_end: u64,
}

impl RiffHeader {
    /// Reads the first 12 bytes.
    pub(crate) fn read<R: Read>(source: &mut R) -> Result<Self, WavError> {
        let mut start = Vec::new();
        source.take(12).read_to_end(&mut start)?;
        let is_64_bit = matches!(start.first_chunk::<4>(), Some(b"RF64" | b"BW64"));
        let is_riff = is_64_bit || start.starts_with(b"RIFF");
        if !is_riff || start.get(8..) != Some(b"WAVE") {
            return Err(refusal(&start));
        }
        let size = u32::from_le_bytes([start[4], start[5], start[6], start[7]]);
        Ok(Self {
            end: 8 + u64::from(size),
            is_64_bit,
        })
    }

    /// Finds the samples; `read_format` reads the format chunk from its size and the bytes left in the file.
    pub(crate) fn find_data<R: Read + Seek, F>(
        self,
        source: &mut R,
        file_bytes: u64,
        read_format: impl Fn(&mut R, u32, u64) -> Result<F, WavError>,
    ) -> Result<DataChunk<F>, WavError> {
        let mut format = None;
        // Sizes of the file and of the samples in the `ds64` chunk.
        let mut long_sizes = None;
        let mut offset = 12;
        let mut chunks = 0;
        loop {
            require_limit("number of chunks before the samples", chunks, MAX_CHUNKS)?;
            chunks += 1;
            let Some((id, size)) = chunk_at(source, offset, file_bytes)? else {
                let chunk = if format.is_none() { "fmt " } else { "data" };
                return Err(WavError::NoChunk { chunk });
            };
            offset += 8;
            match &id {
                b"ds64" if self.is_64_bit && size >= 16 && offset + 16 <= file_bytes => {
                    let riff_bytes = u64::from_le_bytes(read_array(source)?);
                    let data_bytes = u64::from_le_bytes(read_array(source)?);
                    long_sizes = Some((riff_bytes, data_bytes));
                }
                b"fmt " => format = Some(read_format(source, size, file_bytes - offset)?),
                b"data" => {
                    let format = format.ok_or(WavError::NoChunk { chunk: "fmt " })?;
                    let (long_riff, long_data) = long_sizes.unzip();
                    return Ok(DataChunk {
                        format,
                        start: offset,
                        declared_bytes: match u64::from(size) {
                            NO_SIZE => long_data,
                            bytes => Some(bytes),
                        },
                        riff_end: match self.end - 8 {
                            NO_SIZE => 8u64.saturating_add(long_riff.unwrap_or(NO_SIZE)),
                            bytes => 8 + bytes,
                        },
                    });
                }
                _ => {}
            }
            offset = chunk_end(source, offset, u64::from(size), file_bytes)?;
        }
    }
}

/// Returns the identifier and the size of the chunk at `offset`; `None` at the end of the file.
fn chunk_at<R: Read + Seek>(
    source: &mut R,
    offset: u64,
    file_bytes: u64,
) -> io::Result<Option<([u8; 4], u32)>> {
    if offset.saturating_add(8) > file_bytes {
        return Ok(None);
    }
    source.seek(SeekFrom::Start(offset))?;
    let id = read_array(source)?;
    Ok(Some((id, u32::from_le_bytes(read_array(source)?))))
}

/// Returns the end of a chunk's content of `size` bytes from `offset` on, with its pad byte if it has one: some writers
/// leave it out.
pub(crate) fn chunk_end<R: Read + Seek>(
    source: &mut R,
    offset: u64,
    size: u64,
    file_bytes: u64,
) -> io::Result<u64> {
    let end = offset.saturating_add(size);
    let is_unpadded = size % 2 == 1
        && chunk_at(source, end, file_bytes)?.is_some_and(|(id, _)| KNOWN_CHUNKS.contains(&&id));
    Ok(end.saturating_add(if is_unpadded { 0 } else { size % 2 }))
}

/// Returns whether the bytes from `offset` to the end of the file are chunks, or an ID3 tag of 128 bytes: tags that a program
/// added after the samples.
pub(crate) fn are_tags<R: Read + Seek>(
    source: &mut R,
    offset: u64,
    file_bytes: u64,
) -> io::Result<bool> {
    let mut offset = offset;
    for _ in 0..MAX_CHUNKS {
        if offset >= file_bytes {
            return Ok(true);
        }
        let Some((id, size)) = chunk_at(source, offset, file_bytes)? else {
            return Ok(false);
        };
        if file_bytes - offset == 128 && id.starts_with(b"TAG") {
            return Ok(true);
        }
        let is_name = id.iter().all(|byte| matches!(byte, b' '..=b'~'));
        let end = (offset + 8).saturating_add(u64::from(size));
        if !is_name || end > file_bytes {
            return Ok(false);
        }
        offset = chunk_end(source, offset + 8, u64::from(size), file_bytes)?;
    }
    Ok(false)
}

/// Names the format of a file that is not RIFF/WAVE.
fn refusal(start: &[u8]) -> WavError {
    let kinds: [(&[u8], &str); 9] = [
        (b"RIFX", "RIFX, big-endian WAV"),
        (b"riff", "Sony Wave64"),
        (b"FORM", "AIFF"),
        (b"caff", "Apple's Core Audio format"),
        (b"fLaC", "FLAC"),
        (b"OggS", "Ogg"),
        (b".snd", "a Sun audio file"),
        (b"ID3", "MP3"),
        (b"TDSm", "a TDMS file of LabVIEW"),
    ];
    match kinds.iter().find(|(magic, _)| start.starts_with(magic)) {
        Some((_, kind)) => WavError::OtherFormat { kind },
        None => WavError::NotWav {
            found: String::from_utf8_lossy(start).into_owned(),
        },
    }
}

pub(crate) fn require_limit(what: &'static str, value: u64, limit: u64) -> Result<(), WavError> {
    if value > limit {
        return Err(WavError::OverLimit { what, value, limit });
    }
    Ok(())
}

pub(crate) fn read_array<const N: usize, R: Read>(source: &mut R) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    source.read_exact(&mut bytes)?;
    Ok(bytes)
}
