//! Findings of an exploration: its drive, its friction and its selected stretches.

use protocols::{Direction, SelectionRules, Stretch};
use recording::Manifest;
use recording::manifest::Body;
use serde::{Deserialize, Serialize};

use crate::exploration_series::ExplorationSeries;
use crate::measurements::FrameSeries;
use crate::stroke::Stroke;

/// Findings of an exploration. Its time series is an [`ExplorationSeries`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ExplorationFindings {
    /// Direction of the slide.
    pub direction: Direction,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// Drive voltage across the actuators at the peaks of the modulation, V; NaN without frames.
    pub drive_peak_v: f64,
    /// Number of samples of its series.
    pub samples: usize,
    /// Friction.
    pub stroke: Stroke,
    /// Stretches of rising amplitude, each with its instance or the reason for its rejection.
    pub stretches: Vec<Stretch>,
}

impl ExplorationFindings {
    /// Makes the findings of an exploration without its drive and without stretches; `least_n` is the force from which on a finger
    /// presses, N.
    #[must_use]
    pub fn new(
        series: &ExplorationSeries,
        direction: Direction,
        (start_s, end_s): (f64, f64),
        least_n: f64,
    ) -> Self {
        Self {
            direction,
            start_s,
            end_s,
            drive_peak_v: f64::NAN,
            samples: series.time_s.len(),
            stroke: Stroke::new(series, direction, (start_s, end_s), least_n),
            stretches: Vec::new(),
        }
    }
}

/// Returns the normal force from which on the body of a recording presses, N: half of that of a finger in contact; any of another body.
pub(crate) fn pressing_n(manifest: &Manifest, rules: &SelectionRules) -> f64 {
    match manifest.contact.body {
        Body::Finger => 0.5 * rules.contact_n,
        Body::Other => 0.0,
    }
}

/// Share of the frames with a smaller drive than its peak: the modulation is within 0.2 % of its peak for the rest, and a single
/// disturbed frame has no effect.
const BELOW_PEAK: f64 = 0.98;

/// Returns the drive voltage at the peaks of the modulation, V; NaN without frames.
pub(crate) fn drive_peak_v(series: &FrameSeries) -> f64 {
    let drive_v = series.frames.iter().map(|frame| frame.drive_v.norm());
    let mut drive_v: Vec<f64> = drive_v.filter(|volts| volts.is_finite()).collect();
    drive_v.sort_by(f64::total_cmp);
    statistics::quantile(&drive_v, BELOW_PEAK).unwrap_or(f64::NAN)
}
