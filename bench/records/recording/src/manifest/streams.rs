//! Streams of a recording, and the constants that belong to each kind of them.

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::manifest_error::{
    ManifestError, require_finite, require_not_negative, require_not_zero, require_positive,
    require_range,
};
use super::transducers::{RecordedChannels, RecordedPlate};

/// Streams from which the results of a recording follow.
#[derive(Debug, Clone, PartialEq)]
pub enum Streams {
    /// Drive and pickup as sampled, in `signals.wav`.
    Signals(RecordedSignals),
    /// Complex envelopes of drive and pickup, in `envelopes.parquet`.
    Envelopes(RecordedEnvelopes),
    /// Forces and positions alone, without any impedance; with the modulation of a stimulus, if there is one.
    Forces(Option<Modulation>),
}

/// Description of `signals.wav`.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedSignals {
    /// Carrier of the drive.
    pub carrier: Carrier,
    /// Modulation of the drive.
    pub modulation: Modulation,
    /// Channels from which the impedance is computed.
    pub channels: RecordedChannels,
    /// Plate under the finger.
    pub plate: RecordedPlate,
}

/// Description of `envelopes.parquet`.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedEnvelopes {
    /// Frequency to which the envelopes refer, Hz.
    pub carrier_hz: f64,
    /// Modulation of the drive.
    pub modulation: Modulation,
    /// Plate under the finger.
    pub plate: RecordedPlate,
}

/// Carrier of a recorded drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Carrier {
    /// One frequency, Hz.
    Steady(f64),
    /// A frequency that moves within the recording, as that of a phase-locked drive, and is read from the drive.
    Follows,
}

/// Word for a carrier that moves.
const FOLLOWS: &str = "follows";

/// Modulation of the amplitude: A(t) = A_mean (1 + index · sin 2πft).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Modulation {
    /// Frequency f, Hz; 0 for no modulation.
    pub frequency_hz: f64,
    /// Modulation index, 0 to 1.
    pub index: f64,
}

/// Keys of `recording.toml` that state the streams.
pub(super) struct StreamKeys {
    pub(super) carrier: Option<Carrier>,
    pub(super) modulation_hz: Option<f64>,
    pub(super) modulation_index: Option<f64>,
    pub(super) channels: Option<RecordedChannels>,
    pub(super) plate: Option<RecordedPlate>,
}

impl Streams {
    /// Returns the streams that the keys describe: `[channels]` describes `signals.wav`; without it, a carrier or a plate
    /// describes `envelopes.parquet`.
    ///
    /// # Errors
    /// A key that the streams need is missing, or one excludes another.
    pub(super) fn from_keys(keys: StreamKeys) -> Result<Self, ManifestError> {
        let StreamKeys {
            carrier,
            modulation_hz,
            modulation_index,
            channels,
            plate,
        } = keys;
        if carrier.is_none() && channels.is_none() && plate.is_none() {
            let modulation = match (modulation_hz, modulation_index) {
                (None, None) => None,
                (frequency_hz, index) => {
                    const STIMULUS: &str = "a stimulus that is modulated";
                    Some(Modulation {
                        frequency_hz: required("modulation_hz", STIMULUS, frequency_hz)?,
                        index: required("modulation_index", STIMULUS, index)?,
                    })
                }
            };
            return Ok(Self::Forces(modulation));
        }
        let reason = match channels {
            Some(_) => "a recording with `[channels]`",
            None => "a recording with a carrier or a plate",
        };
        let carrier = required("carrier_hz", reason, carrier)?;
        let modulation = Modulation {
            frequency_hz: required("modulation_hz", reason, modulation_hz)?,
            index: required("modulation_index", reason, modulation_index)?,
        };
        let plate = required("plate", reason, plate)?;
        match (channels, carrier) {
            (Some(channels), carrier) => Ok(Self::Signals(RecordedSignals {
                carrier,
                modulation,
                channels,
                plate,
            })),
            (None, Carrier::Steady(carrier_hz)) => Ok(Self::Envelopes(RecordedEnvelopes {
                carrier_hz,
                modulation,
                plate,
            })),
            (None, Carrier::Follows) => Err(ManifestError::MovingEnvelopes),
        }
    }

