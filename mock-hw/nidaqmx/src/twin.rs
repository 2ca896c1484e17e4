//! State of the simulated library: its card, its tasks, and the apparatus behind them.

use std::collections::{BTreeMap, VecDeque};
use std::ffi::{CStr, c_char, c_void};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use mock_hw::rack::Board;

use crate::own_apparatus;
use crate::status::{NO_TASK, UNREACHABLE};

/// Name of the card.
pub(crate) const DEVICE: &str = "Dev1";

/// Properties of a card.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Product {
    pub(crate) name: &'static str,
    pub(crate) single_hz: f64,
    pub(crate) multi_hz: f64,
    pub(crate) output_hz: f64,
    pub(crate) simultaneous: bool,
    pub(crate) timebase_hz: f64,
    /// Whether the outputs' sample clock can be routed to the inputs.
    pub(crate) clocks_inputs: bool,
}

/// Cards from NI's manuals of USB-621x, X series and simultaneous X series.
const PRODUCTS: [Product; 3] = [
    Product {
        name: "USB-6211",
        single_hz: 250e3,
        multi_hz: 250e3,
        output_hz: 250e3,
        simultaneous: false,
        timebase_hz: 20e6,
        clocks_inputs: false,
    },
    Product {
        name: "USB-6361",
        single_hz: 2e6,
        multi_hz: 1e6,
        output_hz: 2.86e6,
        simultaneous: false,
        timebase_hz: 100e6,
        clocks_inputs: true,
    },
    Product {
        name: "USB-6366",
        single_hz: 2e6,
        multi_hz: 2e6,
        output_hz: 3.33e6,
        simultaneous: true,
        timebase_hz: 100e6,
        clocks_inputs: true,
    },
];

/// Kind of the channels of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Empty,
    Input,
    Output,
    Counter,
    LineIn,
    LineOut,
}

/// A channel of a task.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    /// Index among channels of its kind; `port * 100 + line` for a line.
    pub(crate) number: u32,
    /// Range, ±V.
    pub(crate) range_v: f64,
}

/// Sample clock of a task.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    pub(crate) source: String,
    pub(crate) rate_hz: f64,
}

/// A task.
#[derive(Debug)]
pub(crate) struct Task {
    pub(crate) kind: Kind,
    pub(crate) channels: Vec<Channel>,
    pub(crate) clock: Option<Clock>,
    pub(crate) trigger: Option<String>,
    pub(crate) convert_hz: Option<f64>,
    pub(crate) may_regenerate: bool,
    /// Capacity of the buffer, frames.
    pub(crate) buffer_frames: usize,
    pub(crate) buffer_v: VecDeque<f64>,
    pub(crate) is_started: bool,
    /// Status of the error that stopped it.
    pub(crate) stopped_by: Option<i32>,
    /// Number of samples that a reader waits for.
    pub(crate) read_request: Option<usize>,
    /// Count at the start of a counter.
    pub(crate) zero: i64,
}

impl Task {
    fn new() -> Self {
        Self {
            kind: Kind::Empty,
            channels: Vec::new(),
            clock: None,
            trigger: None,
            convert_hz: None,
            may_regenerate: true,
            buffer_frames: 0,
            buffer_v: VecDeque::new(),
            is_started: false,
            stopped_by: None,
            read_request: None,
            zero: 0,
        }
    }

    /// Whether it streams on a sample clock.
    pub(crate) fn streams(&self) -> bool {
        self.is_started && self.clock.is_some() && self.stopped_by.is_none()
    }
}

/// State of the library.
pub(crate) struct Twin {
    pub(crate) board: Option<Board>,
    pub(crate) product: Product,
    pub(crate) tasks: BTreeMap<usize, Task>,
    task_count: usize,
    pub(crate) is_gone: bool,
    /// Whether the converters are open.
    pub(crate) open: bool,
    /// Voltage that the first output holds.
    pub(crate) held_v: f64,
    /// Frames that the outputs played in the present period, and whether the inputs ran at its beginning.
    pub(crate) played_frames: usize,
    pub(crate) inputs_ran: bool,
}

static TWIN: Mutex<Option<Twin>> = Mutex::new(None);
/// Notified of every change that a thread may wait for.
pub(crate) static CHANGED: Condvar = Condvar::new();

/// The locked library, created on first use.
pub(crate) struct Locked(MutexGuard<'static, Option<Twin>>);

impl std::ops::Deref for Locked {
    type Target = Twin;

    fn deref(&self) -> &Twin {
        self.0.as_ref().expect("made when it was locked")
    }
}

impl std::ops::DerefMut for Locked {
    fn deref_mut(&mut self) -> &mut Twin {
        self.0.as_mut().expect("made when it was locked")
    }
}

impl Locked {
    /// Waits for a change, at most `timeout`.
    pub(crate) fn wait(self, timeout: std::time::Duration) -> Self {
        let wait_result = CHANGED.wait_timeout(self.0, timeout);
        Self(wait_result.unwrap_or_else(PoisonError::into_inner).0)
    }
}

/// Locks the library.
pub(crate) fn lock() -> Locked {
    let mut twin = TWIN.lock().unwrap_or_else(PoisonError::into_inner);
    twin.get_or_insert_with(Twin::new);
    Locked(twin)
}

/// Locks the library; connects an apparatus first if necessary.
pub(crate) fn with_apparatus() -> Locked {
    let mut twin = lock();
    if twin.board.is_none() {
        twin.board = own_apparatus::board();
    }
    twin
}

impl Twin {
    fn new() -> Self {
        let name = std::env::var("MOCK_NIDAQMX_PRODUCT").unwrap_or_default();
        let product = PRODUCTS.iter().find(|product| product.name == name);
        Self {
            board: None,
            product: *product.unwrap_or(&PRODUCTS[0]),
            tasks: BTreeMap::new(),
            task_count: 0,
            is_gone: false,
            open: false,
            held_v: 0.0,
            played_frames: 0,
            inputs_ran: false,
        }
    }

    /// Creates a task; returns its handle.
    pub(crate) fn create(&mut self) -> usize {
        self.task_count += 1;
        self.tasks.insert(self.task_count, Task::new());
        self.task_count
    }

    /// Returns a task of a card that is present.
    pub(crate) fn task(&mut self, handle: *mut c_void) -> Result<&mut Task, i32> {
        let is_gone = self.is_gone;
        let task = self.tasks.get_mut(&(handle as usize)).ok_or(NO_TASK)?;
        if is_gone { Err(UNREACHABLE) } else { Ok(task) }
    }

    /// Returns the streaming task of a kind.
    pub(crate) fn streaming_task(&mut self, kind: Kind) -> Option<&mut Task> {
        let mut tasks = self.tasks.values_mut();
        tasks.find(|task| task.kind == kind && task.streams())
    }
}

#[unsafe(no_mangle)]
pub extern "C" fn mock_nidaqmx_connect(board: Board) {
    let (previous, was_open) = {
        let mut twin = lock();
        twin.is_gone = false;
        let was_open = std::mem::take(&mut twin.open);
        (twin.board.replace(board), was_open)
    };
    if let Some(previous) = previous {
        if was_open {
            (previous.close)(previous.context);
        }
        (previous.release)(previous.context);
    }
}

/// Returns the text of a C string.
///
/// # Safety
/// The pointer must be null or of a C string.
pub(crate) unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: the caller's pointer is that of a C string.
    unsafe { CStr::from_ptr(pointer) }
        .to_string_lossy()
        .into_owned()
}
