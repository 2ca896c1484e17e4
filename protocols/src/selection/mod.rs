//! Crop and selection: which stretches of an exploration are instances.
//!
//! Huloux 2021 keeps the central 60 mm of the plate, the finger fully sliding at constant velocity, and only the
//! stretches where friction falls because the vibration grows; an instance is 60 ms long. Where the paper is silent
//! this project decides (SCIENCE.md section 8):
//!
//! - A *rising stretch* runs from a local minimum of the vibration amplitude to the next local maximum, both found in
//!   the amplitude itself, whatever the modulation's phase.
//!   Under noise of 1 % of the mean amplitude, for modulations of 1 to 50 Hz and any phase, its ends lie within 3 % of
//!   the modulation's period and 0.5 ms of the true ones (test `the_rises_found_are_those_of_the_modulation`).
//! - The *instance* is the middle 60 ms of a rising stretch, so every condition is asked of those 60 ms alone.
//! - Speed is judged on its running mean over 20 ms: one encoder step, differentiated, is no change of the finger's
//!   velocity.

mod rising;
#[cfg(test)]
mod tests;

use crate::trial::Direction;
use crate::verdict::ExplorationAnalysis;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Whether a frame of the demodulator can be used, and the force with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Validity {
    /// Yes.
    Valid,
    /// Samples under its filter were lost.
    LostSamples,
    /// Samples under its filter were at the converter's limit.
    Clipped,
    /// An axis of the force sensor was at the end of its range.
    ForceSaturated,
    /// The amplitude is too small against its noise for an impedance, as at envelope nulls.
    BelowNoise,
}

/// The demodulated frames of one exploration, all slices of one length.
#[derive(Clone, Copy, Debug)]
pub struct ExplorationSeries<'a> {
    /// Which way the finger slides.
    pub direction: Direction,
    /// Times of the frames, s, strictly increasing, evenly spaced.
    pub time_s: &'a [f64],
    /// Peak vibration amplitude, m.
    pub amplitude_m: &'a [f64],
    /// Finger position along the plate, m.
    pub position_m: &'a [f64],
    /// Finger velocity, after the 100 Hz Butterworth filter, m/s.
    pub velocity_m_per_s: &'a [f64],
    /// Normal force, N.
    pub normal_n: &'a [f64],
    /// Whether amplitude and impedance of the frame can be used.
    pub validity: &'a [Validity],
}

/// What a stretch must be to hold an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SelectionRules {
    /// Position of the plate's centre, m.
    pub centre_m: f64,
    /// Length about it that is kept, m.
    pub central_m: f64,
    /// The slider's speed, m/s.
    pub speed_m_per_s: f64,
    /// Allowed deviation from it, as a part of it.
    pub speed_tolerance: f64,
    /// Length of an instance, s.
    pub instance_s: f64,
    /// Least normal force of a finger in contact, N.
    pub contact_n: f64,
}

impl SelectionRules {
    /// The published rules (60 mm, 50 mm/s, 60 ms) for a plate whose centre lies at `centre_m`; the tolerance of
    /// ±25 % and the contact force of 0.1 N are this project's.
    pub fn published(centre_m: f64) -> Self {
        Self {
            centre_m,
            central_m: 0.060,
            speed_m_per_s: 0.050,
            speed_tolerance: 0.25,
            instance_s: 0.060,
            contact_n: 0.1,
        }
    }
}

/// An exploration's frames that cannot be selected from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SelectionError {
    /// The slices differ in length.
    #[error("`{name}` has {len} frames, `time_s` has {expected}")]
    Length {
        /// The slice at fault.
        name: &'static str,
        /// Its length.
        len: usize,
        /// Length of `time_s`.
        expected: usize,
    },
    /// A time does not come one frame after the one before it (lost samples are frames too), or is not finite.
    #[error("`time_s` is not evenly spaced at frame {frame}")]
    Time {
        /// Index of the later frame.
        frame: usize,
    },
}

/// A chosen piece of a rising stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

