//! Time, tasks and the schedule that runs them.
//!
//! A bench is a handful of [`Task`]s that share nothing but queues and [`Slot`]s. A [`Schedule`] gives each its own
//! thread, or runs them in turn on one thread, in step with an apparatus that advances its own [`Clock`].

mod clock;
mod mailbox;
mod schedule;
pub mod scheduling;
mod slot;

pub use clock::{Clock, SystemClock, later};
pub use mailbox::Mailbox;
pub use schedule::{Pacer, Panicked, RaiseOnDrop, Schedule, StopFlag, Task};
pub use slot::Slot;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
