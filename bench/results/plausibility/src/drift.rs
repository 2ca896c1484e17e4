//! Drift of the zero of a force in the only stretch without a finger.

use statistics::StraightLine;

/// Change of the zero over all forces beyond which it is a flaw, N.
const GREATEST_DRIFT_N: f64 = 0.03;
/// Shortest stretch that shows a drift, s, number of its standard errors beyond which it is certain, and least change in it in residuals
/// about its line: a hand that rests moves back and forth.
const SHORTEST_S: f64 = 0.4;
const CERTAIN_ERRORS: f64 = 4.0;
const RIPPLE: f64 = 5.0;

/// Returns the drift of independent means, as time, s, and force, N, if it is certain and over `all_s` would change the zero by much, N/s.
#[must_use]
pub(crate) fn certain_drift(means: &[(f64, f64)], all_s: f64) -> Option<f64> {
    let line = StraightLine::fit(means)?;
    let length_s = means.last()?.0 - means.first()?.0;
    let drift = line.slope.abs();
    let is_certain =
        drift > CERTAIN_ERRORS * line.slope_std && drift * length_s > RIPPLE * line.residual;
    (length_s >= SHORTEST_S && is_certain && drift * all_s > GREATEST_DRIFT_N).then_some(line.slope)
}
