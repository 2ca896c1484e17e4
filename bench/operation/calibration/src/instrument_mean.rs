//! Mean of an instrument's readings over a window.

use std::ops::Range;

use calibration_rig::capture::Capture;

/// Length of the reading at each level or place, s.
pub(crate) const WINDOW_S: f64 = 0.5;
/// Fewest readings of an instrument in a window.
pub(crate) const LEAST_LINES: usize = 5;

/// Returns the mean of the readings in `window` and its standard error, in the unit of the readings.
///
/// # Errors
/// The number of readings, if it is below [`LEAST_LINES`].
pub(crate) fn instrument_mean(
    capture: &Capture,
    window: &Range<usize>,
) -> Result<(f64, f64), usize> {
    let readings = capture.known_m.iter();
    let inside = readings.filter(|(frame, _)| window.contains(frame));
    let lines: Vec<f64> = inside.map(|&(_, reading)| reading).collect();
    let n = lines.len();
    if n < LEAST_LINES {
        return Err(n);
    }
    let mean = lines.iter().sum::<f64>() / n as f64;
    let squares: f64 = lines.iter().map(|x| (x - mean).powi(2)).sum();
    Ok((mean, (squares / (n * (n - 1)) as f64).sqrt()))
}

/// Returns the error of `n` readings of an amplitude, too few.
pub(crate) fn too_few(n: usize) -> anyhow::Error {
    anyhow::anyhow!(
        "the instrument sent {n} lines in {WINDOW_S} s, at least {LEAST_LINES} are needed: check that it sends peak amplitudes continuously"
    )
}
