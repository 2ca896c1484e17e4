//! Reasons why responses determine no resonance.

/// Fewest complex tones: they have four values more than the fit has parameters.
pub const LEAST_TONES: usize = 6;

/// Reasons why responses determine no resonance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlateFitError {
    /// Fewer tones than the fit needs.
    #[error("{count} tones are too few for the plate's fit: at least {LEAST_TONES} are needed")]
    TooFew {
        /// Number of tones.
        count: usize,
    },
    /// A ratio is NaN or infinite.
    #[error("the response at {} Hz is not finite", statistics::significant(*.frequency_hz))]
    NotFinite {
        /// Frequency of that ratio, Hz.
        frequency_hz: f64,
    },
    /// The largest response lies at the edge of the band.
    #[error(
        "no resonance between {from_hz:.0} and {to_hz:.0} Hz: the response is largest at {peak_hz:.0} Hz, the band's edge"
    )]
    OutOfBand {
        /// Lowest tone, Hz.
        from_hz: f64,
        /// Highest tone, Hz.
        to_hz: f64,
        /// Frequency of the largest response, Hz.
        peak_hz: f64,
    },
    /// The iteration does not converge, or the data do not determine the parameters.
    #[error("the plate's response fits no single resonance")]
    NoFit,
}
