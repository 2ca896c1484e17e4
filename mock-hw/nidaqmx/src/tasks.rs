//! Life cycle of tasks: create, start, stop, clear.

use std::ffi::{c_char, c_void};

use mock_hw::rack::Deck;

use crate::exchange;
use crate::status::{
    BAD_VALUE, NO_ROUTE, RESERVED, TOO_FAST, TOO_FAST_FOR_CONVERTER, UNREACHABLE, status,
};
use crate::twin::{CHANGED, DEVICE, Kind, Task, Twin, lock, with_apparatus};

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCreateTask(_name: *const c_char, task: *mut *mut c_void) -> i32 {
    let mut twin = with_apparatus();
    if twin.is_gone || twin.board.is_none() {
        return status(Err(UNREACHABLE));
    }
    let handle = twin.create();
    // SAFETY: the caller's pointer is that of a handle.
    unsafe { *task = handle as *mut c_void };
    0
}

/// Requires that the card supports the settings of a task.
fn verify(twin: &Twin, task: &Task) -> Result<(), i32> {
    let Some(clock) = &task.clock else {
        return Ok(());
    };
    let product = twin.product;
    let count = task.channels.len() as f64;
    match task.kind {
        Kind::Output => {
            if clock.rate_hz > product.output_hz {
                return Err(TOO_FAST);
            }
            if clock.source.is_empty() {
                Ok(())
            } else {
                Err(NO_ROUTE)
            }
        }
        Kind::Input => {
            let of_outputs = clock.source == format!("/{DEVICE}/ao/SampleClock");
            if !(clock.source.is_empty() || of_outputs && product.clocks_inputs) {
                return Err(NO_ROUTE);
            }
            if product.simultaneous || count < 2.0 {
                return if clock.rate_hz > product.single_hz {
                    Err(TOO_FAST)
                } else {
                    Ok(())
                };
            }
            if clock.rate_hz * count > product.multi_hz {
                return Err(TOO_FAST);
            }
            let convert_hz = task.convert_hz.unwrap_or(product.multi_hz);
            if clock.rate_hz * count > convert_hz * (1.0 + 1e-9) {
                return Err(TOO_FAST_FOR_CONVERTER);
            }
            Ok(())
        }
        _ => Err(BAD_VALUE),
    }
}

/// Returns the time from one input's sample to the next input's, s.
fn stagger_s(twin: &Twin) -> f64 {
    let inputs = twin.tasks.values().find(|task| task.kind == Kind::Input);
    let convert_hz = inputs.and_then(|task| task.convert_hz);
    match convert_hz {
        _ if twin.product.simultaneous => 0.0,
        Some(hz) => hz.recip(),
        None => twin.product.multi_hz.recip(),
    }
}

fn start(handle: *mut c_void) -> Result<(), i32> {
    let mut twin = lock();
    let kind = twin.task(handle)?.kind;
    let number = handle as usize;
    let rivals = twin
        .tasks
        .iter()
        .filter(|(id, task)| **id != number && task.is_started && task.kind == kind);
    if rivals.count() > 0 && matches!(kind, Kind::Input | Kind::Output | Kind::Counter) {
        return Err(RESERVED);
    }
    let task = twin.tasks.get(&number).ok_or(BAD_VALUE)?;
    verify(&twin, task)?;
    let rate_hz = task.clock.as_ref().map(|clock| clock.rate_hz);
    if let Some(rate_hz) = rate_hz.filter(|_| !twin.open) {
        let stagger_s = stagger_s(&twin);
        let board = twin.board.as_ref().ok_or(UNREACHABLE)?;
        let (open, context) = (board.open, board.context);
        // Unlock first: the apparatus calls the exchange while it holds its own lock.
        drop(twin);
        let deck = Deck {
            play: exchange::play,
            record: exchange::record,
            fail: exchange::fail,
        };
        if open(context, rate_hz.round() as u32, stagger_s, deck) != 0 {
            return Err(BAD_VALUE);
        }
        twin = lock();
        twin.open = true;
    }
    let count = twin
        .board
        .as_ref()
        .map_or(0, |board| (board.count)(board.context));
    let task = twin.task(handle)?;
    task.is_started = true;
    task.zero = count;
    CHANGED.notify_all();
    Ok(())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxStartTask(handle: *mut c_void) -> i32 {
    status(start(handle))
}

/// Stops a task, and closes the converters with the last streaming task.
fn stop(handle: *mut c_void, clear: bool) {
    let mut twin = lock();
    if let Some(task) = twin.tasks.get_mut(&(handle as usize)) {
        task.is_started = false;
        task.stopped_by = None;
        task.buffer_v.clear();
    }
    if clear {
        twin.tasks.remove(&(handle as usize));
    }
    CHANGED.notify_all();
    let idle = !twin
        .tasks
        .values()
        .any(|task| task.is_started && task.clock.is_some());
    if idle && std::mem::take(&mut twin.open) {
        let board = twin.board.as_ref();
        let close_call = board.map(|board| (board.close, board.context));
        drop(twin);
        if let Some((close, context)) = close_call {
            close(context);
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxStopTask(handle: *mut c_void) -> i32 {
    stop(handle, false);
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxClearTask(handle: *mut c_void) -> i32 {
    stop(handle, true);
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxIsTaskDone(handle: *mut c_void, done: *mut u32) -> i32 {
    let mut twin = lock();
    let result = twin.task(handle).and_then(|task| {
        // SAFETY: the caller's pointer is that of a number.
        unsafe { *done = u32::from(!task.is_started) };
        task.stopped_by.map_or(Ok(()), Err)
    });
    status(result)
}
