//! Front ends of a bench: the operator's [`Dashboard`], or lines of text by [`Headless`]. Both take the same stream of events,
//! and neither makes the bench wait.

pub mod complaint;
mod dashboard_thread;
mod front;
mod headless;
mod lines;
mod safety_event;
mod stop_keys;

pub use dashboard_thread::{Dashboard, DashboardThread};
pub use front::Front;
pub use headless::Headless;
pub use lines::LineQueue;
pub use safety_event::safety_event;
pub use stop_keys::StopKeys;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
