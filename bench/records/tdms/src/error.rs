//! Why a TDMS file, or a channel in it, cannot be read.

use std::io;

use crate::value::SampleType;

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
    /// Content that TDMS allows and this reader does not read.
    #[error("{channel}: {unread}")]
    Unsupported {
        /// Group and channel, or the path of the object.
        channel: String,
        /// The content.
        unread: UnreadContent,
    },
    /// A channel is complex where real samples are needed.
    #[error("{channel} has complex samples")]
    Complex {
        /// Group and channel.
        channel: String,
    },
}

/// Content that is not read, and the remedy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{content} is not read: {remedy}")]
pub struct UnreadContent {
    /// The content, with its article.
    pub content: String,
    /// Remedy.
    pub remedy: &'static str,
}

impl UnreadContent {
    pub(crate) fn scale(content: &str) -> Self {
        Self {
            content: content.to_owned(),
            remedy: "let LabVIEW write the channel scaled, in its unit",
        }
    }

    pub(crate) fn samples(sample_type: SampleType) -> Self {
        Self {
            content: format!("a channel of {sample_type}"),
            remedy: "let LabVIEW write it as numbers",
        }
    }
}

/// SegmentDefect of a segment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum SegmentDefect {
    /// Contents that contradict each other.
    Contradiction(String),
    /// An object whose content is not read.
    Unread { path: String, unread: UnreadContent },
}

impl From<String> for SegmentDefect {
    fn from(contradiction: String) -> Self {
        Self::Contradiction(contradiction)
    }
}
