//! Selection of the rising stretches that contain an instance.

use super::rising::{self, Rising};
use super::series::{ExplorationSeries, SelectionError, Validity, check_frames, frames_between};
use crate::rules::SelectionRules;
use crate::stretch::{Instance, Rejection, Stretch, StretchOutcome};
use std::ops::Range;

/// Fraction of the slider's speed below which the finger counts as not sliding rather than as slow.
const SLIDING_PART: f64 = 0.2;
/// Length of the running mean of the speed, s.
const SPEED_MEAN_S: f64 = 0.020;
/// Largest fraction of an instance's frames that may be below the noise; the estimator masks them.
const BELOW_NOISE_PART: f64 = 0.1;

/// Finds the rising stretches of an exploration and accepts or rejects each.
///
/// # Errors
/// [`SelectionError`] if the slices differ in length or the times are not evenly spaced.
///
/// ```
/// use protocols::selection::select;
/// use protocols::{Direction, ExplorationSeries, SelectionRules, Validity};
/// use std::f64::consts::TAU;
///
/// // 1.7 s at 50 mm/s from 10 mm on, the amplitude modulated at 6 Hz.
/// let time_s: Vec<f64> = (0..3400).map(|i| f64::from(i) / 2000.0).collect();
/// let amplitude_m: Vec<f64> = time_s.iter().map(|t| 2e-6 * (1.0 + 0.95 * (TAU * 6.0 * t).sin())).collect();
/// let position_m: Vec<f64> = time_s.iter().map(|t| 0.010 + 0.050 * t).collect();
/// let series = ExplorationSeries {
///     direction: Direction::LeftToRight,
///     time_s: &time_s,
///     amplitude_m: &amplitude_m,
///     position_m: &position_m,
///     velocity_m_per_s: &[0.050; 3400],
///     normal_n: &[0.65; 3400],
///     validity: &[Validity::Valid; 3400],
/// };
/// let stretches = select(&series, &SelectionRules::published(0.0525))?;
/// let instances: Vec<_> = stretches.iter().filter_map(|stretch| stretch.instance()).collect();
/// assert_eq!(instances.len(), 7);
/// assert!(instances.iter().all(|instance| (instance.end_s - instance.start_s - 0.060).abs() < 1e-9));
/// # Ok::<(), protocols::selection::SelectionError>(())
/// ```
pub fn select(
    series: &ExplorationSeries<'_>,
    rules: &SelectionRules,
) -> Result<Vec<Stretch>, SelectionError> {
    check_frames(series)?;
    Ok(rising::stretches(series)
        .into_iter()
        .map(|rising| {
            let outcome = match judge(series, &rising, rules) {
                Ok(instance) => StretchOutcome::Accepted(instance),
                Err(rejection) => StretchOutcome::Rejected(rejection),
            };
            Stretch {
                start_s: rising.start_s,
                end_s: rising.end_s,
                outcome,
            }
        })
        .collect())
}

fn judge(
    series: &ExplorationSeries<'_>,
    rising: &Rising,
    rules: &SelectionRules,
) -> Result<Instance, Rejection> {
    let duration_s = rising.end_s - rising.start_s;
    let long_enough = duration_s >= rules.instance_s;
    let middle_s = 0.5 * (rising.start_s + rising.end_s);
    let instance = Instance {
        start_s: middle_s - 0.5 * rules.instance_s,
        end_s: middle_s + 0.5 * rules.instance_s,
    };
    let frames = if long_enough {
        frames_between(series.time_s, instance.start_s, instance.end_s)
    } else {
        frames_between(series.time_s, rising.start_s, rising.end_s)
    };
    central(series, &frames, rules)?;
    if rising.cut_off {
        return Err(Rejection::CutOff);
    }
    if !long_enough {
        return Err(Rejection::TooShort {
            duration_s,
            needed_s: rules.instance_s,
        });
    }
    check_validity(series, &frames)?;
    check_measurement(series, &frames)?;
    check_contact(series, &frames, rules)?;
    check_sliding(series, &frames, rules)?;
    Ok(instance)
}

