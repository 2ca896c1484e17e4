//! The protocol file as written, before any rule is applied.

use super::drive::{Carrier, Drive};
use super::exploration::Exploration;
use super::sections::{RedoLimits, ResonanceDrift, Rest, Selection, Timeouts, Timing, Trials};
use crate::person::AskedOfParticipant;
use crate::rules::{ForceBand, Quality};
use serde::Deserialize;

/// A protocol file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProtocol {
    pub name: String,
    pub description: String,
    pub citation: String,
    #[serde(default)]
    pub participant: AskedOfParticipant,
    pub drive: Drive,
    pub conditions: Vec<RawCondition>,
    pub trials: Trials,
    pub exploration: Exploration,
    pub timing: Timing,
    pub force: ForceBand,
    pub rest: Rest,
    pub redo: RedoLimits,
    pub selection: Selection,
    pub quality: Quality,
    pub timeouts: Timeouts,
    #[serde(default)]
    pub resonance_drift: ResonanceDrift,
}

/// A condition, which overrides what it names of the drive.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCondition {
    pub name: String,
    pub carrier: Option<Carrier>,
    pub mean_amplitude_v: Option<f64>,
    pub modulation_hz: Option<f64>,
    pub modulation_index: Option<f64>,
}
