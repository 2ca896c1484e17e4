//! The operator's terminal: keys from it, whole frames to it, and as it was afterwards.
//!
//! A terminal may stand still, after Ctrl-S, with Scroll Lock, or behind a connection that is stuck. Nothing here waits
//! for it: frames are written by a thread of their own, so that the key that stops the drive is read all the same.

mod error;
mod frames;
mod keys;
mod restored;

pub use error::TerminalError;
pub use frames::{FrameWriter, Frames};
pub use keys::{Keys, TerminalKeys};
pub use restored::{OperatorScreen, install_panic_hook, restore, size};
