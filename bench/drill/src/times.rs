//! Times of an exercise, and how it ended.

use serde::{Deserialize, Serialize};

/// Times from the fault, s; absent if it did not come to that. Where a person brought the fault they count from the
/// moment at which the bench saw it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Times {
    /// To the bench's stop or flag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shown_s: Option<f64>,
    /// To the drive's last sample that is not zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub silent_s: Option<f64>,
    /// To the operator's acknowledgement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen_s: Option<f64>,
    /// To the released latch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rearmed_s: Option<f64>,
    /// To the end of what was right to do: driven again, repeated, or ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub done_s: Option<f64>,
}

impl Times {
    /// Returns the times in words, those of the bench in ms and those of the operator in s.
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

/// How an exercise ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Bench and operator did what is required, in time.
    Met,
    /// One of them did not; why.
    Missed(String),
}
