//! Facts about the bench for the operator: calibrations, lines, sources, limits.

/// Calibrations, lines and limits of the bench.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BenchFacts {
    /// Description of the plate.
    pub plate: String,
    /// The calibrations, measured or missing.
    pub calibrations: Vec<CalibrationFact>,
    /// Lines and sources.
    pub parts: Vec<PartFact>,
    /// Limits that are looser than their defaults.
    pub loosened: Vec<String>,
    /// Safety-relevant properties that have not been measured.
    pub unverified: Vec<String>,
}

/// One calibration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CalibrationFact {
    /// Name of the calibration.
    pub name: String,
    /// Date of the measurement; `None` if the calibration was never made.
    pub date: Option<String>,
    /// Age, days; `None` if it is not known, as for a calibration dated by a simulated clock.
    pub age_days: Option<f64>,
    /// Name of the operator who measured.
    pub operator: String,
    /// The result.
    pub value: String,
}

/// One line or source of the bench.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PartFact {
    /// Name of the part.
    pub name: String,
    /// Description or state.
    pub words: String,
    /// Whether its state is normal.
    pub well: bool,
    /// Line or device with a state that is shown after the text.
    pub line: Option<BenchLine>,
}

/// A line or device with a state that the operator may want to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BenchLine {
    /// The e-stop's loop.
    Estop,
    /// The heartbeat into the amplifier's one-shot.
    Heartbeat,
    /// The participant's button.
    Button,
    /// The encoder.
    Encoder,
    /// The force sensor.
    ForceSensor,
    /// The sound card.
    SoundCard,
}
