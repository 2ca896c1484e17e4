//! Faults of the simulated apparatus while the real tasks run.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod alignment;
mod box_watchdog;
mod calibrating;
mod clocks;
mod delay;
mod exclusive;
mod field_box;
mod flags;
mod freezes;
mod gauges;
mod held_up;
mod interference;
mod net_ft;
mod person;
mod rehearsed;
mod rig;
mod safe;
mod session_rig;
mod stall;
mod stops;
mod xrun;

use reference_worlds::campaign;
