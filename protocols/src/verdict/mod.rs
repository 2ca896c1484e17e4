//! Verdicts: whether a trial is accepted, or why it must be repeated.

mod judge;

pub use crate::analysis::{ExplorationAnalysis, TrialAnalysis};
pub use crate::redo_reason::RedoReason;
pub use crate::rules::VerdictRules;
pub use crate::summary::SessionSummary;
pub use judge::{Verdict, judge};
