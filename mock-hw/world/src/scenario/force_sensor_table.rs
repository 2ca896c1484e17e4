//! `[force_sensor]`: the two-axis force sensor and its serial device.

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use super::gauges_table::GaugesTable;
use super::ranges::all_within;

/// Format of the force sensor's serial line (`docs/force-protocol.md`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(rename = "ForceProtocol"))]
#[serde(rename_all = "lowercase")]
pub enum ForceLineFormat {
    /// Binary COBS frames.
    Frames,
    /// Lines of text.
    Lines,
}

/// Interface of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ForceInterface {
    /// Serial line.
    Serial,
    /// Network, as an ATI Net F/T.
    Netft,
    /// Six inputs of the sound card, from the fourth on.
    Gauges,
    /// Field box, which also has the encoder and the digital lines.
    FieldBox,
}

/// The two-axis force sensor and its device.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct ForceSensorTable {
    /// Sample rate by the device's clock, Hz.
    pub rate_hz: f64,
    /// White noise of each axis per sample, N RMS.
    pub noise_n: f64,
    /// Mechanical resonance of the mount, Hz.
    pub resonance_hz: f64,
    /// Damping ratio of the mount.
    pub damping_ratio: f64,
    /// Resonance of the mount along the plate, Hz; the same as `resonance_hz` if absent.
    pub lateral_resonance_hz: Option<f64>,
    /// Time constant of a first-order lag of the lateral axis, such as that of its amplifier's filter, s.
    pub lateral_lag_s: f64,
    /// Reading at which each axis saturates in either direction, N.
    pub range_n: f64,
    /// Reading of the normal axis per newton of normal force.
    pub normal_gain: f64,
    /// Reading of the lateral axis per newton of lateral force.
    pub lateral_gain: f64,
    /// Reading of the normal axis without load, N.
    pub normal_offset_n: f64,
    /// Reading of the lateral axis without load, N.
    pub lateral_offset_n: f64,
    /// Steady drift of the normal axis, N/min.
    pub normal_drift_n_per_min: f64,
    /// Steady drift of the lateral axis, N/min.
    pub lateral_drift_n_per_min: f64,
    /// Standard deviation of the slow random drift of each axis, N.
    pub wander_n: f64,
    /// Correlation time of the random drift, s.
    pub wander_time_s: f64,
    /// Creep: share of a load by which the reading slowly rises after loading, and falls after unloading.
    pub creep: f64,
    /// Time constant of creep, s.
    pub creep_time_s: f64,
    /// Fraction of the lateral force that the normal axis reads.
    pub lateral_to_normal: f64,
    /// Fraction of the normal force that the lateral axis reads.
    pub normal_to_lateral: f64,
    /// Excess of the rate of the device's clock over true time, ppm.
    pub clock_ppm: f64,
    /// Period of the bursts in which samples leave the device, s.
    pub burst_period_s: f64,
    /// Format of the serial line.
    pub protocol: ForceLineFormat,
    /// Interface of the sensor.
    pub interface: ForceInterface,
    /// Whether a separate field box without forces provides the encoder and the digital lines.
    pub box_beside: bool,
    /// Amplifier of the gauges, if they are on the sound card.
    pub gauges: GaugesTable,
}

impl Default for ForceSensorTable {
    fn default() -> Self {
        Self {
            rate_hz: 10_000.0,
            noise_n: 0.002,
            resonance_hz: 3_000.0,
            damping_ratio: 0.4,
            lateral_resonance_hz: None,
            lateral_lag_s: 0.0,
            range_n: 10.0,
            normal_gain: 1.0,
            lateral_gain: 1.0,
            normal_offset_n: 0.0,
            lateral_offset_n: 0.0,
            normal_drift_n_per_min: 0.0,
            lateral_drift_n_per_min: 0.0,
            wander_n: 0.0,
            wander_time_s: 20.0,
            creep: 0.0,
            creep_time_s: 30.0,
            lateral_to_normal: 0.0,
            normal_to_lateral: 0.0,
            clock_ppm: 30.0,
            burst_period_s: 0.004,
            protocol: ForceLineFormat::Frames,
            interface: ForceInterface::Serial,
            box_beside: false,
            gauges: GaugesTable::default(),
        }
    }
}

impl ForceSensorTable {
    /// Returns the readings, normal and lateral, per newton of normal and of lateral force: a matrix by rows, N/N.
    #[must_use]
    pub fn response(&self) -> [[f64; 2]; 2] {
        let (normal, lateral) = (self.normal_gain, self.lateral_gain);
        [
            [normal, normal * self.lateral_to_normal],
            [lateral * self.normal_to_lateral, lateral],
        ]
    }

    /// Requires every number of the table to be in range.
    pub(super) fn check(&self) -> Result<(), OutOfRange> {
        if let Some(resonance_hz) = self.lateral_resonance_hz {
            let key = "force_sensor.lateral_resonance_hz";
            require_range(key, resonance_hz, 100.0, 20e3, "Hz")?;
        }
        all_within! { "force_sensor", self,
            rate_hz: 500.0, 20e3, "Hz";
            noise_n: 0.0, 1.0, "N";
            resonance_hz: 100.0, 20e3, "Hz";
            damping_ratio: 0.05, 2.0, "";
            lateral_lag_s: 0.0, 0.02, "s";
            range_n: 0.1, 1e3, "N";
            normal_gain: -10.0, 10.0, "";
            lateral_gain: -10.0, 10.0, "";
            normal_offset_n: -10.0, 10.0, "N";
            lateral_offset_n: -10.0, 10.0, "N";
            normal_drift_n_per_min: -10.0, 10.0, "N/min";
            lateral_drift_n_per_min: -10.0, 10.0, "N/min";
            wander_n: 0.0, 1.0, "N";
            wander_time_s: 0.1, 1e4, "s";
            creep: 0.0, 0.2, "";
            creep_time_s: 0.1, 1e4, "s";
            lateral_to_normal: -0.5, 0.5, "";
            normal_to_lateral: -0.5, 0.5, "";
            clock_ppm: -1e4, 1e4, "ppm";
            burst_period_s: 1e-4, 0.1, "s";
        }
        self.gauges.check()
    }
}
