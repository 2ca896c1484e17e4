//! Why a TDMS file, or a channel in it, cannot be read.

use std::io;

/// Why a file or a channel cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum TdmsError {
    /// The file cannot be read from its disk.
    #[error("the disk returns no data")]
    Io(#[from] io::Error),
    /// The file does not begin with TDMS's mark.
    #[error("not a TDMS file: it begins with the bytes {first:02x?}, not with \"TDSm\"")]
    OtherFormat {
        /// First bytes.
        first: Vec<u8>,
    },
    /// An index file, which contains no samples.
    #[error(
        "an index (.tdms_index), which contains no samples: name the .tdms file of the same name"
    )]
    Index,
    /// Contents that the format does not allow.
    #[error("segment {segment}, byte {byte}: {defect}")]
    Damaged {
        /// Number of the segment, from 1.
        segment: usize,
        /// Place in the file, bytes.
        byte: u64,
        /// Description.
        defect: String,
    },
    /// No channel has this number.
    #[error("no channel has the number {index}")]
    NoChannel {
        /// Number of the channel, from 0.
        index: usize,
    },
    /// A channel's samples are of a kind that is not read.
    #[error("channel \"{channel}\": {reason}")]
    Unsupported {
        /// Group and channel.
        channel: String,
        /// Description.
        reason: String,
    },
}
