//! The participant's window, as a session uses it: a display that receives views and times, and a task at its socket.

#[cfg(unix)]
mod window_display;
#[cfg(not(unix))]
#[path = "unsupported.rs"]
mod window_display;

pub use window_display::{WindowDisplay, default_socket};
