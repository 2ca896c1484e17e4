//! The participant's window, as a session has it: a display that is shown views and told the time, and a task at its socket.

#[cfg(unix)]
mod window_display;
#[cfg(not(unix))]
#[path = "elsewhere.rs"]
mod window_display;

pub use window_display::{WindowDisplay, default_socket};
