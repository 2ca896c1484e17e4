//! Drills for the operator: faults come one after another while the bench drives, the operator responds, and the times are
//! recorded.
//!
//! On simulated hardware a [`FaultHand`] injects the faults. On real hardware a person is asked to cause them, during a faint
//! tone. Each exercise opens the bench again, because some faults end it.

mod course;
mod draw;
mod drill_task;
mod exercise;
pub mod fault_option;
mod page;
mod panels;
mod record;
pub mod rehearsed;
mod scripted;
mod signs;
mod times;

pub use course::{Course, WatchedHardware};
pub use draw::NotDrilledError;
pub use record::{DrillFolder, DrillRecord, ExerciseRecord};
pub use scripted::Scripted;
pub use signs::is_sign;
pub use times::{ExerciseOutcome, Times};

use faults::FaultKind;

/// Amplitude of the faint tone that drives a real bench, V peak.
pub const TONE_V: f64 = 2.0;

/// A change to a simulated apparatus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deed {
    /// A fault begins.
    Begin(FaultKind),
    /// A fault ends.
    End(FaultKind),
}

/// Injects faults into a simulated apparatus, and removes them.
pub type FaultHand = Box<dyn FnMut(Deed) + Send>;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
