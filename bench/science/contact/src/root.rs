//! The root of an increasing function on a bracket.

/// Step after which the iteration stops. Halley's iteration converges cubically: after a step this small, relative to
/// the root, the error is at rounding level.
const LAST_STEP: f64 = 1e-6;

/// Largest fraction of the slope that the curvature may take over that step. Where the slope nearly vanishes, as at the
/// greatest stiffness, steps are small far from any root.
const LAST_BEND: f64 = 1e-3;

/// Largest number of steps. Bisection alone reduces a bracket of two doubles of similar size to rounding in fewer, so only
/// overflow reaches this number.
const MOST_STEPS: usize = 200;

/// Value, slope and curvature at a point.
pub(crate) type Jet = (f64, f64, f64);

/// Returns the root of an increasing function on a bracket, by Halley's method (Newton's with the curvature) that
/// bisects where a step would leave the bracket. `f(lo) ≤ 0 ≤ f(hi)`, `0 < lo ≤ hi`.
#[inline]
pub(crate) fn increasing_root(mut lo: f64, mut hi: f64, start: f64, f: impl Fn(f64) -> Jet) -> f64 {
    let mut u = start.clamp(lo, hi);
    for _ in 0..MOST_STEPS {
        let (value, slope, curvature) = f(u);
        if value < 0.0 {
            lo = u;
        } else {
            hi = u;
        }
        // Halley's method (1694): u₊ = u − (f/f′)/(1 − f f″/(2 f′²)). The lower limit of the denominator bounds the step to
        // twice Newton's, also where f″ is large and f far from 0.
        let newton = value / slope;
        let bend = 0.5 * newton * curvature / slope;
        let step = newton / (1.0 - bend).max(0.5);
        if step.abs() <= LAST_STEP * u && bend.abs() <= LAST_BEND {
            return (u - step).clamp(lo, hi);
        }
        let next = u - step;
        u = if next > lo && next < hi {
            next
        } else {
            0.5 * (lo + hi)
        };
        if hi - lo <= f64::EPSILON * hi {
            break;
        }
    }
    u
}
