//! `[plate.drift]`: drift of the plate's resonance and damping.

use serde::{Deserialize, Serialize};
use strict_toml::OutOfRange;

use super::ranges::all_within;

/// Slow change of the plate's resonance and damping; zero by default.
///
/// Glass with glued piezos shifts by some hertz per kelvin at 35 kHz; size and sign depend on glass and glue. All sizes
/// are assumptions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct DriftTable {
    /// Rate of change of the resonance with the room's temperature at the start of the simulation, where it is largest, Hz/min.
    pub room_hz_per_min: f64,
    /// Relative rate of change of the damping with the room's temperature at the start of the simulation, 1/min.
    pub room_damping_per_min: f64,
    /// Period of the sinusoidal temperature of the room, s.
    pub room_period_s: f64,
    /// Shift of the resonance by the warmth of a resting finger after a long time, Hz.
    pub warmth_hz: f64,
    /// Relative change of the damping by the warmth of a resting finger after a long time.
    pub warmth_damping: f64,
    /// Time constant of warming under the finger, and of cooling without it, s.
    pub warmth_time_s: f64,
    /// Share of the warmth that acts more slowly, as heat spreads from under the finger.
    pub warmth_spread: f64,
    /// Ratio of the time constant of the damping to that of the resonance, as other places of the plate determine the damping.
    pub damping_time_ratio: f64,
    /// Shift of the resonance per squared amplitude, Hz/µm²: negative if glass and piezos soften.
    pub amplitude_hz_per_um2: f64,
}

impl Default for DriftTable {
    fn default() -> Self {
        Self {
            room_hz_per_min: 0.0,
            room_damping_per_min: 0.0,
            room_period_s: 1_200.0,
            warmth_hz: 0.0,
            warmth_damping: 0.0,
            warmth_time_s: 5.0,
            warmth_spread: 0.0,
            damping_time_ratio: 1.0,
            amplitude_hz_per_um2: 0.0,
        }
    }
}

impl DriftTable {
    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        all_within! { "plate.drift", self,
            room_hz_per_min: -60.0, 60.0, "Hz/min";
            room_damping_per_min: -0.05, 0.05, "1/min";
            room_period_s: 10.0, 7.2e3, "s";
            warmth_hz: -100.0, 100.0, "Hz";
            warmth_damping: -0.5, 1.0, "";
            warmth_time_s: 0.1, 1e4, "s";
            warmth_spread: 0.0, 1.0, "";
            damping_time_ratio: 0.1, 10.0, "";
            amplitude_hz_per_um2: -5.0, 5.0, "Hz/µm²";
        }
        Ok(())
    }
}
