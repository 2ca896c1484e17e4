//! State of the simulated sound cards, shared by their cpal devices and the simulation.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use cpal::{ErrorKind, SampleFormat};

use super::stream::{InputStream, OutputStream, Track};
use crate::world_clock::{BASE_RATE_HZ, WorldClock, WorldPace};
use mock_world::scenario::{self, ConverterTable};

/// Id of the bench's converter.
pub const BENCH_ID: &str = "sim";
/// Id of the output for cue sounds.
pub const SPEAKERS_ID: &str = "sim-speakers";
/// Sample rates of the bench's converter, Hz.
pub const BENCH_RATES_HZ: [u32; 2] = [96_000, 192_000];
/// Sampling rates of the bench's converter if it is a data acquisition card, Hz.
pub const CARD_RATES_HZ: [u32; 3] = [100_000, 125_000, 250_000];
/// Number of output channels of the bench's converter; the first drives the plate.
pub const BENCH_OUTPUTS: u16 = 2;
/// Sample rate of the speakers, Hz.
pub const SPEAKERS_RATE_HZ: u32 = 48_000;

/// Direction of the bench's converter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConverterDirection {
    /// Output, from the bench to the plate.
    Output,
    /// Input, from the sensors to the bench.
    Input,
}

/// Both sound cards, with their open streams.
pub(crate) struct SoundCards {
    pub(super) clock: Arc<WorldClock>,
    /// Number of input channels of the bench's converter.
    pub(crate) inputs: u16,
    /// Sample rates of the bench's converter, Hz.
    pub(super) rates_hz: &'static [u32],
    /// Bits of the time from one input's sample to the next input's, s.
    stagger_s: AtomicU64,
    /// Sample formats of the bench's converter.
    pub(super) formats: Vec<SampleFormat>,
    pub(super) bench: Mutex<BenchCard>,
    pub(super) speakers: Mutex<Track<OutputStream>>,
    speaker_frames: AtomicU64,
}

/// Returns cpal's sample format.
fn cpal_format(format: scenario::OfferedFormat) -> SampleFormat {
    match format {
        scenario::OfferedFormat::F32 => SampleFormat::F32,
        scenario::OfferedFormat::I32 => SampleFormat::I32,
        scenario::OfferedFormat::I16 => SampleFormat::I16,
        scenario::OfferedFormat::U8 => SampleFormat::U8,
        scenario::OfferedFormat::I64 => SampleFormat::I64,
    }
}

/// The bench's converter.
pub(super) struct BenchCard {
    /// Rate of the stream opened last, Hz.
    pub(super) rate_hz: u32,
    pub(super) output: Track<OutputStream>,
    pub(super) input: Track<InputStream>,
}

impl SoundCards {
    /// Returns both sound cards without open streams.
    pub(crate) fn new(
        clock: Arc<WorldClock>,
        converter: &ConverterTable,
        acquisition_card: bool,
    ) -> Arc<Self> {
        Arc::new(Self {
            clock,
            rates_hz: if acquisition_card {
                &CARD_RATES_HZ
            } else {
                &BENCH_RATES_HZ
            },
            stagger_s: AtomicU64::new(0),
            inputs: converter.channels as u16,
            formats: converter
                .formats
                .iter()
                .map(|format| cpal_format(*format))
                .collect(),
            bench: Mutex::new(BenchCard {
                rate_hz: BASE_RATE_HZ,
                output: Track::default(),
                input: Track::default(),
            }),
            speakers: Mutex::default(),
            speaker_frames: AtomicU64::new(0),
        })
    }

    /// Returns the pace of the simulation.
    pub(crate) fn pace(&self) -> WorldPace {
        self.clock.pace()
    }

    /// Returns the present rate of the bench's converter, Hz.
    pub(crate) fn rate_hz(&self) -> u32 {
        lock(&self.bench).rate_hz
    }

    /// Sets the time between the samples of successive inputs, s; 0 for simultaneous sampling.
    pub(crate) fn stagger(&self, stagger_s: f64) {
        self.stagger_s.store(stagger_s.to_bits(), Ordering::Release);
    }

    /// Returns the time from one input's sample to the next input's, s.
    pub(crate) fn stagger_s(&self) -> f64 {
        f64::from_bits(self.stagger_s.load(Ordering::Acquire))
    }

    /// Whether a stream of the bench's converter is open.
    pub(crate) fn is_open(&self) -> bool {
        let bench = lock(&self.bench);
        bench.output.is_open() || bench.input.is_open()
    }

    /// Whether both streams of the bench's converter play.
    pub(crate) fn is_running(&self) -> bool {
        let mut bench = lock(&self.bench);
        bench.output.is_running() && bench.input.is_running()
    }

    /// Returns the number of frames that the speakers have played.
    pub(crate) fn speaker_frames(&self) -> u64 {
        self.speaker_frames.load(Ordering::Relaxed)
    }

    /// Fills `drive` with the first output channel from simulated time `start_ns`.
    pub(crate) fn play(&self, start_ns: u64, rate_hz: u32, drive: &mut [f32]) {
        drive.fill(0.0);
        lock(&self.bench)
            .output
            .play(start_ns, rate_hz, drive.len(), |frame, sample| {
                drive[frame] = sample;
            });
    }

    /// Passes interleaved samples of all channels of the device, from simulated time `start_ns`, to the input stream.
    pub(crate) fn record(&self, start_ns: u64, rate_hz: u32, inputs: &[f32]) {
        lock(&self.bench)
            .input
            .record(start_ns, rate_hz, inputs, usize::from(self.inputs));
    }

    /// Plays one period on the speakers.
    pub(crate) fn play_speakers(&self, start_ns: u64) {
        let frames = self.clock.period_frames_at(SPEAKERS_RATE_HZ);
        let played_frames =
            lock(&self.speakers).play(start_ns, SPEAKERS_RATE_HZ, frames, |_, _| {});
        self.speaker_frames
            .fetch_add(played_frames, Ordering::Relaxed);
    }

    /// Reports `kind` to the stream of a direction in the next period.
    pub(crate) fn inject(&self, direction: ConverterDirection, kind: ErrorKind) {
        match direction {
            ConverterDirection::Output => lock(&self.bench).output.inject(kind),
            ConverterDirection::Input => lock(&self.bench).input.inject(kind),
        }
    }

    /// Loses `frames` frames from the next buffer on: the output plays silence instead, or the input never delivers them.
    pub(crate) fn skip_frames(&self, direction: ConverterDirection, frames: u64) {
        match direction {
            ConverterDirection::Output => lock(&self.bench).output.skip(frames),
            ConverterDirection::Input => lock(&self.bench).input.skip(frames),
        }
    }

    /// Makes the next `frames` frames of the input NaN.
    pub(crate) fn spoil_frames(&self, frames: u64) {
        lock(&self.bench).input.spoil(frames);
    }

    /// Stops or resumes the callbacks of a direction.
    pub(crate) fn halt(&self, direction: ConverterDirection, halted: bool) {
        match direction {
            ConverterDirection::Output => lock(&self.bench).output.halt(halted),
            ConverterDirection::Input => lock(&self.bench).input.halt(halted),
        }
    }
}

/// Locks a part of the sound cards' state.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A panic in a callback affects only its own stream.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
