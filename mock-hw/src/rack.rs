//! Interface of the apparatus to a simulated library of National Instruments: converters, lines and a counter behind C
//! functions, the only items shared by library and program.
//!
//! The library is a separate program, loaded by the bench ([`Board`] is a table of C functions). [`Rack::connect`] connects it
//! to an apparatus of this process; without one it creates its own.
#![expect(
    unsafe_code,
    reason = "the simulated library is a C library, loaded as the real one is"
)]

use std::ffi::c_void;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, ErrorKind, SampleFormat, StreamConfig};
use embedded_hal::digital::{InputPin, OutputPin, PinState};

use crate::host::{SoundCards, cpal_host};
use crate::pins::{PinBoard, Pins};
use crate::world_clock::WorldPace;

/// Functions of the library, called in each period: first to play and then to record.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Deck {
    /// Fills a number of samples of the first output, full scale 1.
    pub play: extern "C" fn(*mut f32, usize),
    /// Takes a number of interleaved samples of all inputs, full scale 1.
    pub record: extern "C" fn(*const f32, usize),
    /// Receives a fault of the outputs (1) or inputs (0): [`XRUN`] or [`GONE`].
    pub fail: extern "C" fn(u32, u32),
}

/// A buffer overran or underran.
pub const XRUN: u32 = 1;
/// The card has gone.
pub const GONE: u32 = 2;

/// Lines of the apparatus by number.
pub const ESTOP: u32 = 0;
/// The participant's button.
pub const BUTTON: u32 = 1;
/// Amplifier enable.
pub const ENABLE: u32 = 2;
/// Amplifier heartbeat.
pub const HEARTBEAT: u32 = 3;

/// Functions and properties of the apparatus for the library.
#[repr(C)]
#[derive(Debug)]
pub struct Board {
    /// First argument of each function.
    pub context: *const c_void,
    /// Whether the apparatus is stepped: it then waits for the program.
    pub stepped: u32,
    /// Number of inputs.
    pub inputs: u32,
    /// Opens the converters at a rate, Hz, with a time between successive inputs, s; returns 0 on success.
    pub open: extern "C" fn(*const c_void, u32, f64, Deck) -> i32,
    /// Closes the converters.
    pub close: extern "C" fn(*const c_void),
    /// Returns the level of a line; negative if it cannot be read.
    pub level: extern "C" fn(*const c_void, u32) -> i32,
    /// Drives a line; negative if it cannot be driven.
    pub drive: extern "C" fn(*const c_void, u32, u32) -> i32,
    /// Returns the encoder's counts.
    pub count: extern "C" fn(*const c_void) -> i64,
    /// Releases the table.
    pub release: extern "C" fn(*const c_void),
}

// SAFETY: the context is of a value that any thread may use.
unsafe impl Send for Board {}

/// Function of the library that takes a [`Board`] and replaces the present one.
pub type Connect = extern "C" fn(Board);
/// Symbol of that function.
pub const CONNECT: &[u8] = b"mock_nidaqmx_connect\0";

/// An apparatus with converters, lines and counter to connect to a library.
pub struct Rack {
    cards: Arc<SoundCards>,
    board: Arc<PinBoard>,
}

/// Reason why a library cannot be connected to an apparatus.
#[derive(Debug, thiserror::Error)]
#[error("{} is no simulated library of National Instruments: {source}", path.display())]
pub struct NoTwin {
    path: PathBuf,
    source: libloading::Error,
}

/// Returns the path of the simulated library: next to this program, among its dependencies, or where a package installs it.
#[must_use]
pub fn library() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?;
    let name = libloading::library_filename("nidaqmx");
    let places = ["", "deps", "..", "../lib/friction-bench"].map(|place| folder.join(place));
    let files = places.into_iter().map(|place| place.join(&name));
    files.into_iter().find(|file| file.is_file())
}

/// State behind the functions of a [`Board`].
struct Desk {
    cards: Arc<SoundCards>,
    board: Arc<PinBoard>,
    pins: Mutex<Pins>,
    streams: Mutex<Option<[cpal::Stream; 2]>>,
}

impl Rack {
    pub(crate) fn new(cards: &Arc<SoundCards>, board: &Arc<PinBoard>) -> Self {
        Self {
            cards: Arc::clone(cards),
            board: Arc::clone(board),
        }
    }

