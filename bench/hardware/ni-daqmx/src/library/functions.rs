//! The library's C functions, looked up by name when it is loaded.
//!
//! Prototypes are those of NI's `NIDAQmx.h`, where `int32` is `i32`, `uInt32` and `bool32` are `u32`, `uInt64` is `u64`
//! and a `TaskHandle` is a pointer.
#![expect(unsafe_code, reason = "a C library; what calls it safely is below it")]

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::Path;
use std::sync::Arc;

use libloading::Library;

use super::daq_error::DaqError;

/// `TaskHandle`.
pub(super) type Handle = *mut c_void;
type Text = *const c_char;

macro_rules! functions {
    ($($field:ident = $name:literal ($($argument:ty),*);)*) => {
        /// Functions that the program uses.
        pub(super) struct Functions {
            $(pub(super) $field: unsafe extern "system" fn($($argument),*) -> i32,)*
        }

        impl Functions {
            /// # Safety
            /// `library` must be NI-DAQmx: its functions must have the prototypes above.
            unsafe fn find(library: &Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: the caller vouches for the prototypes.
                    $($field: *unsafe { library.get($name) }?,)*
                })
            }
        }
    };
}

functions! {
    extended_error = b"DAQmxGetExtendedErrorInfo\0" (*mut c_char, u32);
    device_names = b"DAQmxGetSysDevNames\0" (*mut c_char, u32);
    product_type = b"DAQmxGetDevProductType\0" (Text, *mut c_char, u32);
    serial_number = b"DAQmxGetDevSerialNum\0" (Text, *mut u32);
    single_rate = b"DAQmxGetDevAIMaxSingleChanRate\0" (Text, *mut f64);
    multi_rate = b"DAQmxGetDevAIMaxMultiChanRate\0" (Text, *mut f64);
    output_rate = b"DAQmxGetDevAOMaxRate\0" (Text, *mut f64);
    simultaneous = b"DAQmxGetDevAISimultaneousSamplingSupported\0" (Text, *mut u32);
    create_task = b"DAQmxCreateTask\0" (Text, *mut Handle);
    start_task = b"DAQmxStartTask\0" (Handle);
    stop_task = b"DAQmxStopTask\0" (Handle);
    is_done = b"DAQmxIsTaskDone\0" (Handle, *mut u32);
    clear_task = b"DAQmxClearTask\0" (Handle);
    create_ai = b"DAQmxCreateAIVoltageChan\0" (Handle, Text, Text, i32, f64, f64, i32, Text);
    create_ao = b"DAQmxCreateAOVoltageChan\0" (Handle, Text, Text, f64, f64, i32, Text);
    create_encoder = b"DAQmxCreateCILinEncoderChan\0" (Handle, Text, Text, i32, u32, f64, i32, i32, f64, f64, Text);
    create_di = b"DAQmxCreateDIChan\0" (Handle, Text, Text, i32);
    create_do = b"DAQmxCreateDOChan\0" (Handle, Text, Text, i32);
    sample_clock = b"DAQmxCfgSampClkTiming\0" (Handle, Text, f64, i32, i32, u64);
    sample_rate = b"DAQmxGetSampClkRate\0" (Handle, *mut f64);
    start_trigger = b"DAQmxCfgDigEdgeStartTrig\0" (Handle, Text, i32);
    regeneration = b"DAQmxSetWriteRegenMode\0" (Handle, i32);
    output_buffer = b"DAQmxCfgOutputBuffer\0" (Handle, u32);
    input_buffer = b"DAQmxCfgInputBuffer\0" (Handle, u32);
    set_convert_rate = b"DAQmxSetAIConvRate\0" (Handle, f64);
    get_convert_rate = b"DAQmxGetAIConvRate\0" (Handle, *mut f64);
    read_analog = b"DAQmxReadAnalogF64\0" (Handle, i32, f64, u32, *mut f64, u32, *mut i32, *mut u32);
    write_analog = b"DAQmxWriteAnalogF64\0" (Handle, i32, u32, f64, u32, *const f64, *mut i32, *mut u32);
    read_counter = b"DAQmxReadCounterScalarU32\0" (Handle, f64, *mut u32, *mut u32);
    read_lines = b"DAQmxReadDigitalLines\0" (Handle, i32, f64, u32, *mut u8, u32, *mut i32, *mut i32, *mut u32);
    write_lines = b"DAQmxWriteDigitalLines\0" (Handle, i32, u32, f64, u32, *const u8, *mut i32, *mut u32);
}

/// The loaded library.
#[derive(Clone)]
pub struct Daqmx(Arc<Loaded>);

struct Loaded {
    functions: Functions,
    /// Library that contains the functions.
    _library: Library,
}

/// Identity and limits of a card.
#[derive(Debug, Clone, PartialEq)]
pub struct Card {
    /// Its name, such as `Dev1`.
    pub name: String,
    /// Its type, such as `USB-6211`.
    pub product: String,
    /// Its serial number.
    pub serial: u32,
    /// Highest rate of one input, Hz.
    pub single_hz: f64,
    /// Highest rate of all inputs together on a card with one converter, or of each input on a card with a converter
    /// for each, Hz.
    pub multi_hz: f64,
    /// Highest rate of the outputs, Hz.
    pub output_hz: f64,
    /// Whether each input has its own converter.
    pub simultaneous: bool,
}

