//! `[plate]`: the glass plate with its actuators.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::across_table::AcrossTable;
use super::drift_table::DriftTable;
use super::ranges::all_within;

/// The plate as its carrier mode and a second mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct PlateTable {
    /// Resonance of the carrier mode, Hz.
    pub resonance_hz: f64,
    /// Modal mass m_p of the carrier mode, kg.
    pub modal_mass_kg: f64,
    /// Damping b_p of the carrier mode, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Force factor γ of the actuators on the carrier mode, N/V.
    pub force_factor_n_per_v: f64,
    /// Share by which the carrier mode's amplitude is lower at either end than in the middle, along a parabola.
    pub end_drop: f64,
    /// Share by which the amplitude is higher at the far end and lower at the near one, along a line.
    pub end_tilt: f64,
    /// Length of the plate, m.
    pub length_m: f64,
    /// Shape of the modes across the plate; uniform across if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub across: Option<AcrossTable>,
    /// A mode that the bench's estimator does not model.
    pub second_mode: SecondModeTable,
    /// Slow change of resonance and damping.
    pub drift: DriftTable,
}

impl Default for PlateTable {
    fn default() -> Self {
        Self {
            resonance_hz: 35_000.0,
            modal_mass_kg: 0.008,
            damping_n_s_per_m: 7.01,
            force_factor_n_per_v: 0.13,
            end_drop: 0.0,
            end_tilt: 0.0,
            length_m: 0.105,
            across: None,
            second_mode: SecondModeTable::default(),
            drift: DriftTable::default(),
        }
    }
}

/// A second flexural mode; its ratios are values of its mode shape relative to the carrier mode's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SecondModeTable {
    /// Resonance, Hz.
    pub resonance_hz: f64,
    /// Modal mass, kg.
    pub modal_mass_kg: f64,
    /// Quality factor.
    pub quality: f64,
    /// Ratio at the actuators, by which the force factor γ is multiplied.
    pub actuator_ratio: f64,
    /// Ratio at the pickup.
    pub pickup_ratio: f64,
    /// Ratio under the finger at the plate's middle.
    pub contact_ratio: f64,
    /// Half waves of the mode along the plate, a cosine about its middle; 0 for a uniform mode.
    pub half_waves: f64,
}

impl Default for SecondModeTable {
    fn default() -> Self {
        Self {
            resonance_hz: 41_200.0,
            modal_mass_kg: 0.02,
            quality: 180.0,
            actuator_ratio: 0.6,
            pickup_ratio: 0.7,
            contact_ratio: 0.8,
            half_waves: 0.0,
        }
    }
}

impl PlateTable {
    /// Returns the angular resonance frequency of the carrier mode, rad/s.
    #[must_use]
    pub fn omega_rad_per_s(&self) -> f64 {
        std::f64::consts::TAU * self.resonance_hz
    }

    /// Returns the carrier mode's amplitude at a position along the plate, relative to the middle, where the pickup is.
    #[must_use]
    pub fn shape(&self, position_m: f64) -> f64 {
        let off_middle = self.off_middle(position_m);
        1.0 - self.end_drop * off_middle * off_middle + self.end_tilt * off_middle
    }

    /// Returns the amplitude of either mode at a distance `across_m` from the line that the finger follows, relative to the crest;
    /// negative beyond a nodal line.
    #[must_use]
    pub fn shape_across(&self, across_m: f64) -> f64 {
        let across = self.across.as_ref();
        across.map_or(1.0, |across| across.shape(across_m))
    }

    /// Returns the ratio of the second mode under a finger at a position along the plate.
    #[must_use]
    pub fn second_contact_ratio(&self, position_m: f64) -> f64 {
        let second = &self.second_mode;
        let turn = 0.5 * std::f64::consts::PI * second.half_waves * self.off_middle(position_m);
        second.contact_ratio * turn.cos()
    }

    /// Returns the distance of a position from the middle, relative to half the length, −1 to 1.
    fn off_middle(&self, position_m: f64) -> f64 {
        (2.0 * position_m / self.length_m - 1.0).clamp(-1.0, 1.0)
    }

    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "plate", self,
            resonance_hz: 20e3, 45e3, "Hz";
            modal_mass_kg: 1e-4, 1.0, "kg";
            damping_n_s_per_m: 0.01, 1e3, "N·s/m";
            force_factor_n_per_v: 1e-4, 10.0, "N/V";
            end_drop: -0.5, 0.5, "";
            end_tilt: -0.3, 0.3, "";
            length_m: 0.01, 1.0, "m";
        }
        if let Some(across) = &self.across {
            across.check()?;
        }
        self.second_mode.check()?;
        self.drift.check()
    }
}

impl SecondModeTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "plate.second_mode", self,
            resonance_hz: 5e3, 80e3, "Hz";
            modal_mass_kg: 1e-4, 1.0, "kg";
            quality: 1.0, 1e4, "";
            actuator_ratio: -2.0, 2.0, "";
            pickup_ratio: -2.0, 2.0, "";
            contact_ratio: -2.0, 2.0, "";
            half_waves: 0.0, 10.0, "";
        }
        Ok(())
    }
}
