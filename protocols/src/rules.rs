//! Limits for the selection from explorations and for the verdicts on trials.

use serde::{Deserialize, Serialize};

/// Normal forces requested of the participant, N.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ForceBand {
    /// Smallest mean normal force of an exploration.
    pub min_n: f64,
    /// Largest mean normal force of an exploration.
    pub max_n: f64,
    /// Force at and above which the finger is on the plate; below half of it the finger is off.
    pub contact_n: f64,
}

/// Returns whether the finger is on the plate at a normal force, N: on at and above `contact_n`, off below half of it, and between
/// them as `before`; `None` if it is not known.
pub(crate) fn is_touching(
    before: Option<bool>,
    normal_n: Option<f64>,
    contact_n: f64,
) -> Option<bool> {
    match normal_n {
        Some(normal_n) if normal_n >= contact_n => Some(true),
        Some(normal_n) if normal_n < 0.5 * contact_n => Some(false),
        Some(normal_n) if normal_n.is_finite() => before,
        _ => None,
    }
}

/// Limits of clipped and lost samples in a recording; 0 by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Quality {
    /// Clipped input frames allowed in a trial.
    pub max_clipped_frames: u64,
    /// Lost input frames allowed in a trial.
    pub max_lost_frames: u64,
    /// Sum of input and output xruns allowed in a trial; xruns without lost frames do not count.
    pub max_xruns: u64,
}

/// Conditions under which a rising stretch contains an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SelectionRules {
    /// Position of the plate's centre, m.
    pub centre_m: f64,
    /// Length of the central part of the plate that is used, m.
    pub central_m: f64,
    /// The slider's speed, m/s.
    pub speed_m_per_s: f64,
    /// Allowed deviation from the slider's speed, as a fraction of it.
    pub speed_tolerance: f64,
    /// Length of an instance, s.
    pub instance_s: f64,
    /// Smallest normal force of a finger in contact, N.
    pub contact_n: f64,
}

impl SelectionRules {
    /// Returns the published rules (60 mm, 50 mm/s, 60 ms) for a plate with its centre at `centre_m`; the tolerance of
    /// ±25 % and the contact force of 0.1 N are this project's.
    pub fn published(centre_m: f64) -> Self {
        Self {
            centre_m,
            central_m: 0.060,
            speed_m_per_s: 0.050,
            speed_tolerance: 0.25,
            instance_s: 0.060,
            contact_n: 0.1,
        }
    }

    /// Whether `position_m` lies in the central part of the plate.
    pub(crate) fn is_central(&self, position_m: f64) -> bool {
        (position_m - self.centre_m).abs() <= self.central_m / 2.0
    }
}

/// Limits for the verdict on a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictRules {
    /// Band of the mean normal force, and the contact force.
    pub force: ForceBand,
    /// The slider's speed, m/s.
    pub speed_m_per_s: f64,
    /// Allowed deviation from the slider's speed, as a fraction of it.
    pub speed_tolerance: f64,
    /// Time off the plate from which an exploration is rejected, s: the length of an instance.
    pub lift_limit_s: f64,
    /// Smallest number of instances in a trial; 0 without a modulation.
    pub min_instances: u32,
    /// Limits of clipped and lost samples.
    pub quality: Quality,
}
