//! Reasons why an instance cannot be fitted.

use statistics::significant;
use thiserror::Error;

use contact::ModelError;

/// Reasons why an instance cannot be fitted at all. An unreliable fit reports its reason in its
/// [`FitVerdict`](super::FitVerdict).
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// The model does not allow a sample or an assumed constant.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The instance is too short.
    #[error("instance has {got} samples, needs at least {needed}")]
    TooFewSamples {
        /// Number of samples in the instance.
        got: usize,
        /// Fewest samples accepted.
        needed: usize,
    },
    /// The lead-in is too short for the levitation lag to forget its initial value.
    #[error("lead-in is {} s, needs {} s before the instance", significant(*.got_s), significant(*.needed_s))]
    LeadInTooShort {
        /// Lead-in given, s.
        got_s: f64,
        /// Lead-in needed, s.
        needed_s: f64,
    },
    /// Samples are not evenly spaced.
    #[error(
        "sample {index}: {} s after the one before, where the record's interval is {} s",
        significant(*.step_s), significant(*.interval_s)
    )]
    UnevenTime {
        /// Index of the sample.
        index: usize,
        /// Time from the sample before, s.
        step_s: f64,
        /// Mean interval of the record, s.
        interval_s: f64,
    },
    /// No σ_t between 0.2 and 20 µm gives a contact that the model allows with these data.
    #[error(
        "no sigma_t between 0.2 and 20 um gives a contact that the model allows with these impedances and forces"
    )]
    NoStart,
}
