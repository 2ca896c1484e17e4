//! The protocol file as written, before validation.

use super::drive::{Carrier, Drive};
use super::exploration::Exploration;
use super::sections::{RedoLimits, ResonanceDrift, Rest, Selection, Timeouts, Timing, Trials};
use crate::rules::{ForceBand, Quality};
use participant_texts::{Language, OwnTexts};
use participants::AskedOfParticipant;
use serde::Deserialize;

/// A protocol of participants' sessions: drive, explorations, verdicts and repetitions.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RawProtocol {
    /// Short name, used in file names: 1 to 64 lower case letters, digits, `-`, `_`; not `bench`, `calibration` or `recording`.
    pub name: String,
    /// Purpose, for the reader; empty by default.
    #[serde(default)]
    pub description: String,
    /// Source publication; empty by default.
    #[serde(default)]
    pub citation: String,
    /// Language of the participant's texts: en, fr, de, nl; English by default.
    #[serde(default)]
    pub language: Language,
    /// Texts of the laboratory, in place of those of the language.
    #[serde(default)]
    pub texts: OwnTexts,
    /// Details asked about each participant; empty by default.
    #[serde(default)]
    pub participant: AskedOfParticipant,
    /// Drive of every condition, except for values that a condition overrides.
    pub drive: Drive,
    /// Conditions, 1 to 64.
    pub conditions: Vec<RawCondition>,
    /// Number and order of the trials.
    pub trials: Trials,
    /// Explorations of a trial: the slider's travel, speed and directions.
    pub exploration: Exploration,
    /// Durations of the steps of a trial.
    #[serde(default)]
    pub timing: Timing,
    /// Normal forces requested of the participant.
    pub force: ForceBand,
    /// Breaks between trials.
    pub rest: Rest,
    /// Limits on repetitions after a verdict.
    #[serde(default)]
    pub redo: RedoLimits,
    /// Limits of an instance.
    pub selection: Selection,
    /// Limits of clipped and lost samples.
    #[serde(default)]
    pub quality: Quality,
    /// Times after which the session stops waiting.
    #[serde(default)]
    pub timeouts: Timeouts,
    /// Change of the carrier after a drift of the plate's resonance.
    #[serde(default)]
    pub resonance_drift: ResonanceDrift,
}

/// A condition; its values override those of the drive.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RawCondition {
    /// Name, unique in the protocol: 1 to 64 lower case letters, digits, `-`, `_`.
    pub name: String,
    /// Carrier frequency, if different from `[drive]`.
    pub carrier: Option<Carrier>,
    /// Peak voltage of the carrier across the actuators, averaged over the modulation, V; if different from `[drive]`.
    pub mean_amplitude_v: Option<f64>,
    /// Modulation frequency, Hz; if different from `[drive]`.
    pub modulation_hz: Option<f64>,
    /// Modulation index, 0 to 1; if different from `[drive]`.
    pub modulation_index: Option<f64>,
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for super::definition::Protocol {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Protocol".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        RawProtocol::json_schema(generator)
    }
}
