//! Status of a call, and the message of the latest failed call of a thread.

use std::cell::RefCell;
use std::ffi::c_char;

/// `SamplesNotYetAvailable`.
pub(crate) const SAMPLES_PENDING: i32 = -200284;
/// `SamplesNoLongerAvailable`.
pub(crate) const OVERWRITTEN: i32 = -200279;
/// `GenStoppedToPreventRegenOfOldSamples`.
pub(crate) const RAN_DRY: i32 = -200290;
/// `DevCannotBeAccessed`.
pub(crate) const UNREACHABLE: i32 = -201003;
/// `InvalidDeviceID`.
pub(crate) const NO_DEVICE: i32 = -200220;
/// `PhysicalChanDoesNotExist`.
pub(crate) const NO_CHANNEL: i32 = -200170;
/// `InvalidTask`.
pub(crate) const NO_TASK: i32 = -200088;
/// `InvalidAttributeValue`.
pub(crate) const BAD_VALUE: i32 = -200077;
/// `SampleRateNumChansConvertPeriodCombo`.
pub(crate) const TOO_FAST_FOR_CONVERTER: i32 = -200081;
/// `SampRateTooHigh`.
pub(crate) const TOO_FAST: i32 = -200332;
/// `RouteNotSupportedByHW_Routing`.
pub(crate) const NO_ROUTE: i32 = -89136;
/// `PALResourceReserved`.
pub(crate) const RESERVED: i32 = -50103;
/// `SamplesCanNotYetBeWritten`.
pub(crate) const NO_SPACE: i32 = -200292;

thread_local! {
    static WORDS: RefCell<String> = const { RefCell::new(String::new()) };
}

fn words(code: i32) -> &'static str {
    match code {
        SAMPLES_PENDING => "Some or all of the samples requested have not yet been acquired.",
        OVERWRITTEN => {
            "The application is not able to keep up with the hardware acquisition: unread samples were overwritten."
        }
        RAN_DRY => {
            "The generation has stopped to prevent the regeneration of old samples: the application was unable to write \
             samples fast enough."
        }
        UNREACHABLE => {
            "Device cannot be accessed.\nPossible causes: it is no longer present in the system."
        }
        NO_DEVICE => "Device identifier is invalid.",
        NO_CHANNEL => "Physical channel specified does not exist on this device.",
        NO_TASK => "Task specified is invalid or does not exist.",
        BAD_VALUE => "Requested value is not a supported value for this property.",
        TOO_FAST_FOR_CONVERTER => {
            "Sample rate, number of channels and convert rate are an incompatible combination."
        }
        TOO_FAST => {
            "Sample rate exceeds the maximum sample rate for the number of channels specified."
        }
        NO_ROUTE => {
            "No registered trigger lines could be found between the devices in the route: route is not supported by the \
             hardware."
        }
        RESERVED => "The specified resource is reserved.",
        NO_SPACE => "Some or all of the samples to write could not be written to the buffer yet.",
        _ => "",
    }
}

/// Returns the status of a call, and stores the message of a failed one.
pub(crate) fn status(result: Result<(), i32>) -> i32 {
    match result {
        Ok(()) => 0,
        Err(code) => {
            WORDS.with_borrow_mut(|text| *text = words(code).to_owned());
            code
        }
    }
}

/// Writes text and a terminating zero into a buffer of `bytes`.
///
/// # Safety
/// The buffer must have that many bytes.
pub(crate) unsafe fn put(text: &str, buffer: *mut c_char, bytes: u32) -> i32 {
    let bytes = bytes as usize;
    if buffer.is_null() || bytes == 0 {
        return i32::try_from(text.len() + 1).unwrap_or(i32::MAX);
    }
    let len = text.len().min(bytes - 1);
    // SAFETY: `len` and the zero fit, by the line above.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr().cast(), buffer, len);
        *buffer.add(len) = 0;
    }
    0
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn DAQmxGetExtendedErrorInfo(buffer: *mut c_char, bytes: u32) -> i32 {
    let text = WORDS.with_borrow(String::clone);
    // SAFETY: the caller's buffer has that many bytes.
    unsafe { put(&text, buffer, bytes) }
}
