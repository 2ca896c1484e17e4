//! What the program `panicking-bench` tells of a run of its own.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

/// A part that panics on a thread of its own, which is no task.
pub const OTHER_THREAD: &str = "other-thread";
/// The thread that chooses the moment.
pub const HAND: &str = "hand";

/// An edge of a line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// The apparatus's time, ns.
    pub at_ns: u64,
    /// Name of the line.
    pub line: String,
    /// Level after it.
    pub high: bool,
}

/// What happened to the bench.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// The apparatus's time of the panic, ns; 0 without one.
    pub panicked_ns: u64,
    /// Edges of the lines that the bench drives, in order.
    pub edges: Vec<Edge>,
    /// Names of the threads that read the bench's clock: its tasks, and the main thread.
    pub clock_readers: BTreeSet<String>,
}
