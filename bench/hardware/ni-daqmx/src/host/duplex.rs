//! Both directions of a card on one thread: it reads a block, writes a block, and passes on the block that was read.
//!
//! The outputs begin ahead by a lead of silence, and each block that is read is followed by a written block of the same
//! length: the lead neither grows nor shrinks. No sample is played twice or overwritten: a card that cannot continue
//! stops, and its stream reports it.
#![expect(unsafe_code, reason = "cpal's buffers are type-erased; no safe way")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use config::CardClock;
use cpal::{
    Data, Error, ErrorKind, InputCallbackInfo, InputStreamTimestamp, OutputCallbackInfo,
    OutputStreamTimestamp, SampleFormat, StreamInstant,
};

use super::deskew::{Deskew, HALF};
use super::plan::Plan;
use crate::library::{AnalogInput, AnalogOutput, DaqError, DaqFault, Daqmx, Timing};

/// Callback of the output stream.
pub(super) type OutputCallback = Box<dyn FnMut(&mut Data, &OutputCallbackInfo) + Send>;
/// Callback of the input stream.
pub(super) type InputCallback = Box<dyn FnMut(&Data, &InputCallbackInfo) + Send>;
/// Callback of a stream's errors.
pub(super) type ErrorCallback = Box<dyn FnMut(Error) + Send>;

/// Callbacks of both directions.
pub(super) struct Callbacks {
    pub(super) output: OutputCallback,
    pub(super) output_error: ErrorCallback,
    pub(super) input: InputCallback,
    pub(super) input_error: ErrorCallback,
}

/// Longest wait for a block, s, before the thread checks whether the stream is to end. The safety watch decides whether
/// the card has been silent for too long.
const PATIENCE_S: f64 = 0.05;
/// Length of the driver's input buffer, s: the longest time by which the computer may read late.
const INPUT_BUFFER_S: f64 = 1.0;
/// Time after the request to end in which the drive ramps to rest, s, including [`signalgen::EMERGENCY_RAMP_S`].
const REST_S: f64 = 2.0 * signalgen::EMERGENCY_RAMP_S;

/// A card that streams; dropping it stops the card.
pub(super) struct Running {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // A panic in a callback has been reported by its hook.
            let _ = thread.join();
        }
    }
}

/// Reason for which a card does not start to stream.
#[derive(Debug, thiserror::Error)]
pub(super) enum NotStarted {
    /// The library refused.
    #[error("{0}")]
    Library(#[from] DaqError),
    /// The card would use another rate than the requested one.
    #[error(
        "the card cannot run at {asked_hz} Hz ({key}) and would use {} Hz: set a rate in bench.toml that divides its time base",
        (.made_hz * 1e3).round() / 1e3
    )]
    Coerced {
        /// Key of `bench.toml`.
        key: &'static str,
        /// Requested rate, Hz.
        asked_hz: f64,
        /// Rate that the card would use, Hz.
        made_hz: f64,
    },
    /// The system cannot start a thread.
    #[error("no thread for the card: {}", bounded_files::cause(.0))]
    Thread(std::io::Error),
}

/// Starts both directions of a card.
///
/// # Errors
/// [`NotStarted`] names the reason; the outputs are then at 0 V if the card is present.
pub(super) fn start(
    library: &Daqmx,
    plan: &Plan,
    callbacks: Callbacks,
) -> Result<Running, NotStarted> {
    let mut streaming = Streaming::new(library, plan, callbacks)?;
    streaming.begin(plan)?;
    let stop = Arc::new(AtomicBool::new(false));
    let (stop_request, library, plan) = (Arc::clone(&stop), library.clone(), plan.clone());
    let thread = std::thread::Builder::new()
        .name("ni-card".to_owned())
        .spawn(move || {
            // Dropped last, after the tasks have released the outputs.
            let _rest = OutputsAtRest {
                library,
                plan: &plan,
            };
            let mut streaming = streaming;
            streaming.run(&plan, &stop_request);
        })
        .map_err(NotStarted::Thread)?;
    Ok(Running {
        stop,
        thread: Some(thread),
    })
}

/// Sets the outputs to 0 V when it is dropped, after any end of the thread: a card holds its last voltage, and a
/// callback that panics leaves it anywhere in the carrier's cycle.
struct OutputsAtRest<'a> {
    library: Daqmx,
    plan: &'a Plan,
}

