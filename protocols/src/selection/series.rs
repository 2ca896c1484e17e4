//! Frames of an exploration.

use crate::trial::Direction;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Whether amplitude and impedance of a demodulated frame, and the force measured with it, are usable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Validity {
    /// All are usable.
    Valid,
    /// Samples within the demodulation filter were lost.
    LostSamples,
    /// Samples within the demodulation filter were at the converter's limit.
    Clipped,
    /// The output lost frames, which interrupted the drive.
    DriveGap,
    /// An axis of the force sensor was saturated.
    ForceSaturated,
    /// The amplitude is too small against its noise for an impedance, as at nulls of the envelope.
    BelowNoise,
}

/// The demodulated frames of one exploration, all slices of one length.
#[derive(Clone, Copy, Debug)]
pub struct ExplorationSeries<'a> {
    /// Direction in which the finger slides.
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
    /// Whether the frame is usable.
    pub validity: &'a [Validity],
}

/// Why frames cannot be used for a selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SelectionError {
    /// A slice that is not as long as `time_s`.
    #[error("`{name}` has {len} frames, `time_s` has {expected}")]
    Length {
        /// The slice.
        name: &'static str,
        /// Its length.
        len: usize,
        /// Length of `time_s`.
        expected: usize,
    },
    /// A time that is not finite or does not follow the previous one by the frames' spacing. Lost samples count as frames, too.
    #[error("`time_s` is not evenly spaced at frame {frame}")]
    Time {
        /// Index of the later frame.
        frame: usize,
    },
}

/// Requires slices of one length and evenly spaced times.
pub(super) fn check_frames(series: &ExplorationSeries<'_>) -> Result<(), SelectionError> {
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
    // Half a frame leaves room for times written with few digits. NaN fails the comparison.
    let is_even = |pair: &[f64]| (pair[1] - pair[0] - spacing_s).abs() < 0.5 * spacing_s;
    match time_s.windows(2).position(|pair| !is_even(pair)) {
        Some(i) => Err(SelectionError::Time { frame: i + 1 }),
        None => Ok(()),
    }
}

/// Returns the frames from `start_s` to `end_s`, both included.
pub(super) fn frames_between(time_s: &[f64], start_s: f64, end_s: f64) -> Range<usize> {
    time_s.partition_point(|&t| t < start_s)..time_s.partition_point(|&t| t <= end_s)
}
