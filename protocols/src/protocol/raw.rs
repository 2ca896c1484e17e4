//! The protocol file as written, before any rule is applied.

use super::{
    Carrier, Exploration, ForceBand, Quality, RedoLimits, Rest, Selection, Timeouts, Timing, Trials,
};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::fmt;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProtocol {
    pub name: String,
    pub description: String,
    pub citation: String,
    pub drive: super::Drive,
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
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCondition {
    pub name: String,
    pub carrier: Option<Carrier>,
    pub mean_amplitude_v: Option<f64>,
    pub modulation_hz: Option<f64>,
    pub modulation_index: Option<f64>,
}

const PLATE_RESONANCE: &str = "plate resonance";

impl Serialize for Carrier {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::PlateResonance => serializer.serialize_str(PLATE_RESONANCE),
            Self::Hz(hz) => serializer.serialize_f64(*hz),
        }
    }
}

impl<'de> Deserialize<'de> for Carrier {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CarrierVisitor)
    }
}

struct CarrierVisitor;

impl de::Visitor<'_> for CarrierVisitor {
    type Value = Carrier;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{PLATE_RESONANCE}\" or a frequency in Hz")
    }

    fn visit_str<E: de::Error>(self, word: &str) -> Result<Carrier, E> {
        if word == PLATE_RESONANCE {
            Ok(Carrier::PlateResonance)
        } else {
            Err(E::invalid_value(de::Unexpected::Str(word), &self))
        }
    }

    fn visit_f64<E: de::Error>(self, hz: f64) -> Result<Carrier, E> {
        Ok(Carrier::Hz(hz))
    }

    fn visit_i64<E: de::Error>(self, hz: i64) -> Result<Carrier, E> {
        Ok(Carrier::Hz(hz as f64))
    }

    fn visit_u64<E: de::Error>(self, hz: u64) -> Result<Carrier, E> {
        Ok(Carrier::Hz(hz as f64))
    }
}