impl Drop for OutputsAtRest<'_> {
    fn drop(&mut self) {
        let Plan { table, .. } = self.plan;
        // A missing card has no output to set.
        let _ = AnalogOutput::zero(&self.library, &self.plan.outputs(), table.output_range_v);
    }
}

struct Streaming {
    output: AnalogOutput,
    input: AnalogInput,
    callbacks: Callbacks,
    deskew: Option<Deskew>,
    /// Ranges of the inputs, V.
    ranges_v: Vec<f64>,
    output_range_v: f64,
    rate_hz: f64,
    /// One block in the units of the callbacks, and in those of the card.
    drive: Vec<f32>,
    drive_v: Vec<f64>,
    inputs: Vec<f32>,
    inputs_v: Vec<f64>,
    /// Number of frames read and written.
    frames: u64,
}

impl Streaming {
    fn new(library: &Daqmx, plan: &Plan, callbacks: Callbacks) -> Result<Self, NotStarted> {
        let Plan { table, device, .. } = plan;
        let rate_hz = f64::from(plan.rate_hz);
        let card_timing = |buffer_frames| Timing {
            source: "",
            rate_hz,
            buffer_frames,
        };
        let lead = plan.lead_frames();
        let output = AnalogOutput::new(
            library,
            &plan.outputs(),
            table.output_range_v,
            card_timing(2 * (lead + plan.block_frames)),
        )?;
        let buffered = card_timing((INPUT_BUFFER_S * rate_hz) as u32);
        let output_clock = format!("/{device}/ao/SampleClock");
        let timing = match table.clock {
            CardClock::AoSampleClock => Timing {
                source: &output_clock,
                ..buffered
            },
            CardClock::StartTrigger => buffered,
        };
        let input = AnalogInput::new(library, &plan.inputs(), table.terminals, timing)?;
        if table.clock == CardClock::StartTrigger {
            output.wait_for(&format!("/{device}/ai/StartTrigger"))?;
        }
        for made_hz in [output.rate_hz()?, input.rate_hz()?] {
            require_rate("audio.rate_hz", rate_hz, made_hz)?;
        }
        let mut deskew = None;
        if let Some(convert_hz) = table.convert_hz {
            require_rate(
                "nidaqmx.convert_hz",
                convert_hz,
                input.set_convert_hz(convert_hz)?,
            )?;
            let late = (0..table.inputs.len()).map(|i| i as f64 * rate_hz / convert_hz);
            deskew = Some(Deskew::new(late));
        }
        let block = plan.block_frames as usize;
        let (outputs, inputs) = (block * table.outputs.len(), block * table.inputs.len());
        Ok(Self {
            output,
            input,
            callbacks,
            deskew,
            ranges_v: table.input_ranges_v.clone(),
            output_range_v: table.output_range_v,
            rate_hz,
            drive: vec![0.0; outputs],
            drive_v: vec![0.0; outputs],
            inputs: vec![0.0; inputs],
            inputs_v: vec![0.0; inputs],
            frames: 0,
        })
    }

    /// Writes the lead and starts both tasks, last the task that starts the other.
    fn begin(&mut self, plan: &Plan) -> Result<(), DaqError> {
        let lead = plan.lead_frames() as usize * plan.table.outputs.len();
        self.output.write(&vec![0.0; lead], PATIENCE_S)?;
        match plan.table.clock {
            CardClock::AoSampleClock => {
                self.input.start()?;
                self.output.start()
            }
            CardClock::StartTrigger => {
                self.output.start()?;
                self.input.start()
            }
        }
    }

    /// Streams until a stop is requested and the drive is at rest, or until the card stops.
    fn run(&mut self, plan: &Plan, stop_request: &AtomicBool) {
        let block_s = f64::from(plan.block_frames) / self.rate_hz;
        let mut last = ((plan.table.lead_s + REST_S) / block_s).ceil() as u32;
        loop {
            match self.read(stop_request) {
                Ok(true) => {}
                Ok(false) => return,
                Err(error) => return self.fail(&error),
            }
            if let Err(error) = self.play() {
                return self.fail(&error);
            }
            self.hand_on();
            if stop_request.load(Ordering::Acquire) {
                last = last.saturating_sub(1);
                if last == 0 {
                    return;
                }
            }
        }
    }

