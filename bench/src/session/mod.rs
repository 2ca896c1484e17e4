//! The session task: acquired data go to the protocol's state machine, what it asks for goes to the devices.

mod ending;
mod report;
mod task;
mod wiring;

pub use report::{Report, summary_lines};
pub use task::SessionTask;
pub use wiring::{Admit, BeginRecording, Wiring};
