//! Times and outcome of an exercise.

use serde::{Deserialize, Serialize};

/// Times from the fault, s; absent if that step was not reached. If a person caused the fault, they count from its detection by
/// the bench.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// Until the bench's stop or flag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shown_s: Option<f64>,
    /// Until the last nonzero sample of the drive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub silent_s: Option<f64>,
    /// Until the operator's acknowledgement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_s: Option<f64>,
    /// Until the latch was released.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rearmed_s: Option<f64>,
    /// Until the remedy was complete: driven again, repeated, or ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub done_s: Option<f64>,
}

impl Times {
    /// Returns the times as text, those of the bench in ms and those of the operator in s.
    #[must_use]
    pub fn words(&self) -> String {
        let ms =
            |name: &str, time_s: Option<f64>| time_s.map(|s| format!("{name} {:.0} ms", 1e3 * s));
        let s = |name: &str, time_s: Option<f64>| time_s.map(|s| format!("{name} {s:.1} s"));
        let words = [
            ms("shown", self.shown_s),
            ms("silent", self.silent_s),
            s("seen", self.seen_s),
            s("re-armed", self.rearmed_s),
            s("done", self.done_s),
        ];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// Outcome of an exercise.
#[derive(Debug, Clone, PartialEq)]
pub enum ExerciseOutcome {
    /// Bench and operator did all that is required, in time.
    Met,
    /// A requirement was missed; holds the reason.
    Missed(String),
}
