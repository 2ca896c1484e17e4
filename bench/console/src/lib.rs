//! Front ends of a bench: the operator's [`Dashboard`], or lines of text by [`Headless`]. One stream of events feeds
//! both, and neither makes the bench wait.

pub mod complaint;
mod dashboard_thread;
mod front;
mod headless;
mod safety_event;

pub use dashboard_thread::{Dashboard, DashboardThread};
pub use front::Front;
pub use headless::Headless;
pub use safety_event::safety_event;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
