//! Samples of a FLAC stream, decoded by stretches. Full scale reads as ±1.

use std::collections::VecDeque;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;

use decoder_panics::guarded;
use file_sections::Section;
use symphonia::core::codecs::audio::{AudioDecoder, AudioDecoderOptions};
use symphonia::core::formats::{FormatOptions, FormatReader, SeekMode, SeekTo};
use symphonia::core::io::{MediaSource, MediaSourceStream};
use symphonia::core::units::Timestamp;
use symphonia::default::codecs::FlacDecoder;
use symphonia::default::formats::FlacReader;

/// Maximum number of decoded samples that are kept, of all channels.
const MOST_SAMPLES: usize = 1 << 22;

/// Frames up to which the stream is read forwards rather than searched.
const NEAR_FRAMES: u64 = 1 << 18;

/// Full scale of samples of 32 bits.
const FULL_SCALE: f64 = 2_147_483_648.0;

/// Refusal of samples that cannot be decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("sample {frame}: the samples from here on cannot be decoded")]
pub struct Undecoded {
    /// First of these samples.
    pub frame: u64,
}

/// Stream of samples.
pub struct FlacStream {
    source: Source,
    channels: usize,
    decoding: Option<Decoding>,
    /// Decoded blocks, one after the other.
    blocks: VecDeque<Block>,
    kept: usize,
}

struct Decoding {
    reader: FlacReader<'static>,
    decoder: FlacDecoder,
}

/// Block of decoded samples, interleaved.
struct Block {
    start: u64,
    frames: u64,
    samples: Vec<i32>,
}

impl Block {
    fn end(&self) -> u64 {
        self.start + self.frames
    }
}

/// Bytes of the file in which every block before the samples but their description reads as padding.
#[derive(Clone)]
struct Source {
    section: Section,
    /// Offsets of those blocks.
    hidden: Vec<u64>,
    position: u64,
}

/// Kind of a block that is skipped.
const PADDING: u8 = 1;

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.section.read_from(self.position, buffer)?;
        for offset in &self.hidden {
            let place = offset.wrapping_sub(self.position);
            if place < count as u64 {
                let kind = &mut buffer[place as usize];
                *kind = *kind & 0x80 | PADDING;
            }
        }
        self.position += count as u64;
        Ok(count)
    }
}

impl Seek for Source {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (start, change) = match to {
            SeekFrom::Start(offset) => (offset, 0),
            SeekFrom::End(change) => (self.section.len(), change),
            SeekFrom::Current(change) => (self.position, change),
        };
        self.position = start
            .checked_add_signed(change)
            .ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

impl MediaSource for Source {
    fn is_seekable(&self) -> bool {
        true
    }

    fn byte_len(&self) -> Option<u64> {
        Some(self.section.len())
    }
}

impl FlacStream {
    /// Opens the stream; `hidden` are the offsets of blocks that its reader shall not look into.
    ///
    /// # Errors
    /// Samples cannot be decoded.
    pub fn open(section: Section, hidden: Vec<u64>, channels: usize) -> Result<Self, Undecoded> {
        let mut stream = Self {
            source: Source {
                section,
                hidden,
                position: 0,
            },
            channels,
            decoding: None,
            blocks: VecDeque::new(),
            kept: 0,
        };
        stream.restart().ok_or_else(|| undecoded(0))?;
        Ok(stream)
    }

    /// Starts from the first sample.
    fn restart(&mut self) -> Option<()> {
        let source = Box::new(self.source.clone());
        self.decoding = guarded(|| {
            let stream = MediaSourceStream::new(source, Default::default());
            let reader = FlacReader::try_new(stream, FormatOptions::default()).ok()?;
            let track = reader.tracks().first()?;
            let parameters = track.codec_params.as_ref()?.audio()?;
            let decoder = FlacDecoder::try_new(parameters, &AudioDecoderOptions::default()).ok()?;
            Some(Decoding { reader, decoder })
        })
        .flatten();
        self.blocks.clear();
        self.kept = 0;
        self.decoding.as_ref().map(|_| ())
    }

