//! The operator's terminal: keys from it, whole frames to it, and its restoration.
//!
//! A terminal may block, after Ctrl-S, with Scroll Lock, or on a connection that hangs. No function here waits for it
//! indefinitely: a separate thread writes the frames, so that the stop key is still read.

mod error;
mod frames;
mod keys;
mod operator_screen;

pub use error::TerminalError;
pub use frames::{FrameWriter, Frames};
pub use keys::{Keys, TerminalKeys};
pub use operator_screen::{OperatorScreen, install_panic_hook, is_dumb, restore, size};
