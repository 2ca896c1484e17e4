//! Tasks of the library, each with a single purpose. A task is cleared when it is dropped.
#![expect(unsafe_code, reason = "calls of a C library")]

use std::ptr;

use config::Terminals;

use super::daq_error::DaqError;
use super::functions::{Daqmx, Handle, c_text};
use super::values;

/// Time for one reading or one write of a line or a counter, s: they need no sample clock.
const ON_DEMAND_S: f64 = 0.1;

struct Task {
    library: Daqmx,
    handle: Handle,
}

// SAFETY: the library may be called from any thread (NI-DAQmx is thread-safe), and no two threads share this handle.
unsafe impl Send for Task {}

impl Task {
    fn new(library: &Daqmx) -> Result<Self, DaqError> {
        let mut handle = ptr::null_mut();
        // SAFETY: an empty name lets the library choose one; the handle outlives the call.
        let status =
            unsafe { (library.functions().create_task)(c_text("").as_ptr(), &raw mut handle) };
        library.check("DAQmxCreateTask", status)?;
        Ok(Self {
            library: library.clone(),
            handle,
        })
    }

    fn check(&self, function: &'static str, status: i32) -> Result<(), DaqError> {
        self.library.check(function, status)
    }

    fn start(&self) -> Result<(), DaqError> {
        // SAFETY: the handle is of a task that exists.
        let status = unsafe { (self.library.functions().start_task)(self.handle) };
        self.check("DAQmxStartTask", status)
    }

    fn clock(&self, source: &str, rate_hz: f64, buffer_frames: u32) -> Result<(), DaqError> {
        // SAFETY: the handle is of a task that exists, the source a C string.
        let status = unsafe {
            (self.library.functions().sample_clock)(
                self.handle,
                c_text(source).as_ptr(),
                rate_hz,
                values::RISING,
                values::CONTINUOUS,
                u64::from(buffer_frames),
            )
        };
        self.check("DAQmxCfgSampClkTiming", status)
    }

    fn rate_hz(&self) -> Result<f64, DaqError> {
        let mut hz = 0.0;
        // SAFETY: the handle is of a task that exists, the number outlives the call.
        let status = unsafe { (self.library.functions().sample_rate)(self.handle, &raw mut hz) };
        self.check("DAQmxGetSampClkRate", status)?;
        Ok(hz)
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        let functions = self.library.functions();
        // SAFETY: the handle is of a task that exists, and nothing uses it afterwards. A card that is gone fails both.
        unsafe {
            (functions.stop_task)(self.handle);
            (functions.clear_task)(self.handle);
        }
    }
}

/// Sample clock of a task.
#[derive(Debug, Clone, Copy)]
pub struct Timing<'a> {
    /// Terminal of the clock; empty for the card's own clock.
    pub source: &'a str,
    /// Rate, Hz.
    pub rate_hz: f64,
    /// Length of the driver's buffer, frames.
    pub buffer_frames: u32,
}

/// Analogue inputs on a sample clock.
pub struct AnalogInput {
    task: Task,
    channels: usize,
}

impl AnalogInput {
    /// Makes a task for the inputs, each `(terminal, range in V)`.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn new(
        library: &Daqmx,
        inputs: &[(String, f64)],
        terminals: Terminals,
        timing: Timing<'_>,
    ) -> Result<Self, DaqError> {
        let task = Task::new(library)?;
        let functions = library.functions();
        let reference = match terminals {
            Terminals::Differential => values::DIFF,
            Terminals::Rse => values::RSE,
            Terminals::Nrse => values::NRSE,
            Terminals::PseudoDifferential => values::PSEUDO_DIFF,
        };
        for (terminal, range_v) in inputs {
            // SAFETY: the handle is of a task that exists, the names are C strings.
            let status = unsafe {
                (functions.create_ai)(
                    task.handle,
                    c_text(terminal).as_ptr(),
                    c_text("").as_ptr(),
                    reference,
                    -range_v,
                    *range_v,
                    values::VOLTS,
                    ptr::null(),
                )
            };
            task.check("DAQmxCreateAIVoltageChan", status)?;
        }
        task.clock(timing.source, timing.rate_hz, timing.buffer_frames)?;
        // SAFETY: the handle is of a task that exists.
        let status = unsafe { (functions.input_buffer)(task.handle, timing.buffer_frames) };
        task.check("DAQmxCfgInputBuffer", status)?;
        Ok(Self {
            task,
            channels: inputs.len(),
        })
    }

    /// Sets the rate from input to input, and returns the rate that the card uses, Hz.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn set_convert_hz(&self, hz: f64) -> Result<f64, DaqError> {
        let functions = self.task.library.functions();
        // SAFETY: the handle is of a task that exists.
        let status = unsafe { (functions.set_convert_rate)(self.task.handle, hz) };
        self.task.check("DAQmxSetAIConvRate", status)?;
        let mut hz = 0.0;
        // SAFETY: as above, and the number outlives the call.
        let status = unsafe { (functions.get_convert_rate)(self.task.handle, &raw mut hz) };
        self.task.check("DAQmxGetAIConvRate", status)?;
        Ok(hz)
    }

    /// Returns the rate that the card uses instead of the requested one, Hz.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn rate_hz(&self) -> Result<f64, DaqError> {
        self.task.rate_hz()
    }

    /// Starts the task.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn start(&self) -> Result<(), DaqError> {
        self.task.start()
    }

    /// Reads interleaved frames, V, until `volts` is full or the time is over; returns their number and the outcome.
    pub fn read(&self, volts: &mut [f64], timeout_s: f64) -> (usize, Result<(), DaqError>) {
        let (mut frames_read, requested) = (0, volts.len() / self.channels);
        // SAFETY: the handle is of a task that exists; the buffer has the length that is named.
        let status = unsafe {
            (self.task.library.functions().read_analog)(
                self.task.handle,
                requested as i32,
                timeout_s,
                values::INTERLEAVED,
                volts.as_mut_ptr(),
                volts.len() as u32,
                &raw mut frames_read,
                ptr::null_mut(),
            )
        };
        let frames = usize::try_from(frames_read).unwrap_or(0).min(requested);
        (frames, self.task.check("DAQmxReadAnalogF64", status))
    }
}