    /// Reads a block; `false` if no block came and the stream is to end.
    fn read(&mut self, stop_request: &AtomicBool) -> Result<bool, DaqError> {
        let channels = self.ranges_v.len();
        let mut filled = 0;
        while filled < self.inputs_v.len() {
            let (frames, result) = self.input.read(&mut self.inputs_v[filled..], PATIENCE_S);
            filled += frames * channels;
            match result {
                Err(error) if error.fault() != DaqFault::TimedOut => return Err(error),
                Err(_) if stop_request.load(Ordering::Acquire) => return Ok(false),
                Err(_) => self.output.require_running()?,
                Ok(()) => {}
            }
        }
        Ok(true)
    }

    /// Returns the time of a frame since the start, by the card's clock.
    fn instant(&self, frame: u64) -> StreamInstant {
        StreamInstant::from_nanos((1e9 * frame as f64 / self.rate_hz) as u64)
    }

    fn play(&mut self) -> Result<(), DaqError> {
        let now = self.instant(self.frames);
        let info = OutputCallbackInfo::new(OutputStreamTimestamp {
            callback: now,
            playback: now,
        });
        let (start, len) = (self.drive.as_mut_ptr().cast(), self.drive.len());
        // SAFETY: start and length are those of a live vector of floats, lent to one callback.
        let mut data = unsafe { Data::from_parts(start, len, SampleFormat::F32) };
        (self.callbacks.output)(&mut data, &info);
        for (volts, sample) in self.drive_v.iter_mut().zip(&self.drive) {
            // A sample that is not a number is played as silence.
            let sample = if sample.is_finite() { *sample } else { 0.0 };
            *volts = f64::from(sample.clamp(-1.0, 1.0)) * self.output_range_v;
        }
        self.output.write(&self.drive_v, PATIENCE_S)
    }

    fn hand_on(&mut self) {
        if let Some(deskew) = &mut self.deskew {
            deskew.take(&mut self.inputs_v);
        }
        let channels = self.ranges_v.len();
        for (frame, volts) in self
            .inputs
            .chunks_exact_mut(channels)
            .zip(self.inputs_v.chunks_exact(channels))
        {
            for ((sample, volts), range_v) in frame.iter_mut().zip(volts).zip(&self.ranges_v) {
                *sample = (volts / range_v) as f32;
            }
        }
        let late = if self.deskew.is_some() {
            HALF as u64
        } else {
            0
        };
        let capture = self.instant(self.frames.saturating_sub(late));
        self.frames += (self.inputs.len() / channels) as u64;
        let info = InputCallbackInfo::new(InputStreamTimestamp {
            callback: self.instant(self.frames),
            capture,
        });
        let (start, len) = (self.inputs.as_mut_ptr().cast(), self.inputs.len());
        // SAFETY: as above.
        let data = unsafe { Data::from_parts(start, len, SampleFormat::F32) };
        (self.callbacks.input)(&data, &info);
    }

    /// Reports to the streams why the card stopped: lost samples are counted first, then the stream ends.
    fn fail(&mut self, error: &DaqError) {
        let Callbacks {
            output_error,
            input_error,
            ..
        } = &mut self.callbacks;
        let stream_error = |kind| Error::with_message(kind, error.to_string());
        match error.fault() {
            DaqFault::Overrun => {
                input_error(stream_error(ErrorKind::Xrun));
                input_error(stream_error(ErrorKind::StreamInvalidated));
            }
            DaqFault::Underrun => {
                output_error(stream_error(ErrorKind::Xrun));
                output_error(stream_error(ErrorKind::StreamInvalidated));
            }
            _ => {
                output_error(stream_error(ErrorKind::DeviceNotAvailable));
                input_error(stream_error(ErrorKind::DeviceNotAvailable));
            }
        }
    }
}

fn require_rate(key: &'static str, asked_hz: f64, made_hz: f64) -> Result<(), NotStarted> {
    if (made_hz / asked_hz - 1.0).abs() < 1e-9 {
        return Ok(());
    }
    Err(NotStarted::Coerced {
        key,
        asked_hz,
        made_hz,
    })
}
