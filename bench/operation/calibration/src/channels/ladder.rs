//! The level ladder: each input is read at rising levels, through its linear range to the level at which its peaks are cut off.

use calibration_rig::operator::PointRead;
use calibration_rig::points::signed;
use metrology::regression::{FittedLine, LineFitError, LinePoint};
use metrology::tone_clipping::Peaks;

/// Reading of one input at one level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rung {
    /// Commanded level, V peak.
    pub drive_v: f64,
    /// Amplitude at the tone, sample units.
    pub amplitude: f64,
    /// Peaks of the samples.
    pub peaks: Peaks,
}

/// Ratio of successive levels.
pub const STEP: f64 = 1.17;
/// Lowest level, as a share of the highest.
pub const LOWEST: f64 = 0.05;
/// Largest relative shortfall from proportionality to the first level; a larger one counts as clipping, even if the peaks are
/// not cut off.
const SHORT: f64 = 0.01;
/// Least standard deviation of an amplitude, sample units: far below a step of 32 bits, and large enough for weights to be finite.
const LEAST_NOISE: f64 = 1e-12;
/// Largest level of an input, relative to its clipping level.
const LEVEL_LIMIT: f64 = 1.5;
/// Largest level of the drive's input, relative to its clipping level; lower, because the safety watch reads it.
const DRIVE_LEVEL_LIMIT: f64 = 1.1;

/// Returns the levels up to `highest_v`, V peak.
#[must_use]
pub fn levels_v(highest_v: f64) -> Vec<f64> {
    let count = (-LOWEST.ln() / STEP.ln()).ceil() as i32;
    (0..=count)
        .rev()
        .map(|step| highest_v * STEP.powi(-step))
        .collect()
}

/// Linearity and clipping of one input on the ladder.
#[derive(Debug, Clone, PartialEq)]
pub struct Straightness {
    /// Largest residual about the line, as a share of the largest level.
    pub nonlinearity: f64,
    /// |sample| at which peaks are cut off, and its standard deviation; `None` without clipping.
    pub clips_at: Option<(f64, f64)>,
    /// Largest |sample| that was not cut off.
    pub clean_up_to: f64,
    /// Commanded level, V peak, and residual about the line, as a share of the largest level, for each level without clipping.
    pub departures: Vec<(f64, f64)>,
}

/// Returns the index of the first rung at which the peaks are cut off.
fn first_cut(rungs: &[Rung]) -> Option<usize> {
    let slope = rungs
        .first()
        .map_or(0.0, |rung| rung.amplitude / rung.drive_v);
    rungs.iter().position(|rung| {
        rung.peaks.cut_off() || rung.amplitude < (1.0 - SHORT) * slope * rung.drive_v
    })
}

/// Fits the ladder of one input; `noise` is the standard deviation of an amplitude.
///
/// # Errors
/// If fewer than three levels are free of clipping.
pub fn straightness(rungs: &[Rung], noise: f64) -> Result<Straightness, LineFitError> {
    let cut = first_cut(rungs);
    let clean = &rungs[..cut.unwrap_or(rungs.len())];
    let points: Vec<LinePoint> = clean
        .iter()
        .map(|rung| LinePoint {
            x: rung.drive_v,
            y: rung.amplitude,
            sigma: noise.max(LEAST_NOISE),
        })
        .collect();
    let line = FittedLine::fit(&points)?;
    let largest = points
        .iter()
        .map(|point| point.y)
        .fold(f64::MIN_POSITIVE, f64::max);
    // The last level is at the limit for the largest share of the time.
    let clips_at = cut
        .and_then(|_| rungs.last())
        .map(|rung| (rung.peaks.level, rung.peaks.scatter));
    Ok(Straightness {
        nonlinearity: line.nonlinearity,
        clips_at,
        clean_up_to: clean
            .iter()
            .map(|rung| rung.peaks.level)
            .fold(0.0, f64::max),
        departures: points
            .iter()
            .zip(&line.residuals)
            .map(|(point, residual)| (point.x, residual / largest))
            .collect(),
    })
}

/// Returns the readings of one input in words, with their residuals about the line, of the largest level, once there is a line.
#[must_use]
pub fn points(rungs: &[Rung]) -> Vec<PointRead> {
    // An error that all levels share leaves the line and its residuals as they are.
    let line = straightness(rungs, 1.0);
    let residuals = line.map_or_else(|_| Vec::new(), |straight| straight.departures);
    let sizes = residuals.iter().map(|(_, residual)| residual.abs());
    let largest = sizes.fold(0.0, f64::max);
    let point = |(number, rung): (usize, &Rung)| {
        // Levels above the first clipped one have no residual.
        let residual = residuals.get(number).map(|(_, residual)| *residual);
        PointRead {
            place: format!("{:.2} V", rung.drive_v),
            value: format!("{:.4} of full scale", rung.amplitude),
            residual: residual.map(|residual| signed(100.0 * residual, 3) + " % of the largest"),
            worst: residual.is_some_and(|residual| largest > 0.0 && residual.abs() >= largest),
        }
    };
    rungs.iter().enumerate().map(point).collect()
}

