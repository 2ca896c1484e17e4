//! Search range of σ_t.

/// Limits of the search for σ_t, m.
const SIGMA_FROM_M: f64 = 0.2e-6;
const SIGMA_TO_M: f64 = 20e-6;
const SIGMA_STARTS: i32 = 12;

/// Returns the starting values of σ_t, m, in geometric progression.
pub(super) fn sigma_starts() -> impl Iterator<Item = f64> {
    let ratio = (SIGMA_TO_M / SIGMA_FROM_M).powf(1.0 / f64::from(SIGMA_STARTS - 1));
    (0..SIGMA_STARTS).map(move |i| SIGMA_FROM_M * ratio.powi(i))
}
