//! Report of the program `panicking-bench` about one run.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

/// Part that panics on a separate thread, which is not a task.
pub const OTHER_THREAD: &str = "other-thread";
/// The thread that times the panic.
pub const HAND: &str = "hand";

/// An edge of a line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// The apparatus's time, ns.
    pub at_ns: u64,
    /// Name of the line.
    pub line: String,
    /// Level after the edge.
    pub high: bool,
}

/// History of the bench.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// Time of the panic on the apparatus's clock, ns; 0 without one.
    pub panicked_ns: u64,
    /// Edges of the lines that the bench drives, in order.
    pub edges: Vec<Edge>,
    /// Names of the threads that read the bench's clock: its tasks, and the main thread.
    pub clock_readers: BTreeSet<String>,
}
