//! Conversion of samples to volts and metres, and of volts to the force on the plate.

use impedance::PlateConstants;
use serde::{Deserialize, Serialize};

use super::recorded_across::RecordedAcross;
use super::recorded_profile::RecordedProfile;

/// Channels of `signals.wav` by meaning.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedChannels {
    /// Sampling rate, Hz, if it is no whole number, as the header of `signals.wav` needs; within 1 Hz of that of the header.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Channel of the read-back of the voltage across the actuators.
    pub drive: RecordedDrive,
    /// Channel of the displacement of the plate.
    pub pickup: RecordedPickup,
}

/// Channel of the drive's read-back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedDrive {
    /// Channel in `signals.wav`, from 0.
    pub index: u16,
    /// Actuator volts per sample value.
    pub volts_per_unit: f64,
    /// |sample value| at and above which the input clipped, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_units: Option<f64>,
}

/// Channel of the plate's displacement: x̃ = metres_per_unit · sample · exp(+i·phase_rad).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedPickup {
    /// Channel in `signals.wav`, from 0.
    pub index: u16,
    /// Plate displacement per sample value at the carrier, metres, peak for peak.
    pub metres_per_unit: f64,
    /// Phase of the displacement relative to the sample values, radians.
    pub phase_rad: f64,
    /// |sample value| at and above which the input clipped, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_units: Option<f64>,
}

/// Constants of the plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedPlate {
    /// Resonance frequency of the driven mode, Hz.
    pub resonance_hz: f64,
    /// Modal mass m_p, kg.
    pub modal_mass_kg: f64,
    /// Force factor γ of the actuators, N/V: f_a = γ U_a.
    pub force_factor_n_per_v: f64,
    /// Position of the plate's centre on the scale of `position.csv`, metres.
    pub centre_m: f64,
    /// Amplitude along the plate, if it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<RecordedProfile>,
    /// Amplitude across the plate, if its wavelength is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<RecordedAcross>,
}

impl RecordedPlate {
    /// Returns the constants for measuring impedances. A negative force factor is a phase of half a turn, which is not
    /// included in them.
    pub fn constants(&self) -> PlateConstants {
        PlateConstants {
            resonance_hz: self.resonance_hz,
            modal_mass_kg: self.modal_mass_kg,
            force_factor_n_per_v: self.force_factor_n_per_v.abs(),
        }
    }
}