/// Analogue outputs on a sample clock, which never play a sample twice.
pub struct AnalogOutput {
    task: Task,
    channels: usize,
}

impl AnalogOutput {
    /// Makes a task for the outputs, ± `range_v` each.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn new(
        library: &Daqmx,
        outputs: &[String],
        range_v: f64,
        timing: Timing<'_>,
    ) -> Result<Self, DaqError> {
        let output = Self::unclocked(library, outputs, range_v)?;
        let (task, functions) = (&output.task, library.functions());
        task.clock(timing.source, timing.rate_hz, timing.buffer_frames)?;
        // SAFETY: here and below the handle is of a task that exists.
        let status = unsafe { (functions.output_buffer)(task.handle, timing.buffer_frames) };
        task.check("DAQmxCfgOutputBuffer", status)?;
        // SAFETY: as above.
        let status = unsafe { (functions.regeneration)(task.handle, values::NO_REGENERATION) };
        task.check("DAQmxSetWriteRegenMode", status)?;
        Ok(output)
    }

    /// Makes a task for the outputs that sets a voltage when it is written.
    fn unclocked(library: &Daqmx, outputs: &[String], range_v: f64) -> Result<Self, DaqError> {
        let task = Task::new(library)?;
        for terminal in outputs {
            // SAFETY: the handle is of a task that exists, the names are C strings.
            let status = unsafe {
                (library.functions().create_ao)(
                    task.handle,
                    c_text(terminal).as_ptr(),
                    c_text("").as_ptr(),
                    -range_v,
                    range_v,
                    values::VOLTS,
                    ptr::null(),
                )
            };
            task.check("DAQmxCreateAOVoltageChan", status)?;
        }
        Ok(Self {
            task,
            channels: outputs.len(),
        })
    }

    /// Sets the outputs to 0 V: a card holds the last voltage when its task ends.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn zero(library: &Daqmx, outputs: &[String], range_v: f64) -> Result<(), DaqError> {
        let output = Self::unclocked(library, outputs, range_v)?;
        output.write_frames(&vec![0.0; outputs.len()], true, ON_DEMAND_S)
    }

    /// Makes the task begin with the inputs' start trigger instead of at once.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn wait_for(&self, trigger: &str) -> Result<(), DaqError> {
        // SAFETY: the handle is of a task that exists, the trigger a C string.
        let status = unsafe {
            (self.task.library.functions().start_trigger)(
                self.task.handle,
                c_text(trigger).as_ptr(),
                values::RISING,
            )
        };
        self.task.check("DAQmxCfgDigEdgeStartTrig", status)
    }

    /// Returns the rate that the card uses instead of the requested one, Hz.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn rate_hz(&self) -> Result<f64, DaqError> {
        self.task.rate_hz()
    }

    /// Starts the task.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn start(&self) -> Result<(), DaqError> {
        self.task.start()
    }

    /// Fails if the card has stopped the task: inputs on its clock then stand still without reporting an error.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn require_running(&self) -> Result<(), DaqError> {
        let mut done = 0;
        // SAFETY: the handle is of a task that exists, the number outlives the call.
        let status =
            unsafe { (self.task.library.functions().is_done)(self.task.handle, &raw mut done) };
        self.task.check("DAQmxIsTaskDone", status)
    }

    /// Writes interleaved frames, V, after those written before.
    ///
    /// # Errors
    /// [`DaqError`] of the library: the card has run dry, or is gone.
    pub fn write(&self, volts: &[f64], timeout_s: f64) -> Result<(), DaqError> {
        self.write_frames(volts, false, timeout_s)
    }

    fn write_frames(&self, volts: &[f64], start: bool, timeout_s: f64) -> Result<(), DaqError> {
        let mut count = 0;
        // SAFETY: the handle is of a task that exists; the buffer has as many frames as are named.
        let status = unsafe {
            (self.task.library.functions().write_analog)(
                self.task.handle,
                (volts.len() / self.channels) as i32,
                u32::from(start),
                timeout_s,
                values::INTERLEAVED,
                volts.as_ptr(),
                &raw mut count,
                ptr::null_mut(),
            )
        };
        self.task.check("DAQmxWriteAnalogF64", status)
    }
}