    /// Returns the table of C functions.
    #[must_use]
    pub fn board(&self) -> Board {
        let desk = Arc::new(Desk {
            cards: Arc::clone(&self.cards),
            board: Arc::clone(&self.board),
            pins: Mutex::new(self.board.pins()),
            streams: Mutex::new(None),
        });
        Board {
            stepped: u32::from(self.cards.pace() == WorldPace::Stepped),
            inputs: self.cards.inputs.into(),
            context: Arc::into_raw(desk).cast(),
            open,
            close,
            level,
            drive,
            count,
            release,
        }
    }

    /// Connects the apparatus to the simulated library at `path`, which stays loaded.
    ///
    /// # Errors
    /// [`NoTwin`] if it is not a simulated library.
    pub fn connect(&self, path: &Path) -> Result<(), NoTwin> {
        // SAFETY: a library that has this function is the simulated one, whose prototype it is.
        let is_connected = unsafe {
            libloading::Library::new(path).and_then(|library| {
                let connect: Connect = *library.get(CONNECT)?;
                connect(self.board());
                // The library has thread-local state, and the bench loads it too.
                std::mem::forget(library);
                Ok(())
            })
        };
        is_connected.map_err(|source| NoTwin {
            path: path.to_owned(),
            source,
        })
    }
}

fn desk<'a>(context: *const c_void) -> &'a Desk {
    // SAFETY: the context is that of a board, which lives until it is released.
    unsafe { &*context.cast::<Desk>() }
}

impl Desk {
    fn open(&self, rate_hz: u32, stagger_s: f64, deck: Deck) -> Result<(), cpal::Error> {
        let host = cpal_host(&self.cards);
        let no_device = || cpal::Error::new(ErrorKind::DeviceNotAvailable);
        let device = host.default_input_device().ok_or_else(no_device)?;
        self.cards.stagger(stagger_s);
        let config = |channels| StreamConfig {
            channels,
            sample_rate: rate_hz,
            buffer_size: BufferSize::Default,
        };
        let failure = |output: u32| {
            move |error: cpal::Error| {
                let kind = if error.kind() == ErrorKind::Xrun {
                    XRUN
                } else {
                    GONE
                };
                (deck.fail)(output, kind);
            }
        };
        let output = device.build_output_stream_raw(
            config(1),
            SampleFormat::F32,
            move |data: &mut cpal::Data, _: &cpal::OutputCallbackInfo| {
                if let Some(samples) = data.as_slice_mut::<f32>() {
                    (deck.play)(samples.as_mut_ptr(), samples.len());
                }
            },
            failure(1),
            None,
        )?;
        let input = device.build_input_stream_raw(
            config(self.cards.inputs),
            SampleFormat::F32,
            move |data: &cpal::Data, _: &cpal::InputCallbackInfo| {
                if let Some(samples) = data.as_slice::<f32>() {
                    (deck.record)(samples.as_ptr(), samples.len());
                }
            },
            failure(0),
            None,
        )?;
        output.play()?;
        input.play()?;
        *self.streams() = Some([output, input]);
        Ok(())
    }

    fn streams(&self) -> std::sync::MutexGuard<'_, Option<[cpal::Stream; 2]>> {
        self.streams.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

extern "C" fn open(context: *const c_void, rate_hz: u32, stagger_s: f64, deck: Deck) -> i32 {
    match desk(context).open(rate_hz, stagger_s, deck) {
        Ok(()) => 0,
        Err(_) => -1,
    }
}

extern "C" fn close(context: *const c_void) {
    let streams = desk(context).streams().take();
    drop(streams);
}

extern "C" fn level(context: *const c_void, line: u32) -> i32 {
    let desk = desk(context);
    let mut pins = desk.pins.lock().unwrap_or_else(PoisonError::into_inner);
    let level = match line {
        ESTOP => pins.estop.is_high(),
        BUTTON => pins.button.is_high(),
        // An unconnected line: the card pulls it down.
        _ => Ok(false),
    };
    level.map_or(-1, i32::from)
}

extern "C" fn drive(context: *const c_void, line: u32, high: u32) -> i32 {
    let desk = desk(context);
    let mut pins = desk.pins.lock().unwrap_or_else(PoisonError::into_inner);
    let state = PinState::from(high != 0);
    let result = match line {
        ENABLE => pins.amplifier_enable.set_state(state),
        HEARTBEAT => pins.heartbeat.set_state(state),
        _ => Ok(()),
    };
    result.map_or(-1, |()| 0)
}

extern "C" fn count(context: *const c_void) -> i64 {
    desk(context).board.encoder_count()
}

extern "C" fn release(context: *const c_void) {
    close(context);
    // SAFETY: the context came from `Arc::into_raw`, and nothing uses it afterwards.
    drop(unsafe { Arc::from_raw(context.cast::<Desk>()) });
}
