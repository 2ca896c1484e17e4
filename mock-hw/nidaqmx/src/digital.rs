//! Digital lines and the counter, on demand.

use std::ffi::{c_char, c_void};

use mock_hw::rack::{BUTTON, ENABLE, ESTOP, HEARTBEAT};

use crate::status::{BAD_VALUE, NO_CHANNEL, RESERVED, UNREACHABLE, status};
use crate::twin::{Channel, DEVICE, Kind, Twin, lock, text};

/// `DAQmx_Val_ChanPerLine`.
const CHAN_PER_LINE: i32 = 0;
/// `DAQmx_Val_X4`, `DAQmx_Val_Ticks`.
const X4: i32 = 10092;
const TICKS: i32 = 10304;
/// `DAQmx_Val_AHighBHigh` to `DAQmx_Val_ALowBLow`.
const INDEX_PHASES: [i32; 4] = [10040, 10041, 10042, 10043];
/// Lines of each port of the simulated card.
const LINES: u32 = 4;

/// Adds a line such as `Dev1/port0/line2` to a task, unless another task uses it.
fn add(handle: *mut c_void, kind: Kind, terminal: &str, port: u32) -> Result<(), i32> {
    let line = terminal
        .strip_prefix(&format!("{DEVICE}/port{port}/line"))
        .and_then(|line| line.parse::<u32>().ok())
        .filter(|line| *line < LINES)
        .ok_or(NO_CHANNEL)?;
    let number = 100 * port + line;
    let mut twin = lock();
    let is_reserved = twin.tasks.values().any(|task| {
        task.kind == kind && task.channels.iter().any(|channel| channel.number == number)
    });
    if is_reserved {
        return Err(RESERVED);
    }
    let task = twin.task(handle)?;
    if task.kind != Kind::Empty {
        return Err(BAD_VALUE);
    }
    task.kind = kind;
    task.channels.push(Channel {
        number,
        range_v: 0.0,
    });
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCreateDIChan(
    handle: *mut c_void,
    lines: *const c_char,
    _name: *const c_char,
    grouping: i32,
) -> i32 {
    if grouping != CHAN_PER_LINE {
        return status(Err(BAD_VALUE));
    }
    // SAFETY: the caller's pointer is that of a C string.
    status(add(handle, Kind::LineIn, &unsafe { text(lines) }, 0))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCreateDOChan(
    handle: *mut c_void,
    lines: *const c_char,
    _name: *const c_char,
    grouping: i32,
) -> i32 {
    if grouping != CHAN_PER_LINE {
        return status(Err(BAD_VALUE));
    }
    // SAFETY: the caller's pointer is that of a C string.
    status(add(handle, Kind::LineOut, &unsafe { text(lines) }, 1))
}

/// Returns the line of the apparatus behind the first line of a started task.
fn line(twin: &mut Twin, handle: *mut c_void, kind: Kind) -> Result<u32, i32> {
    let task = twin.task(handle)?;
    if task.kind != kind || !task.is_started {
        return Err(BAD_VALUE);
    }
    let number = task.channels.first().ok_or(BAD_VALUE)?.number;
    Ok(match number {
        0 => ESTOP,
        1 => BUTTON,
        100 => ENABLE,
        101 => HEARTBEAT,
        _ => u32::MAX,
    })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxReadDigitalLines(
    handle: *mut c_void,
    samples: i32,
    _timeout: f64,
    _layout: u32,
    levels: *mut u8,
    len: u32,
    read: *mut i32,
    bytes: *mut i32,
    _reserved: *mut u32,
) -> i32 {
    let mut twin = lock();
    let result = line(&mut twin, handle, Kind::LineIn).and_then(|line| {
        if samples != 1 || len < 1 {
            return Err(BAD_VALUE);
        }
        let board = twin.board.as_ref().ok_or(UNREACHABLE)?;
        let level = (board.level)(board.context, line);
        let level = u8::try_from(level).map_err(|_| UNREACHABLE)?;
        // SAFETY: the caller's pointers are of a level and of numbers.
        unsafe {
            (*levels, *read, *bytes) = (level, 1, 1);
        }
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxWriteDigitalLines(
    handle: *mut c_void,
    samples: i32,
    _auto_start: u32,
    _timeout: f64,
    _layout: u32,
    levels: *const u8,
    written_samples: *mut i32,
    _reserved: *mut u32,
) -> i32 {
    let mut twin = lock();
    let result = line(&mut twin, handle, Kind::LineOut).and_then(|line| {
        if samples != 1 {
            return Err(BAD_VALUE);
        }
        let board = twin.board.as_ref().ok_or(UNREACHABLE)?;
        // SAFETY: the caller's pointers are of a level and of a number.
        let level = unsafe {
            *written_samples = 1;
            *levels
        };
        if (board.drive)(board.context, line, u32::from(level)) < 0 {
            return Err(UNREACHABLE);
        }
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCreateCILinEncoderChan(
    handle: *mut c_void,
    counter: *const c_char,
    _name: *const c_char,
    decoding: i32,
    index: u32,
    _index_value: f64,
    index_phase: i32,
    units: i32,
    _distance: f64,
    _initial: f64,
    _scale: *const c_char,
) -> i32 {
    // SAFETY: the caller's pointer is that of a C string.
    let counter = unsafe { text(counter) };
    let mut twin = lock();
    let result = twin.task(handle).and_then(|task| {
        if counter != format!("{DEVICE}/ctr0") {
            return Err(NO_CHANNEL);
        }
        let is_valid = decoding == X4 && units == TICKS && INDEX_PHASES.contains(&index_phase);
        if !is_valid || index != 0 || task.kind != Kind::Empty {
            return Err(BAD_VALUE);
        }
        task.kind = Kind::Counter;
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxReadCounterScalarU32(
    handle: *mut c_void,
    _timeout: f64,
    value: *mut u32,
    _reserved: *mut u32,
) -> i32 {
    let mut twin = lock();
    let zero = twin.task(handle).and_then(|task| {
        let counts = task.kind == Kind::Counter && task.is_started;
        counts.then_some(task.zero).ok_or(BAD_VALUE)
    });
    let result = zero.and_then(|zero| {
        let board = twin.board.as_ref().ok_or(UNREACHABLE)?;
        // A 32-bit counter also wraps below 0.
        let count = (board.count)(board.context).wrapping_sub(zero) as u32;
        // SAFETY: the caller's pointer is that of a number.
        unsafe { *value = count };
        Ok(())
    });
    status(result)
}
