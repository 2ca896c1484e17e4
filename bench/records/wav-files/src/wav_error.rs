//! Errors and defects of WAV files.

use std::io;

use bounded_files::ContentStore;
use serde::{Deserialize, Serialize};

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
    /// The file is a placeholder without samples.
    #[error("not a WAV file: {0}")]
    Elsewhere(ContentStore),
    /// The file is audio of another format.
    #[error("not a WAV file, but {kind}: save the recording as WAV with 32-bit float samples")]
    OtherFormat {
        /// The format.
        kind: &'static str,
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
    /// The samples have a format that is not read.
    #[error(
        "its samples are {}, which are not read: save the original recording as 32-bit float (16, 24 or 32-bit integer and \
         64-bit float are read too)",
        samples(*.tag, *.bits)
    )]
    SampleFormat {
        /// Format tag; for an extensible format, that of the sub-format.
        tag: u16,
        /// Bits per sample.
        bits: u16,
    },
    /// A header field has an impossible value.
    #[error(
        "the header's {field} is {value}, which is impossible: save the recording again as 32-bit float"
    )]
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

/// Returns a sample format in words.
fn samples(tag: u16, bits: u16) -> String {
    let kind = match tag {
        1 => return format!("{bits}-bit integers"),
        3 => return format!("{bits}-bit floats"),
        0x0002 | 0x0011 => "ADPCM",
        0x0006 => "A-law",
        0x0007 => "µ-law",
        0x0031 => "GSM",
        0x0050 => "MPEG audio",
        0x0055 => "MP3",
        0x0092 => "AC-3",
        0x00ff | 0x1600 | 0x1610 => "AAC",
        0x0160..=0x0163 => "Windows Media audio",
        0x566f | 0x674f..=0x6751 | 0x676f..=0x6771 => "Vorbis",
        0xf1ac => "FLAC",
        _ => return format!("of an unknown kind (format tag {tag:#06x}, {bits} bits)"),
    };
    format!("compressed ({kind})")
}

/// Defect of a WAV file that can still be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
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
    /// The header states no length, as a program writes it into a pipe.
    #[error(
        "the header states no length, as from a pipe; all {present_bytes} bytes of samples in the file are read, and nothing \
         shows whether the end is missing"
    )]
    NoLength {
        /// Bytes in the file.
        present_bytes: u64,
    },
    /// The samples at the end are zero on every channel.
    #[error(
        "the last {:.3} s, from {:.3} s on, are zeros on every channel, as a broken-off copy or a power cut leaves them; copy the \
         file again from the computer that recorded it",
        seconds(*.frames, *.sample_rate_hz), seconds(*.first_frame, *.sample_rate_hz)
    )]
    ZeroTail {
        /// First frame of them.
        first_frame: u64,
        /// Number of frames.
        frames: u64,
        /// Sampling rate, Hz.
        sample_rate_hz: u32,
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

fn seconds(frames: u64, sample_rate_hz: u32) -> f64 {
    frames as f64 / f64::from(sample_rate_hz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sample_format_has_its_name_and_the_remedy() {
        for (tag, bits, name) in [
            (1, 8, "8-bit integers"),
            (1, 64, "64-bit integers"),
            (3, 16, "16-bit floats"),
            (7, 8, "µ-law"),
            (0x55, 0, "MP3"),
            (0x4242, 12, "0x4242, 12 bits"),
        ] {
            let words = WavError::SampleFormat { tag, bits }.to_string();
            assert!(words.contains(name) && words.contains("save"), "{words}");
        }
    }
}
