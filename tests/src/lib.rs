//! Shared parts of the whole-bench tests: the programs under test, running sessions, and the files they leave on disk.

pub mod finding;
pub mod handbook;
pub mod house;
pub mod hung;
pub mod in_process;
pub mod panicking;
pub mod program;
pub mod recorded;
pub mod room;
pub mod run_cost;
pub mod running;
pub mod screen;
pub mod session;
pub mod shared;
#[path = "../../bench/src/bin/friction-bench/simulated_person.rs"]
mod simulated_person;
pub mod thread_hold;
pub mod truth;

pub use reference_worlds::campaign;
