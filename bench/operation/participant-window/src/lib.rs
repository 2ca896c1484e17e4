//! The participant's window: true to the millimetre, a separate process, connected to the session by a local socket.
//!
//! - [`message`], [`motion`], [`bench_clock`]: the messages between session and window, and the slider's position
//!   between two messages.
//! - `seat` (Unix): the session's end of the socket, which never blocks.
//! - [`page`] on a [`canvas`], with a [`geometry`] and a [`lettering`]; [`ruler`], [`scales`]: the picture, without a
//!   display, and the width of a pixel.
//! - [`frame_log`]: presentation times of the frames, and the slider's deviation from its ideal position.
//! - [`fitness`]: checks whether a finger can follow the window.
//! - [`participant_options`], `launch` (Unix): the start of `friction-bench-participant`, which opens the window on a screen.

pub mod bench_clock;
pub mod canvas;
pub mod fitness;
pub mod frame_log;
pub mod geometry;
#[cfg(unix)]
pub mod launch;
pub mod lettering;
#[cfg(unix)]
mod lines;
pub mod message;
pub mod motion;
pub mod page;
pub mod participant_options;
#[cfg(unix)]
pub mod place;
pub mod ruler;
pub mod scales;
#[cfg(unix)]
pub mod seat;

#[cfg(unix)]
pub use lines::{ConnectionEnd, LineConnection};

/// Compiles and runs the examples in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
