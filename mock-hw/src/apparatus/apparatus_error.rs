//! Reasons why the apparatus cannot be built or cannot continue.

use std::io;
use std::path::PathBuf;

/// Reason why the apparatus cannot be built or cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum ApparatusError {
    /// A period without a whole number of frames at every rate of the sound cards.
    #[error("a period of {frames} frames is not a multiple of {multiple} from {low} to {high}")]
    Period {
        /// Requested period, frames at 192 kHz.
        frames: u32,
        /// Required divisor of the period, frames.
        multiple: u32,
        /// Shortest period, frames.
        low: u32,
        /// Longest period, frames.
        high: u32,
    },
    /// A serial line could not be created or has failed.
    #[error("the simulated serial line cannot be made or has failed")]
    Serial(#[source] io::Error),
    /// A simulated instrument's network socket could not be opened or has failed.
    #[error("the simulated network cannot be had or has failed")]
    Network(#[source] io::Error),
    /// The operating system has no pseudo-terminals, so there is no simulated serial port to open.
    #[error(
        "no simulated serial port for the {device}: this operating system has no pseudo-terminals"
    )]
    NoSerialPort {
        /// Device of the requested port.
        device: &'static str,
    },
    /// A field box was requested for an apparatus without digital lines.
    #[error(
        "this apparatus has no digital lines, and a field box drives them: choose a scenario without one"
    )]
    NoLines,
    /// The truth of the run could not be written.
    #[error("the truth of the run cannot be written")]
    Truth(#[source] io::Error),
    /// The folder for the truth of the run does not exist.
    #[error("the folder {} for the truth of the run does not exist; create it first", path.display())]
    NoTruthFolder {
        /// Expected path.
        path: PathBuf,
    },
    /// The oscilloscope's file could not be created.
    #[error("the file {} of the oscilloscope cannot be made", path.display())]
    Oscilloscope {
        /// Expected path.
        path: PathBuf,
        /// Underlying error.
        source: io::Error,
    },
    /// The real-time thread could not be started.
    #[error("the thread of the apparatus cannot be started")]
    Thread(#[source] io::Error),
    /// A step was requested of an apparatus that advances in real time.
    #[error("a real-time apparatus advances by itself and cannot be stepped")]
    NotStepped,
    /// The real-time thread has panicked, in one of the bench's callbacks or in the simulation.
    #[error("the thread of the apparatus has panicked")]
    Panicked,
}
