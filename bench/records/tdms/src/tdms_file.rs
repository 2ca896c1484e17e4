//! A file: its segments joined to channels, and samples read from it.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;

use crate::channel::Channel;
use crate::error::{SegmentDefect, TdmsError, UnreadContent};
use crate::lead_in::{LEAD_IN_BYTES, LeadIn, Start};
use crate::metadata::{self, ListedObject};
use crate::objects::Objects;
use crate::pieces::Stretch;
use crate::samples::{Numbers, read_rows};
use crate::value::Value;

/// Most bytes of metadata in one segment; LabVIEW writes some hundred.
const MOST_METADATA_BYTES: u64 = 16 << 20;

/// A TDMS file, open for reading.
pub struct TdmsFile<R> {
    source: R,
    properties: BTreeMap<String, Value>,
    channels: Vec<Channel>,
    is_truncated: bool,
}

impl<R> fmt::Debug for TdmsFile<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TdmsFile")
            .field("channels", &self.channels)
            .field("is_truncated", &self.is_truncated)
            .finish_non_exhaustive()
    }
}

impl<R: Read + Seek> TdmsFile<R> {
    /// Reads the metadata of all segments.
    ///
    /// # Errors
    /// [`TdmsError`] for a file of another format, or damaged metadata, with the segment and the place. A last segment that is cut is
    /// no error: [`Self::is_truncated`].
    pub fn open(mut source: R) -> Result<Self, TdmsError> {
        let length = source.seek(SeekFrom::End(0))?;
        let mut objects = Objects::default();
        let mut is_truncated = false;
        let (mut byte, mut segment) = (0, 0);
        while byte < length {
            segment += 1;
            let damaged = |byte: u64, defect: String| TdmsError::Damaged {
                segment,
                byte,
                defect,
            };
            if length - byte < LEAD_IN_BYTES && segment > 1 {
                is_truncated = true;
                break;
            }
            let lead_in = match lead_in(&mut source, byte)? {
                Start::Segment(lead_in) => lead_in,
                Start::Index => return Err(TdmsError::Index),
                Start::Other if segment == 1 => return Err(other_format(&mut source)?),
                Start::Other => {
                    return Err(damaged(byte, "no segment begins here".to_owned()));
                }
            };
            let content = byte + LEAD_IN_BYTES;
            let stated_end = lead_in
                .segment_bytes
                .map(|bytes| content.saturating_add(bytes));
            let end = stated_end.unwrap_or(length).min(length);
            let is_unfinished = stated_end.is_none_or(|stated| stated > length);
            is_truncated |= is_unfinished;
            let samples_begin = content.saturating_add(lead_in.metadata_bytes);
            if samples_begin > end {
                if is_unfinished {
                    break;
                }
                return Err(damaged(
                    byte,
                    "metadata longer than their segment".to_owned(),
                ));
            }
            if lead_in.has_metadata {
                let listed = listed_objects(&mut source, content, &lead_in)
                    .map_err(|problem| problem.into_error(&damaged))?;
                objects
                    .update(listed, lead_in.has_new_list)
                    .map_err(|defect| damaged(content, defect))?;
            }
            if lead_in.has_samples {
                let stretch = Stretch {
                    begin: samples_begin,
                    end,
                    is_big_endian: lead_in.is_big_endian,
                    is_unfinished,
                };
                is_truncated |= objects
                    .add_samples(stretch, lead_in.is_interleaved)
                    .map_err(|flaw| match flaw {
                        SegmentDefect::Contradiction(defect) => damaged(samples_begin, defect),
                        SegmentDefect::Unread { path, unread } => TdmsError::Unsupported {
                            channel: path,
                            unread,
                        },
                    })?;
            }
            byte = end;
        }
        if segment == 0 {
            return Err(TdmsError::OtherFormat { first: Vec::new() });
        }
        let (properties, channels) = objects.into_channels();
        Ok(Self {
            source,
            properties,
            channels,
            is_truncated,
        })
    }

    /// Returns the file's own properties.
    #[must_use]
    pub fn properties(&self) -> &BTreeMap<String, Value> {
        &self.properties
    }

    /// Returns the channels in the order of the file.
    #[must_use]
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Returns whether the file ends within a segment or a chunk, as after a crash or a copy that was cut.
    #[must_use]
    pub fn is_truncated(&self) -> bool {
        self.is_truncated
    }

