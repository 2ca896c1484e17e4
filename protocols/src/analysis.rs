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
    /// Whether the finger was measured to be off the plate throughout the central part.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_lifted: bool,
    /// All rising stretches in order, accepted and rejected.
    pub stretches: Vec<Stretch>,
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