/// Why a rising stretch holds no instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Rejection {
    /// The finger was not on the plate's central part.
    #[error("outside the central {:.0} mm", .central_m * 1e3)]
    OutsideCentre {
        /// Length of the central part, m.
        central_m: f64,
    },
    /// The exploration began or ended within the stretch.
    #[error("cut off by the start or end of the exploration")]
    CutOff,
    /// The amplitude rose for less than an instance.
    #[error("too short: {:.1} ms of {:.1} ms needed", .duration_s * 1e3, .needed_s * 1e3)]
    TooShort {
        /// Length of the stretch, s.
        duration_s: f64,
        /// Length of an instance, s.
        needed_s: f64,
    },
    /// Samples were lost.
    #[error("lost samples in {frames} frames")]
    LostSamples {
        /// Frames concerned.
        frames: usize,
    },
    /// Samples were clipped.
    #[error("clipped samples in {frames} frames")]
    Clipped {
        /// Frames concerned.
        frames: usize,
    },
    /// An axis of the force sensor was at the end of its range.
    #[error("force sensor saturated in {frames} frames")]
    ForceSaturated {
        /// Frames concerned.
        frames: usize,
    },
    /// The amplitude drowned in noise.
    #[error("amplitude below its noise in {frames} frames")]
    BelowNoise {
        /// Frames concerned.
        frames: usize,
    },
    /// Force or position missing.
    #[error("force or position missing in {frames} frames")]
    NotMeasured {
        /// Frames concerned.
        frames: usize,
    },
    /// The finger was off the plate.
    #[error("no contact: normal force down to {least_n:.2} N")]
    NoContact {
        /// Least normal force, N.
        least_n: f64,
    },
    /// The finger stood still or went backwards.
    #[error("finger not sliding: {:.0} mm/s", .speed_m_per_s * 1e3)]
    NotSliding {
        /// Least speed along the direction, m/s.
        speed_m_per_s: f64,
    },
    /// The finger was too slow or too fast.
    #[error("speed {:.0} mm/s, outside {:.0} to {:.0} mm/s", .speed_m_per_s * 1e3, .min_m_per_s * 1e3, .max_m_per_s * 1e3)]
    Speed {
        /// The speed farthest from the slider's, m/s.
        speed_m_per_s: f64,
        /// Least allowed, m/s.
        min_m_per_s: f64,
        /// Greatest allowed, m/s.
        max_m_per_s: f64,
    },
}

impl Rejection {
    /// The kind of rejection without its numbers, for counting.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::OutsideCentre { .. } => "outside the plate's central part",
            Self::CutOff => "cut off by the start or end of the exploration",
            Self::TooShort { .. } => "too short",
            Self::LostSamples { .. } => "lost samples",
            Self::Clipped { .. } => "clipped samples",
            Self::ForceSaturated { .. } => "force sensor saturated",
            Self::BelowNoise { .. } => "amplitude below its noise",
            Self::NotMeasured { .. } => "force or position missing",
            Self::NoContact { .. } => "no contact",
            Self::NotSliding { .. } => "finger not sliding",
            Self::Speed { .. } => "speed outside the tolerance",
        }
    }
}

/// What became of a rising stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StretchOutcome {
    /// It holds an instance.
    Accepted(Instance),
    /// It does not.
    Rejected(Rejection),
}

/// A stretch of rising amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Time of the amplitude's minimum, s.
    pub start_s: f64,
    /// Time of the amplitude's maximum, s.
    pub end_s: f64,
    /// Whether it holds an instance.
    pub outcome: StretchOutcome,
}

impl Stretch {
    /// The instance, if the stretch was accepted.
    pub fn instance(&self) -> Option<Instance> {
        match self.outcome {
            StretchOutcome::Accepted(instance) => Some(instance),
            StretchOutcome::Rejected(_) => None,
        }
    }

    /// The reason, if the stretch was rejected.
    pub fn rejection(&self) -> Option<Rejection> {
        match self.outcome {
            StretchOutcome::Accepted(_) => None,
            StretchOutcome::Rejected(rejection) => Some(rejection),
        }
    }
}

/// Below this part of the slider's speed the finger counts as not sliding rather than as slow.
const SLIDING_PART: f64 = 0.2;
/// Length of the running mean that speed is judged on, s.
const SPEED_MEAN_S: f64 = 0.020;
/// An instance may hold this part of frames below the noise; the estimator masks them.
const BELOW_NOISE_PART: f64 = 0.1;