    /// Appends samples of the channel at `index` of [`Self::channels`], in its unit, to `samples`; `stretch` counts samples from 0
    /// and may end beyond the last.
    ///
    /// # Errors
    /// [`TdmsError`] for a channel that does not exist or is not made of real numbers, and for a disk that does not return its data.
    pub fn read(
        &mut self,
        index: usize,
        stretch: Range<u64>,
        samples: &mut Vec<f64>,
    ) -> Result<(), TdmsError> {
        let channel = readable(&self.channels, index)?;
        if channel.is_complex() {
            let channel = channel.name();
            return Err(TdmsError::Complex { channel });
        }
        let scales = channel.scales.as_ref();
        let scales = scales.map_err(|scale| unsupported(channel, UnreadContent::scale(scale)))?;
        let values = samples;
        let mut numbers = Numbers::Real { scales, values };
        read_stretch(&mut self.source, channel, stretch, &mut numbers)
    }

    /// Appends samples of the channel at `index` of [`Self::channels`] as real and imaginary parts; those of real samples are 0.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_complex(
        &mut self,
        index: usize,
        stretch: Range<u64>,
        samples: &mut Vec<[f64; 2]>,
    ) -> Result<(), TdmsError> {
        let channel = readable(&self.channels, index)?;
        if channel.is_complex() {
            let mut numbers = Numbers::Complex(samples);
            return read_stretch(&mut self.source, channel, stretch, &mut numbers);
        }
        let mut values = Vec::new();
        self.read(index, stretch, &mut values)?;
        samples.extend(values.into_iter().map(|value| [value, 0.0]));
        Ok(())
    }
}

fn unsupported(channel: &Channel, unread: UnreadContent) -> TdmsError {
    TdmsError::Unsupported {
        channel: channel.name(),
        unread,
    }
}

fn readable(channels: &[Channel], index: usize) -> Result<&Channel, TdmsError> {
    let channel = channels.get(index).ok_or(TdmsError::NoChannel { index })?;
    match channel.unread() {
        None => Ok(channel),
        Some(unread) => Err(unsupported(channel, unread)),
    }
}

fn read_stretch<R: Read + Seek>(
    source: &mut R,
    channel: &Channel,
    stretch: Range<u64>,
    numbers: &mut Numbers<'_>,
) -> Result<(), TdmsError> {
    let begins = &channel.begins;
    let first = begins.partition_point(|begin| *begin <= stretch.start);
    let pieces = channel.pieces.iter().zip(begins);
    for (piece, begin) in pieces.skip(first.saturating_sub(1)) {
        if *begin >= stretch.end {
            break;
        }
        let from = stretch.start.saturating_sub(*begin).min(piece.values());
        let to = (stretch.end - begin).min(piece.values());
        read_rows(source, piece, from..to, numbers)?;
    }
    Ok(())
}

fn lead_in<R: Read + Seek>(source: &mut R, byte: u64) -> Result<Start, TdmsError> {
    let mut bytes = [0; LEAD_IN_BYTES as usize];
    source.seek(SeekFrom::Start(byte))?;
    let mut read = Vec::new();
    source.by_ref().take(LEAD_IN_BYTES).read_to_end(&mut read)?;
    if read.len() < bytes.len() {
        return Ok(Start::Other);
    }
    bytes.copy_from_slice(&read);
    Ok(Start::read(&bytes))
}

fn other_format<R: Read + Seek>(source: &mut R) -> Result<TdmsError, TdmsError> {
    source.seek(SeekFrom::Start(0))?;
    let mut first = Vec::new();
    source.by_ref().take(8).read_to_end(&mut first)?;
    if first.starts_with(b"TDSm") {
        return Ok(TdmsError::Damaged {
            segment: 1,
            byte: 0,
            defect: format!("the file ends before byte {LEAD_IN_BYTES}"),
        });
    }
    Ok(TdmsError::OtherFormat { first })
}

/// Why a segment's metadata cannot be read.
enum Problem {
    Disk(std::io::Error),
    Defect(u64, String),
}

impl Problem {
    fn into_error(self, damaged: &dyn Fn(u64, String) -> TdmsError) -> TdmsError {
        match self {
            Self::Disk(error) => error.into(),
            Self::Defect(byte, defect) => damaged(byte, defect),
        }
    }
}

fn listed_objects<R: Read + Seek>(
    source: &mut R,
    content: u64,
    lead_in: &LeadIn,
) -> Result<Vec<ListedObject>, Problem> {
    if lead_in.metadata_bytes > MOST_METADATA_BYTES {
        let defect = format!(
            "{} bytes of metadata; {MOST_METADATA_BYTES} are the most",
            lead_in.metadata_bytes
        );
        return Err(Problem::Defect(content, defect));
    }
    let mut bytes = Vec::new();
    source
        .seek(SeekFrom::Start(content))
        .and_then(|_| {
            source
                .by_ref()
                .take(lead_in.metadata_bytes)
                .read_to_end(&mut bytes)
        })
        .map_err(Problem::Disk)?;
    metadata::read(&bytes, lead_in.is_big_endian)
        .map_err(|(byte, defect)| Problem::Defect(content + byte, defect))
}
