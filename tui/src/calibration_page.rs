//! Contents of a calibration's page: one instruction, the current readings, the points measured so far.
//!
//! Fields are in the SI unit of their name. A typed number has the unit of its question.

/// Contents of a calibration's page: its progress, and its question to the operator.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CalibrationPage {
    /// Name of the calibration, such as `calibrate pickup`.
    pub title: String,
    /// Number of the current step, from 1.
    pub step: u32,
    /// Number of steps; 0 hides them.
    pub steps: u32,
    /// Instruction to the operator, or the bench's current activity; after a failure, its cause.
    pub instruction: String,
    /// Reason why the question is repeated, or another remark.
    pub note: Option<String>,
    /// The question to the operator; `None` while the bench works without one.
    pub asked: Option<Question>,
    /// The reading shown in large digits.
    pub watched: MainReading,
    /// The points measured so far.
    pub points: Vec<PointLine>,
    /// The points as a chart.
    pub curve: Option<Chart>,
    /// Results so far, one line each.
    pub findings: Vec<String>,
    /// Whether the results under review do not pass.
    pub rejected: bool,
    /// Whether the calibration has failed. The instruction then gives the cause, and no question follows.
    pub failed: bool,
}

impl CalibrationPage {
    /// Whether the page needs the operator, for a question or a failure that the `previous` page did not show.
    pub(crate) fn calls(&self, previous: Option<&Self>) -> bool {
        let call = |page: &Self| {
            let words = (page.instruction.clone(), page.note.clone());
            (page.asked.clone(), page.failed, words)
        };
        (self.asked.is_some() || self.failed) && previous.map(call) != Some(call(self))
    }
}

/// Question of a calibration to the operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Question {
    /// Confirmation that the instruction was carried out.
    Done,
    /// A number.
    Number {
        /// Unit of the typed number.
        unit: String,
        /// Predicted value, in that unit.
        expected: Option<f64>,
        /// Whether Enter alone ends a list of numbers.
        optional: bool,
    },
    /// Acceptance of the points, or the choice of one to remeasure.
    Review,
}

/// The reading shown in large digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MainReading {
    /// Peak amplitude of the plate, by the pickup.
    #[default]
    Amplitude,
    /// Normal force.
    NormalForce,
    /// Lateral force.
    LateralForce,
    /// Largest sample of any input, in percent of full scale.
    Level,
    /// Peak drive voltage, read back.
    DriveVolts,
}

/// One measured point, as text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointLine {
    /// Position of the point, with its unit.
    pub at: String,
    /// The measured value, with its unit.
    pub value: String,
    /// Residual of the fit, with its unit.
    pub residual: Option<String>,
    /// Whether the residual is the largest.
    pub worst: bool,
}

/// Points over an axis, and the curve fitted to them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Title of the horizontal axis, with its unit.
    pub x: String,
    /// Title of the vertical axis, with its unit.
    pub y: String,
    /// Measured points, in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Fitted curve, as a line through these points.
    pub fit: Vec<(f64, f64)>,
}

/// Current readings during a calibration, about twenty times a second. Values that are not finite count as `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CalibrationReadings {
    /// Normal force, N.
    pub normal_n: Option<f64>,
    /// Lateral force, signed, N.
    pub lateral_n: Option<f64>,
    /// Peak drive voltage at the actuators, read back, V.
    pub drive_v: Option<f64>,
    /// Peak amplitude of the plate by the pickup, with the sensitivity of the effective calibration, m.
    pub amplitude_m: Option<f64>,
    /// Peak amplitude by the reference instrument, m.
    pub known_m: Option<f64>,
    /// Reading of the meter as displayed, V.
    pub known_v: Option<f64>,
    /// Largest sample of any input, as a fraction of full scale.
    pub level: Option<f64>,
}

impl CalibrationReadings {
    /// Returns the readings with `None` for each value that is not finite.
    pub(crate) fn finite_only(self) -> Self {
        let number = |value: Option<f64>| value.filter(|v| v.is_finite());
        Self {
            normal_n: number(self.normal_n),
            lateral_n: number(self.lateral_n),
            drive_v: number(self.drive_v),
            amplitude_m: number(self.amplitude_m),
            known_m: number(self.known_m),
            known_v: number(self.known_v),
            level: number(self.level),
        }
    }
}

/// The operator's reply to a [`Question`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reply {
    /// Done; at a review, accept the points.
    Ready,
    /// The typed number, in the question's unit.
    Number(f64),
    /// Remeasure this point, counted from 0; under an optional [`Question::Number`], remove it from the list.
    Redo(usize),
}
