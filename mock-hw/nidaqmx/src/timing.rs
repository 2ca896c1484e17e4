//! Clocks, triggers and buffers of tasks.

use std::ffi::{c_char, c_void};

use crate::status::{BAD_VALUE, NO_ROUTE, status};
use crate::twin::{DEVICE, Kind, Twin, lock, text};

/// `DAQmx_Val_Rising`.
const RISING: i32 = 10280;
/// `DAQmx_Val_ContSamps`.
const CONT_SAMPS: i32 = 10123;
/// `DAQmx_Val_AllowRegen` and `DAQmx_Val_DoNotAllowRegen`.
const REGENERATION: [i32; 2] = [10097, 10158];

/// Returns the nearest rate at an integer division of the card's time base.
fn card_rate_hz(twin: &Twin, rate_hz: f64) -> f64 {
    let base = twin.product.timebase_hz;
    base / (base / rate_hz).round().max(1.0)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCfgSampClkTiming(
    handle: *mut c_void,
    source: *const c_char,
    rate: f64,
    edge: i32,
    mode: i32,
    samples: u64,
) -> i32 {
    // SAFETY: the caller's pointer is null or of a C string.
    let source = unsafe { text(source) };
    let mut twin = lock();
    let rate_hz = card_rate_hz(&twin, rate);
    let result = twin.task(handle).and_then(|task| {
        let streams = matches!(task.kind, Kind::Input | Kind::Output);
        if !streams || edge != RISING || mode != CONT_SAMPS || !(1.0..1e8).contains(&rate) {
            return Err(BAD_VALUE);
        }
        task.clock = Some(crate::twin::Clock { source, rate_hz });
        task.buffer_frames = samples as usize;
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetSampClkRate(handle: *mut c_void, data: *mut f64) -> i32 {
    let mut twin = lock();
    let rate = twin.task(handle).and_then(|task| {
        let clock = task.clock.as_ref();
        clock.map(|clock| clock.rate_hz).ok_or(BAD_VALUE)
    });
    // SAFETY: the caller's pointer is that of a number.
    status(rate.map(|rate| unsafe { *data = rate }))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCfgDigEdgeStartTrig(
    handle: *mut c_void,
    source: *const c_char,
    edge: i32,
) -> i32 {
    // SAFETY: the caller's pointer is null or of a C string.
    let source = unsafe { text(source) };
    let mut twin = lock();
    let result = twin.task(handle).and_then(|task| {
        if edge != RISING {
            return Err(BAD_VALUE);
        }
        if source != format!("/{DEVICE}/ai/StartTrigger") || task.kind != Kind::Output {
            return Err(NO_ROUTE);
        }
        task.trigger = Some(source);
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxSetWriteRegenMode(handle: *mut c_void, data: i32) -> i32 {
    let mut twin = lock();
    let result = twin.task(handle).and_then(|task| {
        if task.kind != Kind::Output || !REGENERATION.contains(&data) {
            return Err(BAD_VALUE);
        }
        task.may_regenerate = data == REGENERATION[0];
        Ok(())
    });
    status(result)
}

fn set_buffer(handle: *mut c_void, kind: Kind, frames: u32) -> i32 {
    let mut twin = lock();
    let result = twin.task(handle).and_then(|task| {
        if task.kind != kind || frames == 0 {
            return Err(BAD_VALUE);
        }
        task.buffer_frames = frames as usize;
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCfgOutputBuffer(handle: *mut c_void, frames: u32) -> i32 {
    set_buffer(handle, Kind::Output, frames)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxCfgInputBuffer(handle: *mut c_void, frames: u32) -> i32 {
    set_buffer(handle, Kind::Input, frames)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxSetAIConvRate(handle: *mut c_void, data: f64) -> i32 {
    let mut twin = lock();
    let (product, rate_hz) = (twin.product, card_rate_hz(&twin, data));
    let result = twin.task(handle).and_then(|task| {
        let possible = data > 0.0 && data <= product.multi_hz && !product.simultaneous;
        if task.kind != Kind::Input || !possible {
            return Err(BAD_VALUE);
        }
        task.convert_hz = Some(rate_hz);
        Ok(())
    });
    status(result)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetAIConvRate(handle: *mut c_void, data: *mut f64) -> i32 {
    let mut twin = lock();
    let rate = twin
        .task(handle)
        .and_then(|task| task.convert_hz.ok_or(BAD_VALUE));
    // SAFETY: the caller's pointer is that of a number.
    status(rate.map(|rate| unsafe { *data = rate }))
}
