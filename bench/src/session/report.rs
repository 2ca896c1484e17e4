//! How a session ended, and the lines that say so.

use protocols::SessionSummary;
use recording::pipeline::Account;

/// How a session ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The session in numbers.
    pub summary: SessionSummary,
    /// Account of the audio frames.
    pub account: Account,
    /// Nobody is left to go on: every trial is settled.
    pub completed: bool,
    /// What ended it early.
    pub reason: Option<String>,
}

/// The session in a few lines.
pub fn summary_lines(summary: &SessionSummary, account: &Account) -> Vec<String> {
    let force = summary
        .mean_normal_n
        .map_or_else(|| "not measured".to_owned(), |n| format!("{n:.3} N"));
    vec![
        format!(
            "trials accepted   {} of {}",
            summary.accepted, summary.planned
        ),
        format!("trials repeated   {}", summary.redone),
        format!("mean normal force {force}"),
        format!("instances         {}", summary.instances),
        format!(
            "drop-outs         {} frames lost, {} input and {} output xruns",
            account.lost_frames, account.input_xruns, account.output_xruns
        ),
    ]
}
