//! Cards of this computer and their properties.

use std::ffi::c_char;

use crate::status::{NO_DEVICE, UNREACHABLE, put, status};
use crate::twin::{DEVICE, Product, text, with_apparatus};

const SERIAL: u32 = 0x01A2_B3C4;

/// Returns the card with this name, if it is present.
unsafe fn card(device: *const c_char) -> Result<Product, i32> {
    // SAFETY: the caller's pointer is that of a C string.
    if !unsafe { text(device) }.eq_ignore_ascii_case(DEVICE) {
        return Err(NO_DEVICE);
    }
    let twin = with_apparatus();
    if twin.is_gone {
        return Err(UNREACHABLE);
    }
    Ok(twin.product)
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetSysDevNames(data: *mut c_char, bytes: u32) -> i32 {
    let has_board = with_apparatus().board.is_some();
    // SAFETY: the caller's buffer has that many bytes.
    unsafe { put(if has_board { DEVICE } else { "" }, data, bytes) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetDevProductType(
    device: *const c_char,
    data: *mut c_char,
    bytes: u32,
) -> i32 {
    // SAFETY: as the header says of the arguments.
    unsafe {
        match card(device) {
            Ok(product) => put(product.name, data, bytes),
            Err(code) => status(Err(code)),
        }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetDevSerialNum(device: *const c_char, data: *mut u32) -> i32 {
    // SAFETY: as the header says of the arguments.
    status(unsafe { card(device).map(|_| *data = SERIAL) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetDevAIMaxSingleChanRate(
    device: *const c_char,
    data: *mut f64,
) -> i32 {
    // SAFETY: as the header says of the arguments.
    status(unsafe { card(device).map(|product| *data = product.single_hz) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetDevAIMaxMultiChanRate(
    device: *const c_char,
    data: *mut f64,
) -> i32 {
    // SAFETY: as the header says of the arguments.
    status(unsafe { card(device).map(|product| *data = product.multi_hz) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetDevAOMaxRate(device: *const c_char, data: *mut f64) -> i32 {
    // SAFETY: as the header says of the arguments.
    status(unsafe { card(device).map(|product| *data = product.output_hz) })
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetDevAISimultaneousSamplingSupported(
    device: *const c_char,
    data: *mut u32,
) -> i32 {
    // SAFETY: as the header says of the arguments.
    status(unsafe { card(device).map(|product| *data = u32::from(product.simultaneous)) })
}
