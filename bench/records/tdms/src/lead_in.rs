//! The lead-in of a segment.

use crate::bytes::Bytes;

/// Length of a lead-in, bytes.
pub(crate) const LEAD_IN_BYTES: u64 = 28;
/// Offset of a segment whose writer did not finish it.
const UNFINISHED: u64 = u64::MAX;

/// Contents of a segment, as its lead-in states them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LeadIn {
    pub has_metadata: bool,
    /// The list of objects begins anew, instead of changing that of the segment before.
    pub has_new_list: bool,
    pub has_samples: bool,
    pub is_interleaved: bool,
    pub is_big_endian: bool,
    /// Bytes from the end of the lead-in to the next segment; `None` if the writer did not finish the segment.
    pub segment_bytes: Option<u64>,
    /// Bytes from the end of the lead-in to the samples.
    pub metadata_bytes: u64,
}

/// What a segment begins with.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Start {
    Segment(LeadIn),
    /// A lead-in of an index file.
    Index,
    Other,
}

impl Start {
    pub fn read(bytes: &[u8; LEAD_IN_BYTES as usize]) -> Self {
        let (mark, rest) = bytes.split_at(4);
        match mark {
            b"TDSm" => {}
            b"TDSh" => return Self::Index,
            _ => return Self::Other,
        }
        let lead_in = || {
            // The mask is little-endian in each segment.
            let mask = Bytes::new(rest, false).u32()?;
            let bit = |n: u32| mask >> n & 1 == 1;
            let mut rest = Bytes::new(rest, bit(6));
            rest.take(4)?;
            let _version = rest.u32()?;
            let segment_bytes = rest.u64()?;
            Some(LeadIn {
                has_metadata: bit(1),
                has_new_list: bit(2),
                has_samples: bit(3),
                is_interleaved: bit(5),
                is_big_endian: bit(6),
                segment_bytes: (segment_bytes != UNFINISHED).then_some(segment_bytes),
                metadata_bytes: rest.u64()?,
            })
        };
        lead_in().map_or(Self::Other, Self::Segment)
    }
}
