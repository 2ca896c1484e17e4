//! Analogue inputs and outputs.

use std::ffi::{c_char, c_void};
use std::slice;
use std::time::{Duration, Instant};

use crate::status::{BAD_VALUE, NO_CHANNEL, NO_SPACE, SAMPLES_PENDING, status};
use crate::twin::{CHANGED, Channel, DEVICE, Kind, lock, text};

/// `DAQmx_Val_RSE`, `DAQmx_Val_NRSE`, `DAQmx_Val_Diff`, `DAQmx_Val_PseudoDiff`.
const TERMINALS: [i32; 4] = [10083, 10078, 10106, 12529];
/// `DAQmx_Val_Volts`.
const VOLTS: i32 = 10348;
/// `DAQmx_Val_GroupByScanNumber`.
const GROUP_BY_SCAN: u32 = 1;
/// Number of inputs of the simulated card.
const INPUTS: u32 = 16;
const OUTPUTS: u32 = 2;

/// Adds a channel such as `Dev1/ai0` to a task.
fn add(
    handle: *mut c_void,
    kind: Kind,
    terminal: &str,
    prefix: &str,
    count: u32,
    (low, high): (f64, f64),
) -> Result<(), i32> {
    let number = terminal
        .strip_prefix(&format!("{DEVICE}/{prefix}"))
        .and_then(|number| number.parse::<u32>().ok())
        .filter(|number| *number < count)
        .ok_or(NO_CHANNEL)?;
    if low >= high || high > 10.0 || low < -10.0 {
        return Err(BAD_VALUE);
    }
    let mut twin = lock();
    let task = twin.task(handle)?;
    if task.kind != Kind::Empty && task.kind != kind {
        return Err(BAD_VALUE);
    }
    task.kind = kind;
    task.channels.push(Channel {
        number,
        range_v: high,
    });
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCreateAIVoltageChan(
    handle: *mut c_void,
    terminal: *const c_char,
    _name: *const c_char,
    reference: i32,
    low: f64,
    high: f64,
    units: i32,
    _scale: *const c_char,
) -> i32 {
    if !TERMINALS.contains(&reference) || units != VOLTS {
        return status(Err(BAD_VALUE));
    }
    // SAFETY: the caller's pointer is that of a C string.
    let terminal = unsafe { text(terminal) };
    status(add(
        handle,
        Kind::Input,
        &terminal,
        "ai",
        INPUTS,
        (low, high),
    ))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCreateAOVoltageChan(
    handle: *mut c_void,
    terminal: *const c_char,
    _name: *const c_char,
    low: f64,
    high: f64,
    units: i32,
    _scale: *const c_char,
) -> i32 {
    if units != VOLTS {
        return status(Err(BAD_VALUE));
    }
    // SAFETY: the caller's pointer is that of a C string.
    let terminal = unsafe { text(terminal) };
    status(add(
        handle,
        Kind::Output,
        &terminal,
        "ao",
        OUTPUTS,
        (low, high),
    ))
}

/// Reads into `volts`; returns the number of frames, and the status.
fn read(handle: *mut c_void, frames: usize, timeout: f64, volts: &mut [f64]) -> (usize, i32) {
    let deadline = Instant::now() + Duration::from_secs_f64(timeout.clamp(0.0, 3600.0));
    let mut twin = lock();
    loop {
        let task = match twin.task(handle) {
            Ok(task) => task,
            Err(code) => return (0, status(Err(code))),
        };
        let channels = task.channels.len();
        let count = frames * channels;
        if task.kind != Kind::Input || !task.is_started || volts.len() < count {
            return (0, status(Err(BAD_VALUE)));
        }
        let now = Instant::now();
        let is_complete = task.buffer_v.len() >= count;
        if !is_complete && let Some(code) = task.stopped_by {
            return (0, status(Err(code)));
        }
        if is_complete || now >= deadline {
            task.read_request = None;
            // After a timeout the frames received so far are returned.
            let read_count = count.min(task.buffer_v.len() / channels * channels);
            for (to, from) in volts.iter_mut().zip(task.buffer_v.drain(..read_count)) {
                *to = from;
            }
            CHANGED.notify_all();
            let result = if is_complete {
                Ok(())
            } else {
                Err(SAMPLES_PENDING)
            };
            return (read_count / channels, status(result));
        }
        task.read_request = Some(count);
        CHANGED.notify_all();
        twin = twin.wait(deadline - now);
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxReadAnalogF64(
    handle: *mut c_void,
    frames: i32,
    timeout: f64,
    layout: u32,
    volts: *mut f64,
    len: u32,
    read_frames: *mut i32,
    _reserved: *mut u32,
) -> i32 {
    let Ok(frames) = usize::try_from(frames) else {
        return status(Err(BAD_VALUE));
    };
    if layout != GROUP_BY_SCAN {
        return status(Err(BAD_VALUE));
    }
    // SAFETY: the caller's buffer has that length.
    let volts = unsafe { slice::from_raw_parts_mut(volts, len as usize) };
    let (read_count, code) = read(handle, frames, timeout, volts);
    // SAFETY: the caller's pointer is that of a number.
    unsafe { *read_frames = read_count as i32 };
    code
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxWriteAnalogF64(
    handle: *mut c_void,
    frames: i32,
    auto_start: u32,
    _timeout: f64,
    layout: u32,
    volts: *const f64,
    written_frames: *mut i32,
    _reserved: *mut u32,
) -> i32 {
    let Ok(frames) = usize::try_from(frames) else {
        return status(Err(BAD_VALUE));
    };
    let mut twin = lock();
    let result = twin.task(handle).and_then(|task| {
        if task.kind != Kind::Output || layout != GROUP_BY_SCAN {
            return Err(BAD_VALUE);
        }
        if let Some(code) = task.stopped_by {
            return Err(code);
        }
        let len = frames * task.channels.len();
        // SAFETY: the caller's buffer has that many samples.
        let volts = unsafe { slice::from_raw_parts(volts, len) };
        let in_range = volts.chunks_exact(task.channels.len()).all(|frame| {
            frame
                .iter()
                .zip(&task.channels)
                .all(|(v, c)| v.abs() <= c.range_v)
        });
        if !in_range || (task.clock.is_some() && task.may_regenerate) {
            // The simulated card never repeats output samples; a program that allows it is wrong.
            return Err(BAD_VALUE);
        }
        if task.clock.is_none() {
            return if auto_start == 1 {
                Ok(volts.first().copied())
            } else {
                Err(BAD_VALUE)
            };
        }
        if task.buffer_v.len() + len > task.buffer_frames * task.channels.len() {
            return Err(NO_SPACE);
        }
        task.buffer_v.extend(volts);
        Ok(None)
    });
    let result = result.map(|held_v| {
        twin.held_v = held_v.unwrap_or(twin.held_v);
        // SAFETY: the caller's pointer is that of a number.
        unsafe { *written_frames = frames as i32 };
    });
    status(result)
}