fn central(
    series: &ExplorationSeries<'_>,
    frames: &Range<usize>,
    rules: &SelectionRules,
) -> Result<(), Rejection> {
    let is_outside = |p: &f64| p.is_finite() && !rules.is_central(*p);
    if series.position_m[frames.clone()].iter().any(is_outside) {
        return Err(Rejection::OutsideCentre {
            central_m: rules.central_m,
        });
    }
    Ok(())
}

fn check_validity(series: &ExplorationSeries<'_>, frames: &Range<usize>) -> Result<(), Rejection> {
    let count = |kind: Validity| {
        series.validity[frames.clone()]
            .iter()
            .filter(|v| **v == kind)
            .count()
    };
    let lost_frames = frames
        .clone()
        .filter(|&i| {
            series.validity[i] == Validity::LostSamples
                || (series.validity[i] == Validity::Valid && !series.amplitude_m[i].is_finite())
        })
        .count();
    if lost_frames > 0 {
        return Err(Rejection::LostSamples {
            frames: lost_frames,
        });
    }
    let clipped_frames = count(Validity::Clipped);
    if clipped_frames > 0 {
        return Err(Rejection::Clipped {
            frames: clipped_frames,
        });
    }
    let gap_frames = count(Validity::DriveGap);
    if gap_frames > 0 {
        return Err(Rejection::DriveGap { frames: gap_frames });
    }
    let saturated_frames = count(Validity::ForceSaturated);
    if saturated_frames > 0 {
        return Err(Rejection::ForceSaturated {
            frames: saturated_frames,
        });
    }
    let noise_frames = count(Validity::BelowNoise);
    if noise_frames as f64 > BELOW_NOISE_PART * frames.len() as f64 {
        return Err(Rejection::BelowNoise {
            frames: noise_frames,
        });
    }
    Ok(())
}

fn check_measurement(
    series: &ExplorationSeries<'_>,
    frames: &Range<usize>,
) -> Result<(), Rejection> {
    let missing_frames = frames
        .clone()
        .filter(|&i| {
            !(series.position_m[i].is_finite()
                && series.velocity_m_per_s[i].is_finite()
                && series.normal_n[i].is_finite())
        })
        .count();
    if missing_frames > 0 || frames.is_empty() {
        return Err(Rejection::NotMeasured {
            frames: missing_frames,
        });
    }
    Ok(())
}

fn check_contact(
    series: &ExplorationSeries<'_>,
    frames: &Range<usize>,
    rules: &SelectionRules,
) -> Result<(), Rejection> {
    let least_n = series.normal_n[frames.clone()]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    if least_n < rules.contact_n {
        return Err(Rejection::NoContact { least_n });
    }
    Ok(())
}

fn check_sliding(
    series: &ExplorationSeries<'_>,
    frames: &Range<usize>,
    rules: &SelectionRules,
) -> Result<(), Rejection> {
    let nominal = rules.speed_m_per_s;
    let (slowest, fastest) = speed_extremes(series, frames);
    if slowest < SLIDING_PART * nominal {
        return Err(Rejection::NotSliding {
            speed_m_per_s: slowest,
        });
    }
    let min_m_per_s = nominal * (1.0 - rules.speed_tolerance);
    let max_m_per_s = nominal * (1.0 + rules.speed_tolerance);
    let worst = if nominal - slowest > fastest - nominal {
        slowest
    } else {
        fastest
    };
    if !(min_m_per_s..=max_m_per_s).contains(&worst) {
        return Err(Rejection::Speed {
            speed_m_per_s: worst,
            min_m_per_s,
            max_m_per_s,
        });
    }
    Ok(())
}

/// Returns the smallest and the largest running mean of the speed along the direction, m/s.
fn speed_extremes(series: &ExplorationSeries<'_>, frames: &Range<usize>) -> (f64, f64) {
    let time_s = &series.time_s[frames.clone()];
    let velocity = &series.velocity_m_per_s[frames.clone()];
    let in_mean = frames_between(time_s, time_s[0], time_s[0] + SPEED_MEAN_S).len();
    velocity
        .windows(in_mean)
        .map(|w| series.direction.sign() * w.iter().sum::<f64>() / w.len() as f64)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(v), hi.max(v))
        })
}
