//! The input direction: blocks of samples out through a ring, with an account of every frame.

use rtrb::{Consumer, Producer, RingBuffer};

use crate::{
    drive::DriveMonitor,
    generator::DriveState,
    health::{Direction, Health},
    sample::ConverterSample,
};

/// When a block was taken, on the stream's clock, ns. Its origin is not that of another stream's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlockTime {
    /// When the callback was invoked.
    pub callback_ns: u64,
    /// When the first frame was captured, as the backend estimates it.
    pub capture_ns: u64,
}

/// What came with a block of frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockHeader {
    /// Index of the first frame among all frames delivered to the input callback, the dropped ones
    /// included: where it is more than the end of the block before, the ring was full between.
    /// Frames lost in an xrun are not counted; no backend says how many they are.
    pub first_frame: u64,
    /// Frames in the block.
    pub frames: u32,
    /// Frames dropped so far for want of room in the ring.
    pub dropped_frames: u64,
    /// Time on the stream's clock.
    pub time: BlockTime,
    /// Time of arrival on the monotonic clock of [`Health::now_ns`].
    pub arrived_ns: u64,
    /// Xruns of the input so far.
    pub input_xruns: u64,
    /// Xruns of the output so far.
    pub output_xruns: u64,
    /// The drive as last published when the block arrived.
    pub drive: DriveState,
}

/// The body of the input callback.
pub(crate) struct InputCallback {
    samples: Producer<f32>,
    headers: Producer<BlockHeader>,
    health: Health,
    drive: DriveMonitor,
    last_drive: DriveState,
    channels: usize,
    frames: u64,
    dropped_frames: u64,
}

/// The reading side of the input; one owner.
#[derive(Debug)]
pub struct InputReader {
    samples: Consumer<f32>,
    headers: Consumer<BlockHeader>,
    channels: usize,
}

/// The two ends of the input direction, with room for `ring_frames` frames in blocks of no fewer
/// than `fewest_frames`; smaller ones fill the ring sooner.
pub(crate) fn connect(
    channels: usize,
    ring_frames: usize,
    fewest_frames: usize,
    health: Health,
    drive: DriveMonitor,
) -> (InputCallback, InputReader) {
    let (sample_producer, sample_consumer) = RingBuffer::new(ring_frames * channels);
    let (header_producer, header_consumer) =
        RingBuffer::new(ring_frames.div_ceil(fewest_frames).max(2));
    let callback = InputCallback {
        samples: sample_producer,
        headers: header_producer,
        health,
        drive,
        last_drive: DriveState::default(),
        channels,
        frames: 0,
        dropped_frames: 0,
    };
    let reader = InputReader {
        samples: sample_consumer,
        headers: header_consumer,
        channels,
    };
    (callback, reader)
}

impl InputCallback {
    /// Passes one block of interleaved samples to the reader, or drops and counts it whole if the
    /// ring has no room for it. Neither allocates, locks, logs nor panics; asserted by
    /// `tests/duplex.rs`.
    pub(crate) fn take<T: ConverterSample>(&mut self, block: &[T], time: BlockTime) {
        let arrived_ns = self.health.beat(Direction::Input);
        let frames = block.len() / self.channels;
        let first_frame = self.frames;
        self.frames += frames as u64;
        if let Some(state) = self.drive.try_published() {
            self.last_drive = state;
        }
        if !self.push(&block[..frames * self.channels]) {
            self.dropped_frames += frames as u64;
            return;
        }
        let header = BlockHeader {
            first_frame,
            frames: frames as u32,
            dropped_frames: self.dropped_frames,
            time,
            arrived_ns,
            input_xruns: self.health.xruns(Direction::Input),
            output_xruns: self.health.xruns(Direction::Output),
            drive: self.last_drive,
        };
        // Room was seen in `push`, and nobody else fills it.
        let _ = self.headers.push(header);
    }

    /// Whether the samples went in; the header's place is made sure of first.
    fn push<T: ConverterSample>(&mut self, samples: &[T]) -> bool {
        if self.headers.is_full() {
            return false;
        }
        match self.samples.write_chunk_uninit(samples.len()) {
            Ok(room) => {
                room.fill_from_iter(samples.iter().map(|sample| sample.to_unit()));
                true
            }
            Err(_) => false,
        }
    }
}

impl InputReader {
    /// Takes the oldest block: its interleaved samples, in units of full scale, replace the content
    /// of `samples`. `None` if no block is waiting. Lock-free.
    pub fn pop_block(&mut self, samples: &mut Vec<f32>) -> Option<BlockHeader> {
        let header = self.headers.pop().ok()?;
        samples.clear();
        // The samples were pushed before their header.
        if let Ok(chunk) = self
            .samples
            .read_chunk(header.frames as usize * self.channels)
        {
            let (first, second) = chunk.as_slices();
            samples.extend_from_slice(first);
            samples.extend_from_slice(second);
            chunk.commit_all();
        }
        Some(header)
    }

    /// Samples per frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// How full the ring is, 0 to 1.
    #[must_use]
    pub fn ring_fill(&self) -> f64 {
        let filled = |slots: usize, capacity: usize| slots as f64 / capacity as f64;
        filled(self.samples.slots(), self.samples.buffer().capacity()).max(filled(
            self.headers.slots(),
            self.headers.buffer().capacity(),
        ))
    }

    /// Whether the input stream is closed; blocks may still be waiting.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.headers.is_abandoned()
    }
}
