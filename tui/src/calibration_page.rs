//! A calibration as the operator's screen knows it: one instruction, what is read just now, what was measured so far.
//!
//! SI units, named in the fields, but for what is typed, which has the unit that it is asked in.

use serde::{Deserialize, Serialize};

/// How far a calibration has come, and what is asked of the operator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CalibrationPage {
    /// What is calibrated.
    pub title: String,
    /// Number of the step, from 1.
    pub step: u32,
    /// How many steps there are.
    pub steps: u32,
    /// The one thing that the operator should do now, or that the bench does by itself.
    pub instruction: String,
    /// Why it is asked again, or what else should be known.
    pub note: Option<String>,
    /// The answer that is waited for; `None` while the bench works by itself.
    pub asked: Option<Question>,
    /// The reading that matters now, shown large.
    pub watched: MainReading,
    /// The points measured so far.
    pub points: Vec<PointLine>,
    /// The points as a curve.
    pub curve: Option<Chart>,
    /// What has come out so far, a line each.
    pub findings: Vec<String>,
    /// It has failed: the instruction says why, and nothing more will be asked.
    pub failed: bool,
}

/// The kinds of answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Question {
    /// That it is done.
    Done,
    /// A number.
    Number {
        /// Unit in which it is typed.
        unit: String,
        /// About what it should be, in that unit.
        expected: Option<f64>,
        /// Enter alone says that there is none.
        optional: bool,
    },
    /// To keep what was measured, or a point to be measured again.
    Review,
}

/// A reading that can be shown large.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MainReading {
    /// The plate's amplitude by the pickup.
    #[default]
    Amplitude,
    /// The normal force.
    NormalForce,
    /// The lateral force.
    LateralForce,
    /// The largest signal on any input.
    Level,
}

/// One measured point, in words.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PointLine {
    /// Where it was taken, with its unit.
    pub at: String,
    /// What was read, with its unit.
    pub value: String,
    /// By how much it departs from the fit, with its unit.
    pub residual: Option<String>,
    /// It departs most.
    pub worst: bool,
}

/// Points over an axis, and what was fitted to them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// What lies along, with its unit.
    pub x: String,
    /// What lies up, with its unit.
    pub y: String,
    /// The points.
    pub points: Vec<(f64, f64)>,
    /// The fit, as a line through these.
    pub fit: Vec<(f64, f64)>,
}

/// What is read just now, some twenty times a second; values that are not finite are taken as `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CalibrationReadings {
    /// Normal force.
    pub normal_n: Option<f64>,
    /// Lateral force, signed.
    pub lateral_n: Option<f64>,
    /// Peak drive voltage at the actuators, read back.
    pub drive_v: Option<f64>,
    /// Peak amplitude of the plate by the pickup's sensitivity in force.
    pub amplitude_m: Option<f64>,
    /// Peak amplitude by the instrument that it is compared with.
    pub known_m: Option<f64>,
    /// Largest sample of any input, of full scale.
    pub level: Option<f64>,
}

impl CalibrationReadings {
    /// Without what is no number.
    pub(crate) fn finite_only(self) -> Self {
        let number = |value: Option<f64>| value.filter(|v| v.is_finite());
        Self {
            normal_n: number(self.normal_n),
            lateral_n: number(self.lateral_n),
            drive_v: number(self.drive_v),
            amplitude_m: number(self.amplitude_m),
            known_m: number(self.known_m),
            level: number(self.level),
        }
    }
}

/// What the operator answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reply {
    /// It is done; at a review: keep.
    Ready,
    /// The number, in the unit that was asked for.
    Number(f64),
    /// Measure this point again, counted from 0.
    Redo(usize),
}
