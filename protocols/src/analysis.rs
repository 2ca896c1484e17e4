//! Results of the measurements in an attempt at a trial.

use crate::stretch::Stretch;
use crate::trial::{Direction, TrialKey};
use serde::{Deserialize, Serialize};

/// Results of one exploration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplorationAnalysis {
    /// Direction in which the finger slid.
    pub direction: Direction,
    /// Mean normal force of the contact on the plate's central part, N; `None` without a valid frame in contact there.
    pub mean_normal_n: Option<f64>,
    /// Mean speed along the direction in the same frames, m/s.
    pub mean_speed_m_per_s: Option<f64>,
    /// Time for which the finger was off the plate on its central part, s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lifted_s: f64,
    /// All rising stretches in order, accepted and rejected.
    pub stretches: Vec<Stretch>,
}

/// Returns whether a time is left out of the event log.
fn is_zero(time_s: &f64) -> bool {
    *time_s == 0.0
}

impl ExplorationAnalysis {
    /// Returns the number of accepted stretches.
    pub fn instances(&self) -> usize {
        self.stretches
            .iter()
            .filter(|s| s.instance().is_some())
            .count()
    }
}

/// Results of one attempt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialAnalysis {
    /// The attempt.
    pub key: TrialKey,
    /// Its explorations, in order.
    pub explorations: Vec<ExplorationAnalysis>,
    /// Mean normal force of the baseline, when no finger should be on the plate, N; `None` if it was not measured.
    pub unloaded_mean_normal_n: Option<f64>,
    /// Input frames at the limit of the converter's range.
    pub clipped_frames: u64,
    /// Input frames lost, written as NaN.
    pub lost_frames: u64,
    /// Input overruns that lost frames, or may have.
    pub input_xruns: u64,
    /// Output underruns that lost frames, or may have.
    pub output_xruns: u64,
}

impl TrialAnalysis {
    /// Returns the number of accepted stretches of all explorations.
    pub fn instances(&self) -> usize {
        self.explorations
            .iter()
            .map(ExplorationAnalysis::instances)
            .sum()
    }
}
