//! The session task: passes acquired data to the protocol's state machine, and the machine's requests to the devices.

mod acquired;
mod at_a_glance;
mod command_queue;
mod end_state;
mod last_halt;
mod last_safety;
mod operator_request;
mod report;
mod saved;
mod stop_kind;
mod task;
mod wiring;

pub use operator_ui::questions::Questions;
pub use report::{KeptUp, SessionReport, summary_lines};
pub use task::SessionTask;
pub use wiring::{Admit, BeginRecording, Wiring};