/// Returns the highest level without clipping of the input's peaks, V peak.
#[must_use]
pub fn highest_clean_v(rungs: &[Rung]) -> f64 {
    let clean = &rungs[..first_cut(rungs).unwrap_or(rungs.len())];
    clean.last().map_or(0.0, |rung| rung.drive_v)
}

/// Returns whether `next_v` would drive an input too far beyond its clipping level; `inputs` holds the ladders so far, and
/// `drive` is the index of the drive's input.
#[must_use]
pub fn too_far(inputs: &[Vec<Rung>], drive: usize, next_v: f64) -> bool {
    inputs.iter().enumerate().any(|(input, rungs)| {
        let (Some(first), Some(cut)) = (rungs.first(), first_cut(rungs)) else {
            return false;
        };
        let expected = first.amplitude / first.drive_v * next_v;
        let most = if input == drive {
            DRIVE_LEVEL_LIMIT
        } else {
            LEVEL_LIMIT
        };
        expected > most * rungs[cut].peaks.level
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns an input of `gain` per volt, cut off at `limit`, at each level of a ladder to 50 V.
    fn ladder(gain: f64, limit: f64) -> Vec<Rung> {
        levels_v(50.0)
            .into_iter()
            .map(|drive_v| {
                let amplitude = gain * drive_v;
                Rung {
                    drive_v,
                    amplitude: if amplitude > limit {
                        0.98 * amplitude
                    } else {
                        amplitude
                    },
                    peaks: Peaks {
                        level: amplitude.min(limit),
                        scatter: 1e-6,
                        flatness: if amplitude > 1.01 * limit { 5.0 } else { 1.0 },
                    },
                }
            })
            .collect()
    }

    #[test]
    fn levels_rise_to_the_highest() {
        let levels = levels_v(50.0);
        assert_eq!(levels.last(), Some(&50.0));
        assert!(levels[0] <= 2.5 && levels[0] > 2.0, "{}", levels[0]);
        assert!(levels.windows(2).all(|pair| pair[1] > pair[0]));
    }

    #[test]
    fn the_limit_is_found_and_the_range_below_is_straight() {
        let limited = straightness(&ladder(0.02, 0.5), 1e-7).unwrap();
        assert_eq!(limited.clips_at, Some((0.5, 1e-6)));
        assert!(limited.nonlinearity < 1e-12);
        let levels: Vec<f64> = limited
            .departures
            .iter()
            .map(|departure| departure.0)
            .collect();
        assert!(levels_v(50.0).starts_with(&levels) && levels.len() >= 3);
        assert!(limited.clean_up_to > 0.42 && limited.clean_up_to <= 0.5);
        let linear = straightness(&ladder(0.01, 1.0), 1e-7).unwrap();
        assert_eq!((linear.clips_at, linear.clean_up_to), (None, 0.5));
    }

    #[test]
    fn a_level_that_is_off_the_line_is_the_worst_point() {
        let mut rungs = ladder(0.02, 0.5);
        rungs[4].amplitude += 0.004;
        let read = points(&rungs);
        let worst: Vec<usize> = (0..read.len()).filter(|&i| read[i].worst).collect();
        assert_eq!(worst, [4]);
        let residual = read[4].residual.as_ref().unwrap();
        assert!(residual.starts_with('+'), "{residual}");
        // The last level is clipped, and two levels are no line.
        assert_eq!(read.last().unwrap().residual, None);
        assert!(
            points(&rungs[..2])
                .iter()
                .all(|point| point.residual.is_none())
        );
    }

    #[test]
    fn no_input_is_driven_far_beyond_its_limit() {
        let stop_v = |inputs: &[Vec<Rung>]| {
            levels_v(50.0)
                .iter()
                .position(|&next_v| {
                    let ladders: Vec<Vec<Rung>> = inputs
                        .iter()
                        .map(|rungs| {
                            let lower_rungs = rungs.iter().filter(|rung| rung.drive_v < next_v);
                            lower_rungs.copied().collect()
                        })
                        .collect();
                    too_far(&ladders, 0, next_v)
                })
                .map(|i| levels_v(50.0)[i])
        };
        assert_eq!(stop_v(&[ladder(0.01, 1.0), ladder(0.015, 1.0)]), None);
        let drive_v = stop_v(&[ladder(0.02, 0.5), ladder(0.01, 1.0)]).unwrap();
        assert!(drive_v * 0.02 > 0.55 && drive_v * 0.02 < 0.65, "{drive_v}");
        let other_v = stop_v(&[ladder(0.01, 1.0), ladder(0.04, 0.5)]).unwrap();
        assert!(other_v * 0.04 > 0.75 && other_v * 0.04 < 0.88, "{other_v}");
    }

    #[test]
    fn too_few_clean_levels_are_no_line() {
        let rungs = &ladder(0.02, 0.05)[..4];
        assert!(matches!(
            straightness(rungs, 1e-7),
            Err(LineFitError::TooFew { .. })
        ));
    }
}
