//! Why a trial must be repeated.

use serde::{Deserialize, Serialize};

/// Why a trial must be repeated; the text is for the operator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum RedoReason {
    /// The mean normal force of an exploration left the band.
    #[error(
        "exploration {exploration}: mean normal force {} N, outside {min_n:.2} to {max_n:.2} N",
        outside(*.mean_n, [*.min_n, *.max_n], 2)
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
        "exploration {exploration}: mean speed {} mm/s, outside {:.0} to {:.0} mm/s",
        outside(.speed_m_per_s * 1e3, [.min_m_per_s * 1e3, .max_m_per_s * 1e3], 0),
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
    /// The finger left the plate within an exploration.
    #[error(
        "exploration {exploration}: finger off the plate for {lifted_s:.2} s of its central part, less than {limit_s:.2} s allowed"
    )]
    FingerLifted {
        /// The exploration, from 1.
        exploration: usize,
        /// Time off the plate, s.
        lifted_s: f64,
        /// Upper limit of this time, s.
        limit_s: f64,
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

/// Returns a value outside `band` with at least `decimals` decimals, and as many more as show that it is outside.
fn outside(value: f64, band: [f64; 2], decimals: usize) -> String {
    let rounded = |x: f64, decimals: usize| format!("{x:.decimals$}");
    (decimals..decimals + 4)
        .find(|&decimals| {
            let is_limit = |limit: &f64| rounded(*limit, decimals) == rounded(value, decimals);
            !band.iter().any(is_limit)
        })
        .map_or_else(
            || rounded(value, decimals),
            |decimals| rounded(value, decimals),
        )
}

impl RedoReason {
    /// Returns the reason in a few words, as parts of which a narrow screen leaves out the last.
    fn brief(&self) -> Vec<String> {
        match self {
            Self::ForceOutOfBand {
                mean_n,
                min_n,
                max_n,
                ..
            } => vec![
                format!("force {} N", outside(*mean_n, [*min_n, *max_n], 2)),
                format!("band {min_n:.2}–{max_n:.2}"),
            ],
            Self::SpeedOutOfBand {
                speed_m_per_s,
                min_m_per_s,
                max_m_per_s,
                ..
            } => {
                let band = [min_m_per_s * 1e3, max_m_per_s * 1e3];
                vec![
                    format!("speed {} mm/s", outside(speed_m_per_s * 1e3, band, 0)),
                    format!("band {:.0}–{:.0}", band[0], band[1]),
                ]
            }
            Self::FingerLifted {
                exploration,
                lifted_s,
                ..
            } => vec![
                format!("finger off for {lifted_s:.2} s"),
                format!("exploration {exploration}"),
            ],
            Self::NotMeasured { exploration } => vec![
                "force or position not measured".to_owned(),
                format!("exploration {exploration}"),
            ],
            Self::Clipped { frames, limit } => {
                vec![
                    format!("{frames} clipped frames"),
                    format!("{limit} allowed"),
                ]
            }
            Self::LostSamples { frames, limit } => {
                vec![
                    format!("{frames} lost audio frames"),
                    format!("{limit} allowed"),
                ]
            }
            Self::Xruns {
                input,
                output,
                limit,
            } => vec![
                format!("xruns: {}", input + output),
                format!("{limit} allowed"),
            ],
            Self::TooFewInstances {
                found,
                needed,
                mostly,
            } => {
                let counts = [format!("{found} instances"), format!("{needed} needed")];
                counts.into_iter().chain(mostly.clone()).collect()
            }
            Self::FingerOnPlate { mean_n, limit_n } => vec![
                "finger on the plate in the baseline".to_owned(),
                format!("{mean_n:.2} N"),
                format!("less than {limit_n:.2} N needed"),
            ],
            Self::BaselineNotMeasured => vec!["force of the baseline not measured".to_owned()],
            Self::NotAnalysed => vec!["not analysed in time".to_owned()],
        }
    }
}

/// Returns reasons in a few words each, as parts of which a narrow screen leaves out the last. The same reason of several
/// explorations is stated once, with the first value.
///
/// ```
/// use protocols::{RedoReason, brief_reasons};
///
/// let force = |exploration, mean_n| RedoReason::ForceOutOfBand { exploration, mean_n, min_n: 0.5, max_n: 0.8 };
/// assert_eq!(brief_reasons(&[force(1, 0.49), force(2, 0.3)]), [["force 0.49 N", "band 0.50–0.80"]]);
/// assert_eq!(brief_reasons(&[force(1, 0.4996)])[0][0], "force 0.4996 N");
/// ```
#[must_use]
pub fn brief_reasons(reasons: &[RedoReason]) -> Vec<Vec<String>> {
    let mut kinds = Vec::new();
    let first_of_kind = |reason: &&RedoReason| {
        let kind = std::mem::discriminant(*reason);
        let is_new = !kinds.contains(&kind);
        kinds.push(kind);
        is_new
    };
    let reasons = reasons.iter().filter(first_of_kind);
    reasons.map(RedoReason::brief).collect()
}
