//! `signals.wav` of an imported recording: 32-bit floats where the samples are exact in them, else 64-bit floats.

use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Channels: drive and pickup.
pub(crate) const CHANNELS: u16 = 2;
const TAG_FLOAT: u16 = 3;
/// Greatest number of bytes of samples in a plain WAV file.
const PLAIN_BYTES: u64 = u32::MAX as u64 - 1024;

/// Width of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Width {
    /// 32-bit float.
    Single,
    /// 64-bit float.
    Double,
}

impl Width {
    fn bytes(self) -> u64 {
        match self {
            Self::Single => 4,
            Self::Double => 8,
        }
    }
}

/// Writer of `signals.wav`.
pub(crate) struct WavFile {
    file: BufWriter<File>,
    width: Width,
    frames: u64,
    expected_frames: u64,
}

impl WavFile {
    /// Creates the file for a number of frames, which decides between WAV and RF64.
    pub fn create(path: &Path, rate_hz: u32, width: Width, frames: u64) -> std::io::Result<Self> {
        let mut file = BufWriter::with_capacity(1 << 18, File::create(path)?);
        file.write_all(&header(rate_hz, width, frames))?;
        Ok(Self {
            file,
            width,
            frames: 0,
            expected_frames: frames,
        })
    }

    /// Appends frames; returns `false`, and leaves the file incomplete, at a sample that the width cannot state.
    pub fn append(&mut self, drive: &[f64], pickup: &[f64]) -> std::io::Result<bool> {
        for (drive, pickup) in drive.iter().zip(pickup) {
            for value in [*drive, *pickup] {
                match self.width {
                    Width::Double => self.file.write_all(&value.to_le_bytes())?,
                    Width::Single => {
                        let single = value as f32;
                        if f64::from(single) != value && value.is_finite() {
                            return Ok(false);
                        }
                        self.file.write_all(&single.to_le_bytes())?;
                    }
                }
            }
        }
        self.frames += drive.len().min(pickup.len()) as u64;
        Ok(true)
    }

    /// Ends the file, which is on the disk on return.
    pub fn finish(mut self) -> std::io::Result<()> {
        debug_assert_eq!(self.frames, self.expected_frames);
        self.file.flush()?;
        self.file.seek(SeekFrom::End(0))?;
        self.file.get_ref().sync_all()
    }
}

fn header(rate_hz: u32, width: Width, frames: u64) -> Vec<u8> {
    let frame_bytes = u64::from(CHANNELS) * width.bytes();
    let data_bytes = frames * frame_bytes;
    let is_plain = data_bytes <= PLAIN_BYTES;
    // Chunks before the samples: ds64 of RF64, fmt, fact, and the head of data.
    let before = if is_plain { 0u64 } else { 36 } + 26 + 12 + 8;
    let riff_bytes = 4 + before + data_bytes;
    let size = |bytes: u64| if is_plain { bytes as u32 } else { u32::MAX };
    let mut out = Vec::new();
    let mut put = |bytes: &[u8]| out.extend_from_slice(bytes);
    put(if is_plain { b"RIFF" } else { b"RF64" });
    put(&size(riff_bytes).to_le_bytes());
    put(b"WAVE");
    if !is_plain {
        put(b"ds64");
        put(&28u32.to_le_bytes());
        put(&riff_bytes.to_le_bytes());
        put(&data_bytes.to_le_bytes());
        put(&frames.to_le_bytes());
        put(&0u32.to_le_bytes());
    }
    put(b"fmt ");
    put(&18u32.to_le_bytes());
    put(&TAG_FLOAT.to_le_bytes());
    put(&CHANNELS.to_le_bytes());
    put(&rate_hz.to_le_bytes());
    let byte_rate = u64::from(rate_hz) * frame_bytes;
    put(&u32::try_from(byte_rate).unwrap_or(u32::MAX).to_le_bytes());
    put(&(frame_bytes as u16).to_le_bytes());
    put(&(8 * width.bytes() as u16).to_le_bytes());
    put(&0u16.to_le_bytes());
    put(b"fact");
    put(&4u32.to_le_bytes());
    put(&size(frames).to_le_bytes());
    put(b"data");
    put(&size(data_bytes).to_le_bytes());
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use wav_files::WavReader;

    #[test]
    fn the_file_is_read_back_and_a_sample_that_needs_doubles_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("signals.wav");
        for (width, values) in [
            (Width::Single, [0.5, -0.25, f64::NAN]),
            (Width::Double, [0.1, -0.3, 2.0]),
        ] {
            let mut file = WavFile::create(&path, 100_000, width, 3).unwrap();
            assert!(file.append(&values, &values).unwrap());
            file.finish().unwrap();
            let (mut reader, warnings) = WavReader::new(File::open(&path).unwrap()).unwrap();
            assert!(warnings.is_empty(), "{warnings:?}");
            assert_eq!(reader.format().sample_rate_hz, 100_000);
            let mut block = Vec::new();
            assert_eq!(reader.read_block(10, &mut block).unwrap(), 3);
            assert_eq!(block[0], values[0] as f32);
            assert_eq!(block[3], values[1] as f32);
        }
        let mut file = WavFile::create(&path, 100_000, Width::Single, 1).unwrap();
        assert!(!file.append(&[0.1], &[0.0]).unwrap());
        // A file of more than 4 GiB has the header of RF64.
        assert_eq!(&header(192_000, Width::Double, 1 << 30)[..4], b"RF64");
    }
}
