//! Sections of a protocol file on trials, times and repetitions.

use serde::{Deserialize, Serialize};

/// Order of the conditions in a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// As listed, repeated.
    Fixed,
    /// Blocks of all conditions, each shuffled by seed and participant.
    Randomised,
    /// Rows of a Williams design, by the participant's number.
    Counterbalanced,
}

/// Number and order of the trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Trials {
    /// Number of practice trials, which precede the others.
    pub practice: u32,
    /// Number of trials of each condition.
    pub per_condition: u32,
    /// Order of the conditions.
    pub order: Order,
    /// Seed of the order, unless the operator gives another.
    pub seed: u64,
}

/// Durations of the steps of a trial, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// Shortest time from drive on to the start of the baseline.
    pub settle_s: f64,
    /// Length of the baseline, without finger.
    pub baseline_s: f64,
    /// Length of the countdown before the slider moves.
    pub countdown_s: f64,
    /// Time for which the mean force is shown.
    pub feedback_s: f64,
    /// Time within which the operator may overrule a verdict.
    pub verdict_s: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            settle_s: 0.2,
            baseline_s: 0.8,
            countdown_s: 3.0,
            feedback_s: 3.0,
            verdict_s: 2.0,
        }
    }
}

/// Breaks between trials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// Number of trials between breaks, practice not counted; 0 for no breaks.
    pub every_trials: u32,
    /// Time after which the participant's button ends a break, s; the operator ends it at any time.
    pub min_s: f64,
}

impl Rest {
    /// Returns whether a break follows after `trials` settled trials, if any trial is left; the first `practice` do not count.
    #[must_use]
    pub fn is_due_after(&self, trials: u32, practice: u32) -> bool {
        let main_trials = trials.saturating_sub(practice);
        self.every_trials > 0 && main_trials > 0 && main_trials.is_multiple_of(self.every_trials)
    }
}

/// Limits on repetitions after a verdict. Interruptions (pause, safety, timeouts) do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct RedoLimits {
    /// Largest number of repetitions of one trial.
    pub max_per_trial: u32,
    /// Largest number of repetitions in the session.
    pub max_total: u32,
}

impl Default for RedoLimits {
    fn default() -> Self {
        Self {
            max_per_trial: 3,
            max_total: 10,
        }
    }
}

/// Limits of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Selection {
    /// Length about the plate's centre that is kept, m.
    pub central_m: f64,
    /// Allowed deviation from the slider's speed, as a fraction of it.
    pub speed_tolerance: f64,
    /// Length of an instance, s.
    pub instance_s: f64,
    /// Smallest number of instances in a trial.
    pub min_instances: u32,
}

/// Change of the carrier after a drift of the plate's resonance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ResonanceDrift {
    /// Drift beyond which a new carrier is proposed between trials, Hz.
    pub limit_hz: f64,
    /// Whether the operator or the protocol decides on a new carrier.
    pub new_carrier: NewCarrier,
}

impl Default for ResonanceDrift {
    fn default() -> Self {
        Self {
            limit_hz: 5.0,
            new_carrier: NewCarrier::Ask,
        }
    }
}

/// Decision on a new carrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum NewCarrier {
    /// The operator decides.
    Ask,
    /// The protocol decides: the new carrier is used without asking.
    Auto,
}

/// Times after which the session stops waiting, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Timeouts {
    /// Time for the finger to leave the plate.
    pub lift_finger_s: f64,
    /// Time for the finger to be placed and the ready button pressed.
    pub place_finger_s: f64,
    /// Time for the analysis of a finished trial.
    pub analysis_s: f64,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self {
            lift_finger_s: 30.0,
            place_finger_s: 60.0,
            analysis_s: 10.0,
        }
    }
}
