//! What the operator should know of the bench itself: calibrations, lines, sources, limits.

use serde::{Deserialize, Serialize};

/// Calibrations, lines and limits of the bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BenchFacts {
    /// The plate, in words.
    pub plate: String,
    /// The calibrations, measured or missing.
    pub calibrations: Vec<CalibrationFact>,
    /// Lines and sources.
    pub parts: Vec<PartFact>,
    /// Limits that are looser than their defaults.
    pub loosened: Vec<String>,
    /// What nobody has measured although the bench's safety rests on it.
    pub unverified: Vec<String>,
}

/// One calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CalibrationFact {
    /// What was calibrated.
    pub name: String,
    /// Date of the measurement; `None` if it was never made.
    pub date: Option<String>,
    /// Age, days; `None` where it is not known, as for a calibration dated by a simulated clock.
    pub age_days: Option<f64>,
    /// Who measured.
    pub operator: String,
    /// What came out.
    pub value: String,
}

/// One line or source of the bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartFact {
    /// Name of the part.
    pub name: String,
    /// What it is, or how it is.
    pub words: String,
    /// Whether it is as it should be.
    pub well: bool,
    /// The line whose level is shown beside the words.
    #[serde(default)]
    pub line: Option<BenchLine>,
}

/// A line whose level the operator may want to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BenchLine {
    /// The e-stop's loop.
    Estop,
    /// The heartbeat into the amplifier's one-shot.
    Heartbeat,
    /// The participant's button.
    Button,
}
