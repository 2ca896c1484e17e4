//! Boundary between two frictions of a recording.

use serde::{Deserialize, Serialize};

/// Boundary between two frictions of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum FrictionSplit {
    /// The direction: the first where the position grows, the second where it falls.
    Direction,
    /// A time: the first before, the second after it.
    Time {
        /// Time, s.
        at_s: f64,
    },
}

impl FrictionSplit {
    /// Returns the words of both frictions.
    pub(crate) fn words(self, [first, second]: [f64; 2]) -> String {
        match self {
            Self::Direction => format!(
                "{first:.3} where the position grows and {second:.3} where it falls, as a crosstalk of {:.2} N/N makes it",
                0.5 * (first - second).abs()
            ),
            Self::Time { at_s } => format!("{first:.3} until {at_s:.2} s and {second:.3} after it"),
        }
    }
}
