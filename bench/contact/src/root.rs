/// Quadratic convergence: a Newton step this small, relative to the root, leaves an error at rounding level.
const LAST_STEP: f64 = 1e-8;

/// The root of an increasing function on a bracket, by Newton's method that bisects where a step would leave the bracket.
/// `f` gives value and derivative; `f(lo) ≤ 0 ≤ f(hi)`, `lo > 0`.
#[inline]
pub(crate) fn increasing_root(
    mut lo: f64,
    mut hi: f64,
    start: f64,
    f: impl Fn(f64) -> (f64, f64),
) -> f64 {
    let mut u = start.clamp(lo, hi);
    loop {
        let (value, slope) = f(u);
        if value < 0.0 {
            lo = u;
        } else {
            hi = u;
        }
        let newton = u - value / slope;
        if (newton - u).abs() <= LAST_STEP * u {
            return newton.clamp(lo, hi);
        }
        u = if newton > lo && newton < hi {
            newton
        } else {
            0.5 * (lo + hi)
        };
        if hi - lo <= f64::EPSILON * hi {
            return u;
        }
    }
}