    /// Decodes the next block; `None` at the end and where it cannot be decoded.
    fn next_block(&mut self) -> Option<()> {
        let channels = self.channels;
        let decoding = self.decoding.as_mut()?;
        let block = guarded(|| {
            let packet = decoding.reader.next_packet().ok()??;
            let start = u64::try_from(packet.pts.get()).ok()?;
            let decoded = decoding.decoder.decode(&packet).ok()?;
            if decoded.num_planes() != channels {
                return None;
            }
            let frames = decoded.frames() as u64;
            let mut samples: Vec<i32> = Vec::new();
            decoded.copy_to_vec_interleaved(&mut samples);
            Some(Block {
                start,
                frames,
                samples,
            })
        });
        let Some(block) = block.flatten().filter(|block| block.frames > 0) else {
            // What was decoded may be in any state.
            self.decoding = None;
            return None;
        };
        if self
            .blocks
            .back()
            .is_some_and(|last| last.end() != block.start)
        {
            self.blocks.clear();
            self.kept = 0;
        }
        self.kept += block.samples.len();
        self.blocks.push_back(block);
        while self.kept > MOST_SAMPLES
            && self.blocks.len() > 1
            && let Some(first) = self.blocks.pop_front()
        {
            self.kept -= first.samples.len();
        }
        Some(())
    }

    /// Makes the block that has a frame the one at hand, if it can be decoded.
    fn reach(&mut self, frame: u64) -> Option<usize> {
        if let Some(place) = self.place(frame) {
            return Some(place);
        }
        let end = self.blocks.back().map(Block::end);
        let is_near = end.is_some_and(|end| frame >= end && frame - end < NEAR_FRAMES);
        if !is_near || self.decoding.is_none() {
            self.search(frame)?;
        }
        while self.blocks.back().is_none_or(|block| block.end() <= frame) {
            self.next_block()?;
        }
        self.place(frame)
    }

    fn place(&self, frame: u64) -> Option<usize> {
        let place = self.blocks.partition_point(|block| block.end() <= frame);
        let block = self.blocks.get(place)?;
        (block.start <= frame).then_some(place)
    }

    /// Goes to a frame, or to the start where the search fails.
    fn search(&mut self, frame: u64) -> Option<()> {
        self.restart()?;
        if frame < NEAR_FRAMES {
            return Some(());
        }
        let decoding = self.decoding.as_mut()?;
        let to = SeekTo::Timestamp {
            ts: Timestamp::new(i64::try_from(frame).ok()?),
            track_id: 0,
        };
        let found = guarded(|| decoding.reader.seek(SeekMode::Accurate, to).ok()).flatten();
        let is_before = found.is_some_and(|position| {
            u64::try_from(position.actual_ts.get()).is_ok_and(|start| start <= frame)
        });
        if is_before { Some(()) } else { self.restart() }
    }

    /// Returns the number of frames that can be decoded, of those that the file states.
    ///
    /// # Errors
    /// Samples cannot be decoded.
    pub fn count(&mut self, stated: Option<u64>) -> Result<u64, Undecoded> {
        let Some(stated) = stated else {
            self.restart().ok_or_else(|| undecoded(0))?;
            let mut frames = 0;
            while self.next_block().is_some() {
                frames = self.blocks.back().map_or(frames, Block::end);
            }
            return Ok(frames);
        };
        if self.reach(stated - 1).is_some() {
            return Ok(stated);
        }
        // The end is missing: the last frame that can be reached lies between these.
        let (mut there, mut beyond) = (0, stated - 1);
        while beyond - there > 1 {
            let middle = there + (beyond - there) / 2;
            match self.reach(middle) {
                Some(place) => there = self.blocks[place].end().clamp(middle, beyond),
                None => beyond = middle,
            }
            if there >= beyond {
                break;
            }
        }
        Ok(there)
    }

    /// Calls `visitor` with the samples `range` of a channel.
    ///
    /// # Errors
    /// Samples cannot be decoded.
    pub fn read(
        &mut self,
        range: Range<u64>,
        channel: usize,
        mut visitor: impl FnMut(f64),
    ) -> Result<(), Undecoded> {
        let mut frame = range.start;
        while frame < range.end {
            let place = self.reach(frame).ok_or_else(|| undecoded(frame))?;
            let block = &self.blocks[place];
            let end = block.end().min(range.end);
            let first = (frame - block.start) as usize;
            let count = (end - frame) as usize;
            let frames = block.samples.chunks_exact(self.channels);
            for samples in frames.skip(first).take(count) {
                visitor(f64::from(samples[channel]) / FULL_SCALE);
            }
            frame = end;
        }
        Ok(())
    }
}

/// Creates the refusal of samples that cannot be decoded.
fn undecoded(frame: u64) -> Undecoded {
    Undecoded { frame }
}
