//! The map as written, before its rules are checked.

use serde::Deserialize;

use crate::streams::{Convention, PickupQuantity};
use crate::value::{
    ArrayName, CarrierWord, CentreWord, ComplexArrays, FoundWord, LateralTareWord, NormalTareWord,
    NumberOr, NumberOrName, ScaleWord,
};

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawMap {
    pub format: u32,
    pub files: Option<String>,
    #[serde(default)]
    pub place: RawPlace,
    pub carrier: Option<RawCarrier>,
    pub modulation: Option<RawModulation>,
    pub drive: Option<RawDrive>,
    pub pickup: Option<RawPickup>,
    pub envelopes: Option<RawEnvelopes>,
    pub normal: Option<RawNormal>,
    pub lateral: Option<RawLateral>,
    pub position: Option<RawPosition>,
    pub velocity: Option<RawVelocity>,
    pub plate: Option<RawPlate>,
    pub contact: Option<RawContact>,
    pub baseline: Option<RawBaseline>,
    pub intervals: Option<RawIntervals>,
    pub participants: Option<RawParticipants>,
}

/// Place of all recordings, as far as their names do not state it.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPlace {
    pub participant: Option<String>,
    pub session: Option<u32>,
    pub trial: Option<u32>,
    pub attempt: Option<u32>,
    pub condition: Option<String>,
}

impl RawPlace {
    /// Returns what is stated, by the names of the pattern's groups.
    pub fn texts(&self) -> impl Iterator<Item = (&'static str, String)> {
        let number = |number: Option<u32>| number.map(|number| number.to_string());
        let texts = [
            ("participant", self.participant.clone()),
            ("session", number(self.session)),
            ("trial", number(self.trial)),
            ("attempt", number(self.attempt)),
            ("condition", self.condition.clone()),
        ];
        texts
            .into_iter()
            .filter_map(|(name, text)| Some((name, text?)))
    }
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCarrier {
    pub hz: Option<NumberOr<CarrierWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawModulation {
    pub hz: Option<NumberOr<FoundWord>>,
    pub index: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawDrive {
    pub file: Option<String>,
    pub from: Option<ArrayName>,
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
    pub volts_per_unit: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPickup {
    pub file: Option<String>,
    pub from: Option<ArrayName>,
    pub quantity: Option<PickupQuantity>,
    pub metres_per_unit: Option<NumberOr<ScaleWord>>,
    pub skew_s: Option<NumberOr<FoundWord>>,
    pub phase_rad: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawEnvelopes {
    pub file: Option<String>,
    pub drive: Option<ComplexArrays>,
    pub pickup: Option<ComplexArrays>,
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
    pub volts_per_unit: Option<f64>,
    pub metres_per_unit: Option<NumberOr<ScaleWord>>,
    pub quantity: Option<PickupQuantity>,
    pub convention: Option<Convention>,
    pub rms: Option<bool>,
    pub low_pass: Option<RawLowPass>,
    pub skew_s: Option<NumberOr<FoundWord>>,
    pub phase_rad: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLowPass {
    pub order: u32,
    pub tau_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum RawClock {
    Own,
    Same,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawNormal {
    pub file: Option<String>,
    pub from: Option<ArrayName>,
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
    pub newtons_per_unit: Option<f64>,
    pub tare: Option<NumberOr<NormalTareWord>>,
    pub clock: Option<RawClock>,
    pub offset_s: Option<NumberOr<FoundWord>>,
    pub ppm: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLateral {
    pub file: Option<String>,
    pub from: Option<ArrayName>,
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
    pub newtons_per_unit: Option<f64>,
    pub tare: Option<NumberOr<LateralTareWord>>,
    pub clock: Option<RawClock>,
    pub offset_s: Option<NumberOr<FoundWord>>,
    pub ppm: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPosition {
    pub file: Option<String>,
    pub from: Option<ArrayName>,
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
    pub metres_per_unit: Option<f64>,
    pub wrap_bits: Option<u32>,
    pub clock: Option<RawClock>,
    pub offset_s: Option<NumberOr<FoundWord>>,
    pub ppm: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawVelocity {
    pub file: Option<String>,
    pub from: Option<ArrayName>,
    pub rate_hz: Option<NumberOrName>,
    pub time: Option<ArrayName>,
    pub seconds_per_unit: Option<f64>,
    pub metres_per_unit: Option<f64>,
    pub clock: Option<RawClock>,
    pub offset_s: Option<NumberOr<FoundWord>>,
    pub ppm: Option<NumberOr<FoundWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawPlate {
    pub modal_mass_kg: Option<f64>,
    pub sweep: Option<String>,
    pub resonance_hz: Option<f64>,
    pub quality: Option<f64>,
    pub force_factor_n_per_v: Option<f64>,
    pub centre_m: Option<NumberOr<CentreWord>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawContact {
    pub body: crate::map::Body,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawBaseline {
    pub file: String,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawIntervals {
    pub unloaded: Option<String>,
    pub exploration: Option<String>,
    pub marks: Option<String>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawParticipants {
    pub table: String,
}
