//! The participant's window: true to the millimetre, a process of its own, fed by the session through a local socket.
//!
//! - [`message`], [`motion`], [`bench_clock`]: what session and window say to each other, and how the window knows where the
//!   slider is between two messages.
//! - `seat` (Unix): the session's end of the socket, which never waits.
//! - [`page`] on a [`canvas`], by a [`geometry`] and in a [`lettering`]; [`ruler`], [`scales`]: the picture, without any
//!   display, and the width of a pixel.
//! - [`frame_log`]: when the frames came, and how far the slider was from its ideal.
//! - [`fitness`]: whether a finger can follow what the window shows.
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
pub use lines::{Ended, Lines};

/// Compiles and runs the examples in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
