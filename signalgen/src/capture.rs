//! Input direction: passes blocks of samples through a ring, with an account of every frame.

use rtrb::{Consumer, Producer, RingBuffer};

use crate::{
    drive_handle::DriveMonitor,
    generator::DriveState,
    input_tap::{self, InputTap, TapWriter},
    sample::ConverterSample,
    stream_health::{StreamDirection, StreamHealth},
    stream_layout::{LayoutError, nonzero},
};

/// Time of a block on the stream's clock, ns. Clocks of different streams need not share an origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlockTime {
    /// Time at which the callback was invoked.
    pub callback_ns: u64,
    /// Time at which the first frame was captured, as the backend estimates it.
    pub capture_ns: u64,
}

/// Account of a block of frames: position, losses, times, and the state of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockHeader {
    /// Index of the first frame among all frames delivered to the input callback, dropped ones included: if it exceeds the end
    /// of the previous block, the ring was full in between. Frames lost in an xrun are not counted, because backends do not
    /// report their number.
    pub first_frame: u64,
    /// Number of frames in the block.
    pub frames: u32,
    /// Number of frames dropped so far because the ring was full.
    pub dropped_frames: u64,
    /// Time on the stream's clock.
    pub time: BlockTime,
    /// Time of arrival on the monotonic clock of [`StreamHealth::now_ns`].
    pub arrived_ns: u64,
    /// Number of xruns of the input so far.
    pub input_xruns: u64,
    /// Number of xruns of the output so far.
    pub output_xruns: u64,
    /// State of the drive as last published when the block arrived.
    pub drive: DriveState,
}

/// Body of the input callback: passes blocks of samples with their headers to its [`InputReader`].
pub struct InputWriter {
    samples: Producer<f32>,
    headers: Producer<BlockHeader>,
    health: StreamHealth,
    drive: DriveMonitor,
    last_drive: DriveState,
    channels: usize,
    frames: u64,
    dropped_frames: u64,
    tap: Option<TapWriter>,
}

/// Reading side of the input, with one owner.
#[derive(Debug)]
pub struct InputReader {
    samples: Consumer<f32>,
    headers: Consumer<BlockHeader>,
    channels: usize,
    health: StreamHealth,
}

impl InputWriter {
    /// Connects a writer to a reader, with room for `ring_frames` frames in blocks of at least `fewest_frames`; smaller blocks
    /// fill the ring sooner. Allocates the ring.
    ///
    /// # Errors
    /// If any of the numbers is 0.
    pub fn connect(
        channels: usize,
        ring_frames: usize,
        fewest_frames: usize,
        health: StreamHealth,
        drive: DriveMonitor,
    ) -> Result<(Self, InputReader), LayoutError> {
        nonzero("input.channels", channels)?;
        nonzero("ring_frames", ring_frames)?;
        nonzero("fewest_frames", fewest_frames)?;
        let (sample_producer, sample_consumer) = RingBuffer::new(ring_frames * channels);
        let (header_producer, header_consumer) =
            RingBuffer::new(ring_frames.div_ceil(fewest_frames).max(2));
        let writer = Self {
            samples: sample_producer,
            headers: header_producer,
            health: health.clone(),
            drive,
            last_drive: DriveState::default(),
            channels,
            frames: 0,
            dropped_frames: 0,
            tap: None,
        };
        let reader = InputReader {
            samples: sample_consumer,
            headers: header_consumer,
            channels,
            health,
        };
        Ok((writer, reader))
    }

    /// Adds a second reader of `channels`, with a ring of `ring_frames` frames in blocks of at least `fewest_frames`. Allocates
    /// the ring.
    ///
    /// # Errors
    /// If any of the numbers is 0, or there are no channels.
    pub fn tap(
        &mut self,
        channels: &[u16],
        ring_frames: usize,
        fewest_frames: usize,
    ) -> Result<InputTap, LayoutError> {
        nonzero("tap.channels", channels.len())?;
        nonzero("ring_frames", ring_frames)?;
        nonzero("fewest_frames", fewest_frames)?;
        let channels: Vec<usize> = channels.iter().copied().map(usize::from).collect();
        let (writer, tap) = input_tap::connect(&channels, ring_frames, fewest_frames);
        self.tap = Some(writer);
        Ok(tap)
    }

    /// Passes one block of interleaved samples to the reader, or drops and counts it whole if the ring has no room.
    ///
    /// Neither allocates, locks, logs nor panics; asserted by `tests/integration/real_time.rs` and, through cpal,
    /// `tests/integration/duplex`.
    pub fn take<T: ConverterSample>(&mut self, block: &[T], time: BlockTime) {
        let arrived_ns = self.health.beat(StreamDirection::Input);
        let frames = block.len() / self.channels;
        let first_frame = self.frames;
        self.frames += frames as u64;
        if let Some(tap) = &mut self.tap {
            tap.take(first_frame, block, self.channels);
        }
        if let Some(state) = self.drive.try_state() {
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
            input_xruns: self.health.xruns(StreamDirection::Input),
            output_xruns: self.health.xruns(StreamDirection::Output),
            drive: self.last_drive,
        };
        // `push` found room, and only this writer fills it.
        let _ = self.headers.push(header);
    }

    /// Pushes the samples if there is room for them and a header; returns whether it did.
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
    /// Returns the xruns of input and output once a stream has ended and no later block can report them.
    #[must_use]
    pub fn last_xruns(&self) -> Option<(u64, u64)> {
        let [input, output] = [StreamDirection::Input, StreamDirection::Output]
            .map(|direction| self.health.read(direction));
        let is_lost = input.device_lost || output.device_lost;
        is_lost.then_some((input.xruns, output.xruns))
    }

    /// Takes the oldest block, or returns `None` if no block is waiting. Its interleaved samples, in units of full
    /// scale, replace the content of `samples`. Lock-free.
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

    /// Returns the number of samples per frame.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Returns how full the ring is, 0 to 1.
    #[must_use]
    pub fn ring_fill(&self) -> f64 {
        let fill = |slots: usize, capacity: usize| slots as f64 / capacity as f64;
        fill(self.samples.slots(), self.samples.buffer().capacity())
            .max(fill(self.headers.slots(), self.headers.buffer().capacity()))
    }

    /// Returns whether the input stream is closed; blocks may still be waiting.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.headers.is_abandoned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive_handle::DriveHandle;

    #[test]
    fn layouts_without_channels_or_frames_are_refused() {
        let (drive, ..) = DriveHandle::connect();
        let connect = |channels, ring_frames, fewest_frames| {
            let health = StreamHealth::new();
            InputWriter::connect(
                channels,
                ring_frames,
                fewest_frames,
                health,
                drive.monitor(),
            )
            .map(|_| ())
        };
        assert_eq!(connect(1, 1, 1), Ok(()));
        for (result, parameter) in [
            (connect(0, 1, 1), "input.channels"),
            (connect(1, 0, 1), "ring_frames"),
            (connect(1, 1, 0), "fewest_frames"),
        ] {
            assert_eq!(result, Err(LayoutError::Zero { parameter }));
        }
    }
}
