//! Times as text for screens.

/// Returns a time in whole minutes, or seconds if it is short, rounded up.
///
/// ```
/// assert_eq!(safety::at_least(61.0), "61 s");
/// assert_eq!(safety::at_least(121.0), "3 min");
/// ```
#[must_use]
pub fn at_least(seconds: f64) -> String {
    in_units(seconds, f64::ceil)
}

/// Returns a time in whole minutes, or seconds if it is short, rounded down.
#[must_use]
pub fn at_most(seconds: f64) -> String {
    in_units(seconds, f64::floor)
}

fn in_units(seconds: f64, round: fn(f64) -> f64) -> String {
    let seconds = seconds.max(0.0);
    if seconds < 120.0 {
        format!("{:.0} s", round(seconds))
    } else {
        format!("{:.0} min", round(seconds / 60.0))
    }
}
