//! The demonstration: calibrates and checks a simulated bench with unknown constants, runs a session of one virtual
//! participant, and draws results and figures.
//!
//! Each step runs this program with the arguments of a command that a user could type. No state of a step (signal handlers,
//! priorities, terminal settings) reaches the next, and a demonstration shows the same as these commands do.

mod demonstration;
mod error;
mod folder;
mod process;
mod signals;
mod steps;

pub use demonstration::{DemoEnd, DemoOptions, run};
pub use error::DemoError;
