//! `[participant.behaviour]`: movements and normal force of the person.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// Movement and force of the person. Probabilities are per exploration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct BehaviourTable {
    /// Normal force at which the person aims when no band is shown, N.
    pub force_aim_n: f64,
    /// Standard deviation of the person's initial misjudgement of force, relative.
    pub force_misjudgement: f64,
    /// Share of a shown force error that is corrected in the next exploration.
    pub force_learning: f64,
    /// Standard deviation of slow force wander, N.
    pub force_drift_n: f64,
    /// Correlation time of the force wander, s.
    pub force_drift_time_s: f64,
    /// RMS of force tremor (8–12 Hz), N.
    pub tremor_n: f64,
    /// RMS of position tremor, m.
    pub tremor_m: f64,
    /// Mean reaction time to signals seen or heard, s.
    pub reaction_s: f64,
    /// Standard deviation of the person's constant speed error, relative.
    pub speed_error: f64,
    /// RMS of fluctuating speed error, relative.
    pub speed_wander: f64,
    /// Bandwidth of the hand's tracking loop, Hz.
    pub tracking_hz: f64,
    /// Probability of starting late.
    pub late_start_probability: f64,
    /// Extra reaction time of a late start, s.
    pub late_start_s: f64,
    /// Probability of lifting off during an exploration.
    pub lift_off_probability: f64,
    /// Duration of a lift during an exploration, s.
    pub lift_off_s: f64,
    /// Whether the finger rests on the plate while no instruction is shown.
    pub rests_unasked: bool,
}

impl Default for BehaviourTable {
    fn default() -> Self {
        Self {
            force_aim_n: 0.65,
            force_misjudgement: 0.15,
            force_learning: 0.7,
            force_drift_n: 0.03,
            force_drift_time_s: 1.0,
            tremor_n: 0.008,
            tremor_m: 15.0e-6,
            reaction_s: 0.22,
            speed_error: 0.02,
            speed_wander: 0.02,
            tracking_hz: 2.0,
            late_start_probability: 0.03,
            late_start_s: 0.6,
            lift_off_probability: 0.02,
            lift_off_s: 0.2,
            rests_unasked: false,
        }
    }
}

impl BehaviourTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "participant.behaviour", self,
            force_aim_n: 0.05, 5.0, "N";
            force_misjudgement: 0.0, 1.0, "";
            force_learning: 0.0, 1.0, "";
            force_drift_n: 0.0, 1.0, "N";
            force_drift_time_s: 0.01, 1e3, "s";
            tremor_n: 0.0, 1.0, "N";
            tremor_m: 0.0, 1e-3, "m";
            reaction_s: 0.05, 2.0, "s";
            speed_error: 0.0, 0.5, "";
            speed_wander: 0.0, 0.5, "";
            tracking_hz: 0.2, 10.0, "Hz";
            late_start_probability: 0.0, 1.0, "";
            late_start_s: 0.0, 10.0, "s";
            lift_off_probability: 0.0, 1.0, "";
            lift_off_s: 0.0, 10.0, "s";
        }
        Ok(())
    }
}
