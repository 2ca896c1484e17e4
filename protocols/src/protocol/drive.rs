//! The drive of a condition.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::fmt;

/// Frequency of the carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// The plate's resonance, as calibrated or configured.
    PlateResonance,
    /// A fixed frequency, Hz.
    Hz(f64),
}

/// An amplitude-modulated drive: A(t) = mean · (1 + index · sin 2πft).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Carrier frequency.
    pub carrier: Carrier,
    /// Peak voltage of the carrier across the actuators, averaged over the modulation, V.
    pub mean_amplitude_v: f64,
    /// Modulation frequency f, Hz.
    pub modulation_hz: f64,
    /// Modulation index, 0 to 1.
    pub modulation_index: f64,
}

impl Drive {
    /// Returns the largest peak voltage that the modulation reaches, V.
    pub fn peak_amplitude_v(&self) -> f64 {
        self.mean_amplitude_v * (1.0 + self.modulation_index)
    }
}

/// A drive, and the name by which trials refer to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// Name, unique in the protocol.
    pub name: String,
    /// The drive of its trials.
    pub drive: Drive,
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
        write!(f, "\"{PLATE_RESONANCE}\" or a number in Hz")
    }

    fn visit_str<E: de::Error>(self, word: &str) -> Result<Carrier, E> {
        if word == PLATE_RESONANCE {
            Ok(Carrier::PlateResonance)
        } else {
            Err(E::invalid_type(de::Unexpected::Str(word), &self))
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

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Carrier {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Carrier".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [
                { "const": PLATE_RESONANCE, "description": "The plate's resonance, as calibrated or configured." },
                { "type": "number", "description": "A fixed frequency, Hz." }
            ]
        })
    }
}
