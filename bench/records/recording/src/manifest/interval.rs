//! Intervals of a recording with a known meaning.

use protocols::Direction;
use serde::{Deserialize, Serialize};

use super::manifest_error::{ManifestError, require_finite, require_not_negative};

/// Meaning of an interval of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedIntervalKind {
    /// No finger is on the plate; Z_p is measured here.
    Unloaded,
    /// The finger slides.
    Exploration(Direction),
}

/// Interval of a recording, seconds from sample 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "RawInterval", into = "RawInterval")]
pub struct RecordedInterval {
    /// Meaning of the interval.
    pub kind: RecordedIntervalKind,
    /// Start, seconds from sample 0.
    pub start_s: f64,
    /// End, seconds from sample 0.
    pub end_s: f64,
}

impl RecordedInterval {
    /// Converts an interval on the audio clock to the time of a recording with sample 0 at `recording_start_s`, s, on
    /// that clock.
    #[must_use]
    pub fn relative_to(interval: protocols::Interval, recording_start_s: f64) -> Self {
        Self {
            kind: match interval.kind {
                protocols::IntervalKind::Unloaded => RecordedIntervalKind::Unloaded,
                protocols::IntervalKind::Exploration { direction } => {
                    RecordedIntervalKind::Exploration(direction)
                }
            },
            start_s: interval.start_s - recording_start_s,
            end_s: interval.end_s - recording_start_s,
        }
    }

    pub(crate) fn validate(&self, index: usize) -> Result<(), ManifestError> {
        require_not_negative(&format!("intervals.{index}.start_s"), self.start_s)?;
        require_finite(&format!("intervals.{index}.end_s"), self.end_s)?;
        if self.end_s <= self.start_s {
            return Err(ManifestError::IntervalOrder {
                index,
                start_s: self.start_s,
                end_s: self.end_s,
            });
        }
        Ok(())
    }
}

/// Interval of the recording with a known meaning.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend(
    "if" = { "properties": { "kind": { "const": "exploration" } } },
    "then" = { "required": ["direction"] },
    "else" = { "properties": { "direction": false } }
)))]
#[serde(deny_unknown_fields)]
struct RawInterval {
    /// Meaning of the interval.
    kind: RawIntervalKind,
    /// Direction of an exploration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    direction: Option<Direction>,
    /// Start, s from sample 0.
    start_s: f64,
    /// End, s from sample 0.
    end_s: f64,
}

/// Meaning of an interval.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "IntervalKind"))]
#[serde(rename_all = "snake_case")]
enum RawIntervalKind {
    /// No finger is on the plate.
    Unloaded,
    /// The finger slides.
    Exploration,
}

impl TryFrom<RawInterval> for RecordedInterval {
    type Error = &'static str;

    fn try_from(raw: RawInterval) -> Result<Self, Self::Error> {
        let kind = match (raw.kind, raw.direction) {
            (RawIntervalKind::Unloaded, None) => RecordedIntervalKind::Unloaded,
            (RawIntervalKind::Exploration, Some(direction)) => {
                RecordedIntervalKind::Exploration(direction)
            }
            (RawIntervalKind::Unloaded, Some(_)) => {
                return Err("an interval of kind `unloaded` has no `direction`");
            }
            (RawIntervalKind::Exploration, None) => {
                return Err(
                    "an interval of kind `exploration` needs a `direction`: `left_to_right` or `right_to_left`",
                );
            }
        };
        Ok(Self {
            kind,
            start_s: raw.start_s,
            end_s: raw.end_s,
        })
    }
}

impl From<RecordedInterval> for RawInterval {
    fn from(interval: RecordedInterval) -> Self {
        let (kind, direction) = match interval.kind {
            RecordedIntervalKind::Unloaded => (RawIntervalKind::Unloaded, None),
            RecordedIntervalKind::Exploration(direction) => {
                (RawIntervalKind::Exploration, Some(direction))
            }
        };
        Self {
            kind,
            direction,
            start_s: interval.start_s,
            end_s: interval.end_s,
        }
    }
}
