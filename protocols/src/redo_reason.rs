//! Why a trial must be repeated.

use serde::{Deserialize, Serialize};

/// Why a trial must be repeated; the text is for the operator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum RedoReason {
    /// The mean normal force of an exploration left the band.
    #[error(
        "exploration {exploration}: mean normal force {mean_n:.2} N, outside {min_n:.2} to {max_n:.2} N"
    )]
    ForceOutOfBand {
        /// The exploration, from 1.
        exploration: usize,
        /// Its mean normal force, N.
        mean_n: f64,
        /// Lower end of the band, N.
        min_n: f64,
        /// Upper end of the band, N.
        max_n: f64,
    },
    /// The mean speed of an exploration differed too much from the slider's.
    #[error(
        "exploration {exploration}: mean speed {:.0} mm/s, outside {:.0} to {:.0} mm/s",
        .speed_m_per_s * 1e3,
        .min_m_per_s * 1e3,
        .max_m_per_s * 1e3
    )]
    SpeedOutOfBand {
        /// The exploration, from 1.
        exploration: usize,
        /// Its mean speed along the direction, m/s.
        speed_m_per_s: f64,
        /// Smallest allowed speed, m/s.
        min_m_per_s: f64,
        /// Largest allowed speed, m/s.
        max_m_per_s: f64,
    },
    /// Force or position of an exploration was not measured.
    #[error("exploration {exploration}: no valid force or position on the plate's central part")]
    NotMeasured {
        /// The exploration, from 1.
        exploration: usize,
    },
    /// An input reached the limit of the converter's range.
    #[error("{frames} clipped frames, {limit} allowed: lower the input gain or the amplitude")]
    Clipped {
        /// Number of clipped frames.
        frames: u64,
        /// Allowed number.
        limit: u64,
    },
    /// Input frames were lost.
    #[error("{frames} lost frames, {limit} allowed")]
    LostSamples {
        /// Number of lost frames.
        frames: u64,
        /// Allowed number.
        limit: u64,
    },
    /// Input overruns and output underruns of the sound card.
    #[error("{input} input and {output} output xruns, {limit} allowed")]
    Xruns {
        /// Overruns of the input.
        input: u64,
        /// Underruns of the output.
        output: u64,
        /// Allowed number of both together.
        limit: u64,
    },
    /// A trial has too few instances for an estimate.
    #[error(
        "{found} instances, {needed} needed{}",
        .mostly.as_ref().map(|m| format!("; most other stretches: {m}")).unwrap_or_default()
    )]
    TooFewInstances {
        /// Number of accepted stretches.
        found: usize,
        /// Number needed.
        needed: u32,
        /// Most frequent reason among the rejected stretches.
        mostly: Option<String>,
    },
    /// A finger was on the plate during the baseline.
    #[error(
        "finger on the plate during the baseline: mean normal force {mean_n:.2} N, less than {limit_n:.2} N needed"
    )]
    FingerOnPlate {
        /// Mean normal force of the baseline, N.
        mean_n: f64,
        /// Upper limit of this force, N.
        limit_n: f64,
    },
    /// The baseline's force was not measured.
    #[error("the normal force of the baseline was not measured")]
    BaselineNotMeasured,
    /// The analysis timed out.
    #[error("the trial was not analysed in time")]
    NotAnalysed,
}
