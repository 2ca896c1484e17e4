//! Second reader of some input channels, independent of the first.

use rtrb::{Consumer, Producer, RingBuffer};

use crate::sample::ConverterSample;

/// A block of tapped frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TapBlock {
    /// Index of the first frame, counted as in [`BlockHeader::first_frame`](crate::BlockHeader): if it exceeds the end of the
    /// previous block, the tap's own ring was full in between.
    pub first_frame: u64,
    /// Number of frames in the block.
    pub frames: u32,
}

/// Writing side, within the input callback.
pub(crate) struct TapWriter {
    channels: Vec<usize>,
    samples: Producer<f32>,
    blocks: Producer<TapBlock>,
}

/// Reading side of a tap, with one owner.
#[derive(Debug)]
pub struct InputTap {
    channels: usize,
    samples: Consumer<f32>,
    blocks: Consumer<TapBlock>,
}

/// Connects both sides of a tap of `channels`, with room for `ring_frames` frames in blocks of at least `fewest_frames`.
/// Allocates the rings.
pub(crate) fn connect(
    channels: &[usize],
    ring_frames: usize,
    fewest_frames: usize,
) -> (TapWriter, InputTap) {
    let (sample_producer, sample_consumer) = RingBuffer::new(ring_frames * channels.len());
    let (block_producer, block_consumer) =
        RingBuffer::new(ring_frames.div_ceil(fewest_frames.max(1)).max(2));
    let writer = TapWriter {
        channels: channels.to_vec(),
        samples: sample_producer,
        blocks: block_producer,
    };
    let tap = InputTap {
        channels: channels.len(),
        samples: sample_consumer,
        blocks: block_consumer,
    };
    (writer, tap)
}

impl TapWriter {
    /// Passes on the tapped channels of an interleaved block of `channel_count` channels, or drops the whole block if
    /// there is no room. Neither allocates, locks, logs nor panics.
    pub(crate) fn take<T: ConverterSample>(
        &mut self,
        first_frame: u64,
        block: &[T],
        channel_count: usize,
    ) {
        let frames = block.len() / channel_count;
        if self.blocks.is_full() {
            return;
        }
        let Ok(room) = self
            .samples
            .write_chunk_uninit(frames * self.channels.len())
        else {
            return;
        };
        let channels = &self.channels;
        room.fill_from_iter(block.chunks_exact(channel_count).flat_map(|frame| {
            channels.iter().map(|&channel| {
                frame
                    .get(channel)
                    .map_or(f32::NAN, |sample| sample.to_unit())
            })
        }));
        // There was room, and only this writer fills it.
        let _ = self.blocks.push(TapBlock {
            first_frame,
            frames: frames as u32,
        });
    }
}

impl InputTap {
    /// Takes the oldest block, or returns `None` if no block is waiting. Its interleaved samples, in units of full
    /// scale, replace the content of `samples`. Lock-free.
    pub fn pop_block(&mut self, samples: &mut Vec<f32>) -> Option<TapBlock> {
        let block = self.blocks.pop().ok()?;
        samples.clear();
        if let Ok(chunk) = self
            .samples
            .read_chunk(block.frames as usize * self.channels)
        {
            let (first, second) = chunk.as_slices();
            samples.extend_from_slice(first);
            samples.extend_from_slice(second);
            chunk.commit_all();
        }
        Some(block)
    }

    /// Returns the number of tapped channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Returns both sides of a tap without a stream, for tests and simulations.
    #[must_use]
    pub fn with_feed(channels: usize, ring_frames: usize) -> (TapFeed, Self) {
        let indices: Vec<usize> = (0..channels).collect();
        let (writer, tap) = connect(&indices, ring_frames, 1);
        (TapFeed { writer, channels }, tap)
    }
}

/// Writing side of a tap without a stream.
pub struct TapFeed {
    writer: TapWriter,
    channels: usize,
}

impl TapFeed {
    /// Passes on interleaved frames; `first_frame` is the index of the first.
    pub fn feed(&mut self, first_frame: u64, frames: &[f32]) {
        self.writer.take(first_frame, frames, self.channels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tapped_channels_keep_their_order_and_an_overflow_is_a_gap() {
        let (mut writer, mut tap) = connect(&[2, 0], 8, 1);
        let block = |first: u64| -> Vec<f32> {
            (0..4u64)
                .flat_map(|i| [0.0, 0.25, 0.5].map(|part: f32| part + (first + i) as f32))
                .collect()
        };
        for first in [0, 4, 8] {
            writer.take(first, &block(first), 3);
        }
        let mut samples = Vec::new();
        let first = tap.pop_block(&mut samples).unwrap();
        assert_eq!((first.first_frame, first.frames), (0, 4));
        assert_eq!(samples[..4], [0.5, 0.0, 1.5, 1.0]);
        writer.take(12, &block(12), 3);
        let blocks: Vec<u64> = std::iter::from_fn(|| tap.pop_block(&mut samples))
            .map(|block| block.first_frame)
            .collect();
        assert_eq!(blocks, [4, 12], "8 found no room");
        assert_eq!((samples.len(), tap.channels()), (8, 2));
    }
}