    /// Returns the keys that describe the streams.
    pub(super) fn into_keys(self) -> StreamKeys {
        let (carrier, modulation, channels, plate) = match self {
            Self::Signals(signals) => (
                Some(signals.carrier),
                Some(signals.modulation),
                Some(signals.channels),
                Some(signals.plate),
            ),
            Self::Envelopes(envelopes) => (
                Some(Carrier::Steady(envelopes.carrier_hz)),
                Some(envelopes.modulation),
                None,
                Some(envelopes.plate),
            ),
            Self::Forces(modulation) => (None, modulation, None, None),
        };
        StreamKeys {
            carrier,
            modulation_hz: modulation.map(|modulation| modulation.frequency_hz),
            modulation_index: modulation.map(|modulation| modulation.index),
            channels,
            plate,
        }
    }

    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        match self {
            Self::Signals(signals) => {
                if let Carrier::Steady(carrier_hz) = signals.carrier {
                    require_positive("carrier_hz", carrier_hz)?;
                }
                signals.modulation.validate()?;
                validate_channels(&signals.channels)?;
                validate_plate(&signals.plate)
            }
            Self::Envelopes(envelopes) => {
                require_positive("carrier_hz", envelopes.carrier_hz)?;
                envelopes.modulation.validate()?;
                validate_plate(&envelopes.plate)
            }
            Self::Forces(modulation) => modulation.map_or(Ok(()), Modulation::validate),
        }
    }
}

impl Modulation {
    fn validate(self) -> Result<(), ManifestError> {
        require_not_negative("modulation_hz", self.frequency_hz)?;
        require_range("modulation_index", self.index, 0.0..=1.0)
    }
}

fn required<T>(
    key: &'static str,
    reason: &'static str,
    value: Option<T>,
) -> Result<T, ManifestError> {
    value.ok_or(ManifestError::MissingKey { key, reason })
}

fn validate_channels(channels: &RecordedChannels) -> Result<(), ManifestError> {
    require_not_zero(
        "channels.drive.volts_per_unit",
        channels.drive.volts_per_unit,
    )?;
    require_not_zero(
        "channels.pickup.metres_per_unit",
        channels.pickup.metres_per_unit,
    )?;
    require_finite("channels.pickup.phase_rad", channels.pickup.phase_rad)?;
    if let Some(rate_hz) = channels.rate_hz {
        require_positive("channels.rate_hz", rate_hz)?;
    }
    if channels.drive.index == channels.pickup.index {
        return Err(ManifestError::SameChannel {
            index: channels.drive.index,
        });
    }
    Ok(())
}

fn validate_plate(plate: &RecordedPlate) -> Result<(), ManifestError> {
    require_positive("plate.resonance_hz", plate.resonance_hz)?;
    require_positive("plate.modal_mass_kg", plate.modal_mass_kg)?;
    require_not_zero("plate.force_factor_n_per_v", plate.force_factor_n_per_v)?;
    require_finite("plate.centre_m", plate.centre_m)?;
    if let Some(profile) = &plate.profile {
        profile.validate()?;
    }
    if let Some(across) = &plate.across {
        across.validate()?;
    }
    Ok(())
}

impl Serialize for Carrier {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Steady(carrier_hz) => serializer.serialize_f64(*carrier_hz),
            Self::Follows => serializer.serialize_str(FOLLOWS),
        }
    }
}

impl<'de> Deserialize<'de> for Carrier {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CarrierVisitor)
    }
}

struct CarrierVisitor;

impl Visitor<'_> for CarrierVisitor {
    type Value = Carrier;

    fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        formatter.write_str("a frequency in Hz, or \"follows\" for one that moves")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Carrier, E> {
        Ok(Carrier::Steady(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Carrier, E> {
        Ok(Carrier::Steady(value as f64))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Carrier, E> {
        match value {
            FOLLOWS => Ok(Carrier::Follows),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(value), &self)),
        }
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Carrier {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Carrier".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "anyOf": [{ "type": "number" }, { "type": "string", "const": FOLLOWS }]
        })
    }
}
