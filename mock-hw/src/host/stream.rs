//! One direction of a device: its stream, buffer and faults.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cpal::{
    Data, Error, ErrorKind, InputCallbackInfo, InputStreamTimestamp, OutputCallbackInfo,
    OutputStreamTimestamp, SampleFormat, StreamInstant,
};

pub(super) type OutputCallback = Box<dyn FnMut(&mut Data, &OutputCallbackInfo) + Send>;
pub(super) type InputCallback = Box<dyn FnMut(&Data, &InputCallbackInfo) + Send>;
pub(super) type ErrorCallback = Box<dyn FnMut(Error) + Send>;

/// Interleaved samples in the stream's own format.
enum StreamSamples {
    F32(Vec<f32>),
    I32(Vec<i32>),
    I16(Vec<i16>),
}

const I32_SCALE: f64 = 2_147_483_648.0;
const I16_SCALE: f32 = 32_768.0;

impl StreamSamples {
    fn new(format: SampleFormat, len: usize) -> Option<Self> {
        match format {
            SampleFormat::F32 => Some(Self::F32(vec![0.0; len])),
            SampleFormat::I32 => Some(Self::I32(vec![0; len])),
            SampleFormat::I16 => Some(Self::I16(vec![0; len])),
            _ => None,
        }
    }

    #[expect(unsafe_code, reason = "cpal's buffers are type-erased; no safe way")]
    fn data(&mut self) -> Data {
        let (start, len, format) = match self {
            Self::F32(v) => (v.as_mut_ptr().cast(), v.len(), SampleFormat::F32),
            Self::I32(v) => (v.as_mut_ptr().cast(), v.len(), SampleFormat::I32),
            Self::I16(v) => (v.as_mut_ptr().cast(), v.len(), SampleFormat::I16),
        };
        // SAFETY: start and len are those of a live vector of the named format; the callers lend
        // the result to one callback and drop it before they touch the vector again.
        unsafe { Data::from_parts(start, len, format) }
    }

    fn get(&self, index: usize) -> f32 {
        match self {
            Self::F32(v) => v[index],
            Self::I32(v) => (f64::from(v[index]) / I32_SCALE) as f32,
            Self::I16(v) => f32::from(v[index]) / I16_SCALE,
        }
    }

    fn set(&mut self, index: usize, sample: f32) {
        // Float to integer casts saturate, as a converter clips.
        match self {
            Self::F32(v) => v[index] = sample,
            Self::I32(v) => v[index] = (f64::from(sample) * I32_SCALE) as i32,
            Self::I16(v) => v[index] = (sample * I16_SCALE).round() as i16,
        }
    }
}

/// Buffer of a stream in either direction.
pub(super) struct Buffer {
    samples: StreamSamples,
    channels: usize,
    frames: usize,
    /// Index of the next frame to play or fill.
    cursor: usize,
    running: Arc<AtomicBool>,
    on_error: ErrorCallback,
}

impl Buffer {
    /// Returns an empty buffer; `None` for a format that is not simulated.
    pub(super) fn new(
        format: SampleFormat,
        channels: u16,
        frames: u32,
        running: Arc<AtomicBool>,
        on_error: ErrorCallback,
    ) -> Option<Self> {
        let (channels, frames) = (usize::from(channels), frames as usize);
        Some(Self {
            samples: StreamSamples::new(format, channels * frames)?,
            channels,
            frames,
            cursor: 0,
            running,
            on_error,
        })
    }
}

pub(super) struct OutputStream {
    buffer: Buffer,
    callback: OutputCallback,
}

pub(super) struct InputStream {
    buffer: Buffer,
    callback: InputCallback,
    /// Simulated sampling time of the first frame in the buffer, ns.
    first_ns: u64,
}

impl OutputStream {
    pub(super) fn new(mut buffer: Buffer, callback: OutputCallback) -> Self {
        buffer.cursor = buffer.frames;
        Self { buffer, callback }
    }

    fn refill(&mut self, now_ns: u64) {
        let now = StreamInstant::from_nanos(now_ns);
        let info = OutputCallbackInfo::new(OutputStreamTimestamp {
            callback: now,
            playback: now,
        });
        (self.callback)(&mut self.buffer.samples.data(), &info);
        self.buffer.cursor = 0;
    }
}

impl InputStream {
    pub(super) fn new(buffer: Buffer, callback: InputCallback) -> Self {
        Self {
            buffer,
            callback,
            first_ns: 0,
        }
    }

    fn deliver(&mut self, now_ns: u64) {
        let info = InputCallbackInfo::new(InputStreamTimestamp {
            callback: StreamInstant::from_nanos(now_ns),
            capture: StreamInstant::from_nanos(self.first_ns),
        });
        (self.callback)(&self.buffer.samples.data(), &info);
        self.buffer.cursor = 0;
    }
}

pub(super) trait Opened {
    fn buffer(&mut self) -> &mut Buffer;
    /// Discards a partly played or partly filled buffer of a stopped stream.
    fn rewind(&mut self);
}

impl Opened for OutputStream {
    fn buffer(&mut self) -> &mut Buffer {
        &mut self.buffer
    }

    fn rewind(&mut self) {
        self.buffer.cursor = self.buffer.frames;
    }
}

impl Opened for InputStream {
    fn buffer(&mut self) -> &mut Buffer {
        &mut self.buffer
    }

    fn rewind(&mut self) {
        self.buffer.cursor = 0;
    }
}