/// A counter that counts an encoder's edges.
pub struct CounterInput(Task);

impl CounterInput {
    /// Makes and starts a counter of every edge of both signals, from 0.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn new(library: &Daqmx, counter: &str) -> Result<Self, DaqError> {
        let task = Task::new(library)?;
        // SAFETY: the handle is of a task that exists, the names are C strings.
        let status = unsafe {
            (library.functions().create_encoder)(
                task.handle,
                c_text(counter).as_ptr(),
                c_text("").as_ptr(),
                values::X4,
                0,
                0.0,
                values::A_HIGH_B_HIGH,
                values::TICKS,
                1.0,
                0.0,
                ptr::null(),
            )
        };
        task.check("DAQmxCreateCILinEncoderChan", status)?;
        task.start()?;
        Ok(Self(task))
    }

    /// Returns the count, which wraps.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn count(&self) -> Result<u32, DaqError> {
        let mut count = 0;
        // SAFETY: the handle is of a task that exists, the number outlives the call.
        let status = unsafe {
            (self.0.library.functions().read_counter)(
                self.0.handle,
                ON_DEMAND_S,
                &raw mut count,
                ptr::null_mut(),
            )
        };
        self.0.check("DAQmxReadCounterScalarU32", status)?;
        Ok(count)
    }
}

/// A digital input.
pub struct LineInput(Task);

impl LineInput {
    /// Takes a line, such as `Dev1/port0/line2`.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn new(library: &Daqmx, line: &str) -> Result<Self, DaqError> {
        let task = Task::new(library)?;
        // SAFETY: the handle is of a task that exists, the names are C strings.
        let status = unsafe {
            (library.functions().create_di)(
                task.handle,
                c_text(line).as_ptr(),
                c_text("").as_ptr(),
                values::CHANNEL_PER_LINE,
            )
        };
        task.check("DAQmxCreateDIChan", status)?;
        task.start()?;
        Ok(Self(task))
    }

    /// Returns whether the line is high.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn is_high(&self) -> Result<bool, DaqError> {
        let (mut level, mut count, mut bytes) = ([0_u8], 0, 0);
        // SAFETY: the handle is of a task that exists, the buffer has the length that is named.
        let status = unsafe {
            (self.0.library.functions().read_lines)(
                self.0.handle,
                1,
                ON_DEMAND_S,
                values::INTERLEAVED,
                level.as_mut_ptr(),
                level.len() as u32,
                &raw mut count,
                &raw mut bytes,
                ptr::null_mut(),
            )
        };
        self.0.check("DAQmxReadDigitalLines", status)?;
        Ok(level[0] != 0)
    }
}

/// A digital output.
pub struct LineOutput(Task);

impl LineOutput {
    /// Takes a line, such as `Dev1/port1/line0`, and drives it low.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn new(library: &Daqmx, line: &str) -> Result<Self, DaqError> {
        let task = Task::new(library)?;
        // SAFETY: the handle is of a task that exists, the names are C strings.
        let status = unsafe {
            (library.functions().create_do)(
                task.handle,
                c_text(line).as_ptr(),
                c_text("").as_ptr(),
                values::CHANNEL_PER_LINE,
            )
        };
        task.check("DAQmxCreateDOChan", status)?;
        task.start()?;
        let output = Self(task);
        output.set(false)?;
        Ok(output)
    }

    /// Drives the line.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn set(&self, high: bool) -> Result<(), DaqError> {
        let (level, mut count) = ([u8::from(high)], 0);
        // SAFETY: the handle is of a task that exists, the buffer has as many samples as are named.
        let status = unsafe {
            (self.0.library.functions().write_lines)(
                self.0.handle,
                1,
                0,
                ON_DEMAND_S,
                values::INTERLEAVED,
                level.as_ptr(),
                &raw mut count,
                ptr::null_mut(),
            )
        };
        self.0.check("DAQmxWriteDigitalLines", status)
    }
}

impl Drop for LineOutput {
    fn drop(&mut self) {
        // The card holds the last level: a line must not stay high after its program has ended.
        let _ = self.set(false);
    }
}
