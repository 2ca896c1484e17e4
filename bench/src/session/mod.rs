//! The session task: acquired data go to the protocol's state machine, what it asks for goes to the devices.

mod how_ended;
mod report;
mod stop_kind;
mod task;
mod wiring;

pub use report::{KeptUp, Report, summary_lines};
pub use task::SessionTask;
pub use wiring::{Admit, BeginRecording, Wiring};
