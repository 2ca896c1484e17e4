//! Summary of a session in numbers.

use crate::record::{TrialOutcome, TrialRecord};
use serde::{Deserialize, Serialize};

/// Counts and means over the attempts of a session. Practice trials count only in `practice` and in the lost frames,
/// clipped frames and xruns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SessionSummary {
    /// Trials in the protocol, practice not counted.
    pub planned: u32,
    /// Practice trials settled.
    pub practice: u32,
    /// Trials accepted by their verdict.
    pub accepted: u32,
    /// Trials rejected by their verdict and kept by the operator.
    pub accepted_anyway: u32,
    /// Trials given up at the redo limit.
    pub given_up: u32,
    /// Repetitions because of a verdict, or by the operator after one.
    pub redone: u32,
    /// Interrupted attempts.
    pub interrupted: u32,
    /// Instances in accepted and kept trials.
    pub instances: u64,
    /// Mean normal force of the explorations of accepted and kept trials, N; `None` if there is no such exploration.
    pub mean_normal_n: Option<f64>,
    /// Lost frames in all analysed attempts.
    pub lost_frames: u64,
    /// Clipped frames in all analysed attempts.
    pub clipped_frames: u64,
    /// Input and output xruns that lost frames, or may have, in all analysed attempts.
    pub xruns: u64,
}

impl SessionSummary {
    /// Summarises the attempts of a session of `planned` trials, practice not counted.
    pub fn new(planned: u32, records: &[TrialRecord]) -> Self {
        let mut summary = Self {
            planned,
            ..Self::default()
        };
        let mut forces = Vec::new();
        for record in records {
            if let Some(analysis) = &record.analysis {
                summary.lost_frames += analysis.lost_frames;
                summary.clipped_frames += analysis.clipped_frames;
                summary.xruns += analysis.input_xruns + analysis.output_xruns;
            }
            if record.key.practice {
                summary.practice += u32::from(record.outcome.settles());
                continue;
            }
            let (count, is_kept) = match &record.outcome {
                TrialOutcome::Accepted => (&mut summary.accepted, true),
                TrialOutcome::AcceptedAnyway { .. } => (&mut summary.accepted_anyway, true),
                TrialOutcome::GivenUp { .. } => (&mut summary.given_up, false),
                TrialOutcome::Redo { .. } => (&mut summary.redone, false),
                TrialOutcome::Interrupted { .. } => (&mut summary.interrupted, false),
            };
            *count += 1;
            if let (true, Some(analysis)) = (is_kept, &record.analysis) {
                summary.instances += analysis.instances() as u64;
                forces.extend(analysis.explorations.iter().filter_map(|e| e.mean_normal_n));
            }
        }
        if !forces.is_empty() {
            summary.mean_normal_n = Some(forces.iter().sum::<f64>() / forces.len() as f64);
        }
        summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{ExplorationAnalysis, TrialAnalysis};
    use crate::redo_reason::RedoReason;
    use crate::stretch::{Instance, Stretch, StretchOutcome};
    use crate::trial::{Direction, Interruption, TrialKey};

    /// Returns an analysis of two explorations with six instances each.
    fn trial_analysis() -> TrialAnalysis {
        let stretch = Stretch {
            start_s: 1.0,
            end_s: 1.083,
            outcome: StretchOutcome::Accepted(Instance {
                start_s: 1.01,
                end_s: 1.07,
            }),
        };
        let exploration = |direction| ExplorationAnalysis {
            direction,
            mean_normal_n: Some(0.65),
            mean_speed_m_per_s: Some(0.051),
            lifted_s: 0.0,
            stretches: vec![stretch; 6],
        };
        TrialAnalysis {
            key: TrialKey {
                number: 3,
                attempt: 1,
                practice: false,
                condition: "am".to_owned(),
            },
            explorations: vec![
                exploration(Direction::LeftToRight),
                exploration(Direction::RightToLeft),
            ],
            unloaded_mean_normal_n: Some(0.002),
            clipped_frames: 0,
            lost_frames: 0,
            input_xruns: 0,
            output_xruns: 0,
        }
    }

    #[test]
    fn the_summary_counts_kept_trials_and_all_drop_outs() {
        let record = |number, attempt, practice, outcome, lost_frames| {
            let mut analysis = trial_analysis();
            analysis.key = TrialKey {
                number,
                attempt,
                practice,
                condition: "am".to_owned(),
            };
            analysis.lost_frames = lost_frames;
            TrialRecord {
                key: analysis.key.clone(),
                outcome,
                analysis: Some(analysis),
            }
        };
        let redo = TrialOutcome::Redo {
            reasons: vec![RedoReason::NotAnalysed],
        };
        let mut interruption_record = record(
            3,
            1,
            false,
            TrialOutcome::Interrupted {
                interruption: Interruption::Paused,
            },
            0,
        );
        interruption_record.analysis = None;
        let summary = SessionSummary::new(
            4,
            &[
                record(1, 1, true, TrialOutcome::Accepted, 0),
                record(2, 1, false, redo, 7),
                record(2, 2, false, TrialOutcome::Accepted, 0),
                interruption_record,
                record(
                    3,
                    2,
                    false,
                    TrialOutcome::AcceptedAnyway { reasons: vec![] },
                    2,
                ),
                record(4, 1, false, TrialOutcome::GivenUp { reasons: vec![] }, 1),
            ],
        );
        assert!((summary.mean_normal_n.unwrap() - 0.65).abs() < 1e-12);
        let expected = SessionSummary {
            planned: 4,
            practice: 1,
            accepted: 1,
            accepted_anyway: 1,
            given_up: 1,
            redone: 1,
            interrupted: 1,
            instances: 24,
            mean_normal_n: summary.mean_normal_n,
            lost_frames: 10,
            clipped_frames: 0,
            xruns: 0,
        };
        assert_eq!(summary, expected);
        assert_eq!(SessionSummary::new(4, &[]).mean_normal_n, None);
    }
}
