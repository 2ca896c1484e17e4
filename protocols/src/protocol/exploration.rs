//! The slider that the participant follows.

use crate::trial::Direction;
use serde::{Deserialize, Serialize};

/// Explorations of a trial: the slider's travel, speed and directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Exploration {
    /// Direction of each exploration, in their order.
    pub directions: Vec<Direction>,
    /// Left end of the slider's travel along the plate, m.
    pub from_m: f64,
    /// Right end of the slider's travel along the plate, m.
    pub to_m: f64,
    /// The slider's speed, m/s.
    pub speed_m_per_s: f64,
    /// Whether sounds mark the slider's start and end.
    pub cues: bool,
    /// Whether the participant sees the position of the finger; no by default. Only the window shows it.
    #[serde(default)]
    pub show_finger: bool,
}

impl Exploration {
    /// Returns the slider of an exploration in `direction`.
    pub fn slider(&self, direction: Direction) -> Slider {
        let (from_m, to_m) = match direction {
            Direction::LeftToRight => (self.from_m, self.to_m),
            Direction::RightToLeft => (self.to_m, self.from_m),
        };
        Slider {
            from_m,
            to_m,
            speed_m_per_s: self.speed_m_per_s,
        }
    }
}

/// The slider, which the finger follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slider {
    /// Start position, m.
    pub from_m: f64,
    /// End position, m.
    pub to_m: f64,
    /// Speed, m/s, positive in either direction.
    pub speed_m_per_s: f64,
}

impl Slider {
    /// Returns the duration of the motion, s.
    pub fn duration_s(&self) -> f64 {
        (self.to_m - self.from_m).abs() / self.speed_m_per_s
    }

    /// Returns the position `elapsed_s` after the start, m. Before and after the motion the slider rests at its ends.
    pub fn position_m(&self, elapsed_s: f64) -> f64 {
        let part = (elapsed_s / self.duration_s()).clamp(0.0, 1.0);
        (1.0 - part) * self.from_m + part * self.to_m
    }

    /// Returns whether the slider is within the central `central_m` of its way, m, `elapsed_s` after the start.
    pub(crate) fn is_central(&self, elapsed_s: f64, central_m: f64) -> bool {
        let middle_m = 0.5 * (self.from_m + self.to_m);
        (self.position_m(elapsed_s) - middle_m).abs() <= 0.5 * central_m
    }
}
