//! The demonstration: calibrates and checks a simulated bench with unknown constants, runs a session of one virtual
//! participant, and draws results and figures.
//!
//! Each step is a process of this program with the words of a command that a user could type, so that nothing of one step
//! (handlers of signals, priorities, the state of a terminal) is left to the next, and a demonstration shows what a user gets.

mod demonstration;
mod error;
mod folder;
mod process;
mod signals;
mod steps;

pub use demonstration::{Ended, Options, run};
pub use error::DemoError;