/// Finds the rising stretches of an exploration and judges each.
///
/// # Errors
/// [`SelectionError`] if the series is not one.
pub fn select(
    series: &ExplorationSeries<'_>,
    rules: &SelectionRules,
) -> Result<Vec<Stretch>, SelectionError> {
    check(series)?;
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

/// Selects from an exploration and takes the means that its verdict needs.
///
/// # Errors
/// [`SelectionError`] if the series is not one.
pub fn analyse_exploration(
    series: &ExplorationSeries<'_>,
    rules: &SelectionRules,
) -> Result<ExplorationAnalysis, SelectionError> {
    let stretches = select(series, rules)?;
    let central: Vec<usize> = (0..series.time_s.len())
        .filter(|&i| {
            is_central(series.position_m[i], rules)
                && series.normal_n[i].is_finite()
                && series.velocity_m_per_s[i].is_finite()
        })
        .collect();
    let mean = |value: &dyn Fn(usize) -> f64| {
        (!central.is_empty())
            .then(|| central.iter().map(|&i| value(i)).sum::<f64>() / central.len() as f64)
    };
    Ok(ExplorationAnalysis {
        direction: series.direction,
        mean_normal_n: mean(&|i| series.normal_n[i]),
        mean_speed_m_per_s: mean(&|i| series.velocity_m_per_s[i] * series.direction.sign()),
        stretches,
    })
}

fn is_central(position_m: f64, rules: &SelectionRules) -> bool {
    (position_m - rules.centre_m).abs() <= rules.central_m / 2.0
}

fn check(series: &ExplorationSeries<'_>) -> Result<(), SelectionError> {
    let expected = series.time_s.len();
    for (name, len) in [
        ("amplitude_m", series.amplitude_m.len()),
        ("position_m", series.position_m.len()),
        ("velocity_m_per_s", series.velocity_m_per_s.len()),
        ("normal_n", series.normal_n.len()),
        ("validity", series.validity.len()),
    ] {
        if len != expected {
            return Err(SelectionError::Length {
                name,
                len,
                expected,
            });
        }
    }
    let time_s = series.time_s;
    let spacing_s = match time_s {
        [first, .., last] => (last - first) / (expected - 1) as f64,
        _ => return Ok(()),
    };
    // Half a frame leaves room for times written with few digits. NaN is within nothing.
    let even = |pair: &[f64]| (pair[1] - pair[0] - spacing_s).abs() < 0.5 * spacing_s;
    match time_s.windows(2).position(|pair| !even(pair)) {
        Some(i) => Err(SelectionError::Time { frame: i + 1 }),
        None => Ok(()),
    }
}

fn judge(
    series: &ExplorationSeries<'_>,
    rising: &rising::Rising,
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
        between(series.time_s, instance.start_s, instance.end_s)
    } else {
        between(series.time_s, rising.start_s, rising.end_s)
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
    valid(series, &frames)?;
    measured(series, &frames)?;
    in_contact(series, &frames, rules)?;
    sliding(series, &frames, rules)?;
    Ok(instance)
}

fn between(time_s: &[f64], start_s: f64, end_s: f64) -> Range<usize> {
    time_s.partition_point(|&t| t < start_s)..time_s.partition_point(|&t| t <= end_s)
}

fn central(
    series: &ExplorationSeries<'_>,
    frames: &Range<usize>,
    rules: &SelectionRules,
) -> Result<(), Rejection> {
    let outside = |p: &f64| p.is_finite() && !is_central(*p, rules);
    if series.position_m[frames.clone()].iter().any(outside) {
        return Err(Rejection::OutsideCentre {
            central_m: rules.central_m,
        });
    }
    Ok(())
}

fn valid(series: &ExplorationSeries<'_>, frames: &Range<usize>) -> Result<(), Rejection> {
    let count = |of: Validity| {
        series.validity[frames.clone()]
            .iter()
            .filter(|v| **v == of)
            .count()
    };
    let lost = frames
        .clone()
        .filter(|&i| {
            series.validity[i] == Validity::LostSamples
                || (series.validity[i] == Validity::Valid && !series.amplitude_m[i].is_finite())
        })
        .count();
    if lost > 0 {
        return Err(Rejection::LostSamples { frames: lost });
    }
    let clipped = count(Validity::Clipped);
    if clipped > 0 {
        return Err(Rejection::Clipped { frames: clipped });
    }
    let saturated = count(Validity::ForceSaturated);
    if saturated > 0 {
        return Err(Rejection::ForceSaturated { frames: saturated });
    }
    let below = count(Validity::BelowNoise);
    if below as f64 > BELOW_NOISE_PART * frames.len() as f64 {
        return Err(Rejection::BelowNoise { frames: below });
    }
    Ok(())
}

fn measured(series: &ExplorationSeries<'_>, frames: &Range<usize>) -> Result<(), Rejection> {
    let missing = frames
        .clone()
        .filter(|&i| {
            !(series.position_m[i].is_finite()
                && series.velocity_m_per_s[i].is_finite()
                && series.normal_n[i].is_finite())
        })
        .count();
    if missing > 0 || frames.is_empty() {
        return Err(Rejection::NotMeasured { frames: missing });
    }
    Ok(())
}

fn in_contact(
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

fn sliding(
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

/// Least and greatest running mean of the speed along the direction.
fn speed_extremes(series: &ExplorationSeries<'_>, frames: &Range<usize>) -> (f64, f64) {
    let time_s = &series.time_s[frames.clone()];
    let velocity = &series.velocity_m_per_s[frames.clone()];
    let in_mean = between(time_s, time_s[0], time_s[0] + SPEED_MEAN_S).len();
    velocity
        .windows(in_mean)
        .map(|w| series.direction.sign() * w.iter().sum::<f64>() / w.len() as f64)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| {
            (lo.min(v), hi.max(v))
        })
}
