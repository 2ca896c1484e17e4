//! Evidence of a lateral force of another time.

use serde::{Deserialize, Serialize};

/// Evidence of a lateral force that comes late or early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum LateralEvidence {
    /// It acts where nothing presses.
    Press,
    /// It is none where the finger slides.
    Slide,
}

impl LateralEvidence {
    /// Returns the words of a delay of at least `late_s`.
    pub(crate) fn words(self, late_s: f64) -> String {
        let late = if late_s > 0.0 { "late" } else { "early" };
        let against = match self {
            Self::Press => "normal_n, and acts where nothing presses",
            Self::Slide => "position_m, and is none where the finger slides",
        };
        format!("{:.2} s or more {late} against {against}", late_s.abs())
    }
}