impl std::fmt::Debug for Daqmx {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("NI-DAQmx")
    }
}

/// Name of the library if no other is configured.
const LIBRARY: &str = if cfg!(windows) {
    "nicaiu.dll"
} else {
    "libnidaqmx.so.1"
};

/// Reason for which NI's library cannot be used.
#[derive(Debug, thiserror::Error)]
#[error(
    "NI-DAQmx cannot be loaded ({why}): install NI's driver, or name its library as nidaqmx.library in bench.toml"
)]
pub struct NoLibrary {
    why: String,
}

impl Daqmx {
    /// Loads the library at `path` or, without it, the one that the system's loader finds.
    ///
    /// # Errors
    /// [`NoLibrary`] if the library is missing, or lacks a function.
    pub fn load(path: Option<&Path>) -> Result<Self, NoLibrary> {
        let path = path.unwrap_or(Path::new(LIBRARY));
        // SAFETY: loading NI's library has no effect that this program relies on or is harmed by; its functions are those
        // of NI's header.
        let loaded = unsafe {
            Library::new(path).and_then(|library| {
                Ok(Loaded {
                    functions: Functions::find(&library)?,
                    _library: library,
                })
            })
        };
        loaded
            .map(|loaded| Self(Arc::new(loaded)))
            .map_err(|error| NoLibrary {
                // The loader's message is the source of the error.
                why: match std::error::Error::source(&error) {
                    Some(source) => source.to_string(),
                    None => error.to_string(),
                },
            })
    }

    pub(super) fn functions(&self) -> &Functions {
        &self.0.functions
    }

    /// Returns the cards of this computer.
    ///
    /// # Errors
    /// [`DaqError`] of the library.
    pub fn cards(&self) -> Result<Vec<Card>, DaqError> {
        let functions = self.functions();
        let names = self.text("DAQmxGetSysDevNames", |buffer, bytes| {
            // SAFETY: the buffer has that many bytes.
            unsafe { (functions.device_names)(buffer, bytes) }
        })?;
        let names = names.split(',').map(str::trim);
        names
            .filter(|name| !name.is_empty())
            .map(|name| self.card(name))
            .collect()
    }

    fn card(&self, name: &str) -> Result<Card, DaqError> {
        let functions = self.functions();
        let device = c_text(name);
        let product = self.text("DAQmxGetDevProductType", |buffer, bytes| {
            // SAFETY: the name is a C string, the buffer has that many bytes.
            unsafe { (functions.product_type)(device.as_ptr(), buffer, bytes) }
        })?;
        let mut serial = 0;
        // SAFETY: here and below the name is a C string and the number one of the right size, which outlives the call.
        let status = unsafe { (functions.serial_number)(device.as_ptr(), &raw mut serial) };
        self.check("DAQmxGetDevSerialNum", status)?;
        let mut simultaneous = 0;
        // SAFETY: as above.
        let status = unsafe { (functions.simultaneous)(device.as_ptr(), &raw mut simultaneous) };
        // A device without analogue inputs has no such property.
        let simultaneous = status >= 0 && simultaneous != 0;
        let rate = |function: unsafe extern "system" fn(Text, *mut f64) -> i32| {
            let mut hz = 0.0;
            // SAFETY: as above.
            let status = unsafe { function(device.as_ptr(), &raw mut hz) };
            if status < 0 { 0.0 } else { hz }
        };
        Ok(Card {
            name: name.to_owned(),
            product,
            serial,
            single_hz: rate(functions.single_rate),
            multi_hz: rate(functions.multi_rate),
            output_hz: rate(functions.output_rate),
            simultaneous,
        })
    }

    /// Turns a status into a result; a positive status is a warning, which the library also gives when no data are
    /// lost.
    pub(super) fn check(&self, function: &'static str, status: i32) -> Result<(), DaqError> {
        if status >= 0 {
            return Ok(());
        }
        let mut text = vec![0_u8; 2048];
        // SAFETY: the buffer has that many bytes; the library ends it with a zero.
        let code = unsafe {
            (self.functions().extended_error)(text.as_mut_ptr().cast(), text.len() as u32)
        };
        let text = if code < 0 {
            "NI-DAQmx gives no description".to_owned()
        } else {
            one_line(&text)
        };
        Err(DaqError {
            function,
            code: status,
            text,
        })
    }

    fn text(
        &self,
        function: &'static str,
        fill: impl Fn(*mut c_char, u32) -> i32,
    ) -> Result<String, DaqError> {
        let mut buffer = vec![0_u8; 4096];
        let status = fill(buffer.as_mut_ptr().cast(), buffer.len() as u32);
        self.check(function, status)?;
        Ok(one_line(&buffer))
    }
}

/// Returns a C string without zero bytes, which names of this program do not contain.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

/// Returns the zero-terminated text of a buffer, on one line.
fn one_line(buffer: &[u8]) -> String {
    let text = CStr::from_bytes_until_nul(buffer).unwrap_or_default();
    let text = text.to_string_lossy();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
