//! Selects the instances of a whole trial, live or from a recording.

use protocols::selection::analyse_exploration;
use protocols::{
    ExplorationAnalysis, Interval, IntervalKind, SelectionRules, TrialAnalysis, TrialKey,
};

use crate::measurements::Measurements;

/// Selects the instances of every exploration and computes the means needed for a verdict. Counts of lost and clipped
/// frames are left at 0 for the caller to fill in.
pub fn analyse(
    key: &TrialKey,
    intervals: &[Interval],
    record: &Measurements,
    rules: &SelectionRules,
) -> TrialAnalysis {
    let mut unloaded_mean_normal_n = None;
    let mut explorations = Vec::new();
    for interval in intervals {
        match interval.kind {
            IntervalKind::Unloaded => {
                unloaded_mean_normal_n = record.mean_normal_n(interval.start_s, interval.end_s)
            }
            IntervalKind::Exploration { direction } => {
                let series = record.series(interval.start_s, interval.end_s);
                // Frames come from one demodulator, so the series is valid; without frames nothing was measured.
                let analysis = analyse_exploration(&series.exploration(direction), rules);
                explorations.push(analysis.unwrap_or(ExplorationAnalysis {
                    direction,
                    mean_normal_n: None,
                    mean_speed_m_per_s: None,
                    lifted_s: 0.0,
                    stretches: Vec::new(),
                }));
            }
        }
    }
    TrialAnalysis {
        key: key.clone(),
        explorations,
        unloaded_mean_normal_n,
        clipped_frames: 0,
        lost_frames: 0,
        input_xruns: 0,
        output_xruns: 0,
    }
}