/// One direction of a device: at most one stream, and its injected faults.
pub(super) struct Track<S> {
    stream: Option<S>,
    errors: VecDeque<ErrorKind>,
    /// Number of coming frames to lose.
    skip: u64,
    /// Number of coming frames to replace by NaN.
    nan_frames: u64,
    is_halted: bool,
}

impl<S> Default for Track<S> {
    fn default() -> Self {
        Self {
            stream: None,
            errors: VecDeque::new(),
            skip: 0,
            nan_frames: 0,
            is_halted: false,
        }
    }
}

impl<S: Opened> Track<S> {
    pub(super) fn is_open(&self) -> bool {
        self.stream.is_some()
    }

    /// Whether its stream plays.
    pub(super) fn is_running(&mut self) -> bool {
        let stream = self.stream.as_mut();
        stream.is_some_and(|stream| stream.buffer().running.load(Ordering::Acquire))
    }

    pub(super) fn open(&mut self, stream: S) {
        self.stream = Some(stream);
    }

    /// Removes the stream with the handle `running`.
    pub(super) fn close(&mut self, running: &Arc<AtomicBool>) -> Option<S> {
        self.stream
            .take_if(|stream| Arc::ptr_eq(&stream.buffer().running, running))
    }

    pub(super) fn inject(&mut self, kind: ErrorKind) {
        self.errors.push_back(kind);
    }

    pub(super) fn skip(&mut self, frames: u64) {
        self.skip += frames;
    }

    pub(super) fn spoil(&mut self, frames: u64) {
        self.nan_frames += frames;
    }

    pub(super) fn halt(&mut self, is_halted: bool) {
        self.is_halted = is_halted;
    }

    /// Reports pending errors, then returns the stream if it runs.
    fn playing_stream(&mut self) -> Option<(&mut S, &mut u64)> {
        let stream = self.stream.as_mut()?;
        while let Some(kind) = self.errors.pop_front() {
            (stream.buffer().on_error)(Error::new(kind));
        }
        if !stream.buffer().running.load(Ordering::Acquire) {
            stream.rewind();
            return None;
        }
        (!self.is_halted).then_some((stream, &mut self.skip))
    }
}

fn frame_ns(start_ns: u64, frame: usize, rate_hz: u32) -> u64 {
    start_ns + frame as u64 * 1_000_000_000 / u64::from(rate_hz)
}

impl Track<OutputStream> {
    /// Plays `frames` frames into `first_channel(frame, sample)`; returns the number that came from the callback's buffers.
    pub(super) fn play(
        &mut self,
        start_ns: u64,
        rate_hz: u32,
        frames: usize,
        mut first_channel: impl FnMut(usize, f32),
    ) -> u64 {
        let Some((stream, skip)) = self.playing_stream() else {
            return 0;
        };
        let mut played_frames = 0;
        for frame in 0..frames {
            if stream.buffer.cursor == stream.buffer.frames {
                if *skip > 0 {
                    *skip -= 1;
                    continue;
                }
                stream.refill(frame_ns(start_ns, frame, rate_hz));
            }
            let buffer = &mut stream.buffer;
            first_channel(frame, buffer.samples.get(buffer.cursor * buffer.channels));
            buffer.cursor += 1;
            played_frames += 1;
        }
        played_frames
    }
}

impl Track<InputStream> {
    /// Records interleaved frames of `device_channels`; the stream takes the first channels.
    pub(super) fn record(
        &mut self,
        start_ns: u64,
        rate_hz: u32,
        interleaved: &[f32],
        device_channels: usize,
    ) {
        let mut nan_frames = std::mem::take(&mut self.nan_frames);
        let Some((stream, skip)) = self.playing_stream() else {
            return;
        };
        for (frame, inputs) in interleaved.chunks_exact(device_channels).enumerate() {
            if stream.buffer.cursor == 0 {
                if *skip > 0 {
                    *skip -= 1;
                    continue;
                }
                stream.first_ns = frame_ns(start_ns, frame, rate_hz);
            }
            let buffer = &mut stream.buffer;
            let index = buffer.cursor * buffer.channels;
            let is_sound = nan_frames == 0;
            nan_frames = nan_frames.saturating_sub(1);
            for (channel, &sample) in inputs[..buffer.channels].iter().enumerate() {
                let sample = if is_sound { sample } else { f32::NAN };
                buffer.samples.set(index + channel, sample);
            }
            buffer.cursor += 1;
            if buffer.cursor == buffer.frames {
                stream.deliver(frame_ns(start_ns, frame + 1, rate_hz));
            }
        }
        self.nan_frames = nan_frames;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_format_keeps_a_sample_to_its_resolution_and_clips_at_full_scale() {
        for (format, resolution) in [
            (SampleFormat::F32, 0.0),
            (SampleFormat::I32, 2f32.powi(-24)),
            (SampleFormat::I16, 2f32.powi(-15)),
        ] {
            let mut samples = StreamSamples::new(format, 1).unwrap();
            for value in [-1.0, -0.3, 0.0, 1e-3, 0.7] {
                samples.set(0, value);
                let error = (samples.get(0) - value).abs();
                assert!(error <= resolution, "{format}: {value} is off by {error}");
            }
            samples.set(0, 1.5);
            let clip_level = samples.get(0);
            assert_eq!(clip_level > 1.0, format == SampleFormat::F32, "{format}");
        }
        assert!(StreamSamples::new(SampleFormat::F64, 1).is_none());
    }
}
