//! The slider's motion, which gives its position at any time.

use serde::{Deserialize, Serialize};

/// The slider's motion: at rest at its start, then at constant speed to its end, where it rests again.
///
/// ```
/// use participant_window::motion::Motion;
///
/// let motion = Motion { from_m: 0.01, to_m: 0.06, speed_m_per_s: 0.05, starts_s: Some(2.0) };
/// assert_eq!(motion.at_m(1.0), 0.01);
/// assert!((motion.at_m(2.5) - 0.035).abs() < 1e-12);
/// assert_eq!(motion.at_m(9.0), 0.06);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Start position along the plate, m.
    pub from_m: f64,
    /// End position, m.
    pub to_m: f64,
    /// Speed, m/s, positive in either direction.
    pub speed_m_per_s: f64,
    /// Time on the bench's clock at which the slider leaves its start, s; `None` while it is not decided.
    pub starts_s: Option<f64>,
}

impl Motion {
    /// Returns the duration of the motion, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        (self.to_m - self.from_m).abs() / self.speed_m_per_s
    }

    /// Returns the position at a time on the bench's clock, m.
    #[must_use]
    pub fn at_m(&self, audio_s: f64) -> f64 {
        let Some(starts_s) = self.starts_s else {
            return self.from_m;
        };
        let part = (audio_s - starts_s) / self.duration_s();
        // NaN, too, rests at the start.
        let part = if part > 0.0 { part.min(1.0) } else { 0.0 };
        (1.0 - part) * self.from_m + part * self.to_m
    }

    /// Returns whether the slider moves at a time on the bench's clock.
    #[must_use]
    pub fn moves(&self, audio_s: f64) -> bool {
        let moving = |starts_s: f64| (starts_s..starts_s + self.duration_s()).contains(&audio_s);
        self.starts_s.is_some_and(moving)
    }
}
