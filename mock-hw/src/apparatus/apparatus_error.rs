//! Reasons for which the apparatus cannot be built or cannot continue.

use std::io;
use std::path::PathBuf;

/// Why the apparatus cannot be built or cannot continue.
#[derive(Debug, thiserror::Error)]
pub enum ApparatusError {
    /// A period that does not hold whole frames at every rate of the sound cards.
    #[error("a period of {frames} frames is not a multiple of {multiple} from {low} to {high}")]
    Period {
        /// The period asked for, frames at 192 kHz.
        frames: u32,
        /// Number of which the period must be a multiple.
        multiple: u32,
        /// Shortest period, frames.
        low: u32,
        /// Longest period, frames.
        high: u32,
    },
    /// A serial line could not be made or has failed.
    #[error("the simulated serial line cannot be made or has failed")]
    Serial(#[source] io::Error),
    /// A simulated instrument's place in the network could not be had or has failed.
    #[error("the simulated network cannot be had or has failed")]
    Network(#[source] io::Error),
    /// The operating system has no pseudo-terminals, so there is no simulated serial port to open.
    #[error(
        "no simulated serial port for the {device}: this operating system has no pseudo-terminals"
    )]
    NoSerialPort {
        /// The device whose port was asked for.
        device: &'static str,
    },
    /// A field box was asked of an apparatus without digital lines.
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
        /// Where it should be.
        path: PathBuf,
    },
    /// The oscilloscope's file could not be made.
    #[error("the file {} of the oscilloscope cannot be made", path.display())]
    Oscilloscope {
        /// Where it should be.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The real-time thread could not be started.
    #[error("the thread of the apparatus cannot be started")]
    Thread(#[source] io::Error),
    /// A step was asked of an apparatus that advances by itself.
    #[error("a real-time apparatus advances by itself and cannot be stepped")]
    NotStepped,
    /// The real-time thread has panicked, in one of the bench's callbacks or in the simulation.
    #[error("the thread of the apparatus has panicked")]
    Panicked,
}
