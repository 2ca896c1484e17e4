//! Drive, strokes and length of a trial.

use std::ops::RangeInclusive;

use strict_toml::{OutOfRange, count_within, require_range};

use super::course::{STROKE_S, TAIL_S, UNLOADED_S};
use crate::scenario::Scenario;

/// Sampling rates of a trial, Hz.
pub const RATE_HZ: RangeInclusive<u32> = 80_000..=250_000;
/// Lengths of a trial, s.
pub const DURATION_S: RangeInclusive<f64> = 1.0..=600.0;
/// Numbers of strokes.
pub const STROKES: RangeInclusive<u32> = 1..=60;

/// Drive, strokes and length of a trial; the defaults are those of the published protocol (Huloux 2021, section IV).
#[derive(Debug, Clone, PartialEq)]
pub struct TrialPlan {
    /// Sampling rate, Hz.
    pub rate_hz: u32,
    /// Carrier of the drive, Hz; the stated resonance if `None`.
    pub carrier_hz: Option<f64>,
    /// Mean of the drive's envelope, V peak at the actuators.
    pub mean_amplitude_v: f64,
    /// Frequency of the modulation, Hz; 0 for a steady drive.
    pub modulation_hz: f64,
    /// Modulation index.
    pub modulation_index: f64,
    /// Number of strokes; with a duration, the largest number.
    pub strokes: u32,
    /// Length of the recording, s; as long as the strokes need if `None`.
    pub duration_s: Option<f64>,
    /// Whether the bench states its true constants, as after calibrations without error, or those of [`Scenario::default`].
    pub calibrated: bool,
}

impl Default for TrialPlan {
    fn default() -> Self {
        Self {
            rate_hz: 192_000,
            carrier_hz: None,
            mean_amplitude_v: 24.0,
            modulation_hz: 6.0,
            modulation_index: 0.95,
            strokes: 2,
            duration_s: None,
            calibrated: true,
        }
    }
}

impl TrialPlan {
    /// Requires every value to be one that the bench of a scenario can produce.
    ///
    /// # Errors
    /// The first value that it cannot.
    pub fn check(&self, scenario: &Scenario) -> Result<(), OutOfRange> {
        let [rate, strokes] = [(self.rate_hz, RATE_HZ), (self.strokes, STROKES)]
            .map(|(value, range)| [value, *range.start(), *range.end()].map(u64::from));
        count_within("rate_hz", rate[0], rate[1], rate[2])?;
        count_within("strokes", strokes[0], strokes[1], strokes[2])?;
        require_range("modulation_hz", self.modulation_hz, 0.0, 100.0, "Hz")?;
        require_range("modulation_index", self.modulation_index, 0.0, 1.0, "")?;
        if let Some(carrier_hz) = self.carrier_hz {
            let highest_hz = 0.49 * f64::from(self.rate_hz) - self.modulation_hz;
            require_range("carrier_hz", carrier_hz, 1e3, highest_hz, "Hz")?;
        }
        let full_scale_v = scenario.amplifier.volts_per_unit / (1.0 + self.modulation_index);
        require_range(
            "mean_amplitude_v",
            self.mean_amplitude_v,
            0.0,
            full_scale_v,
            "V",
        )?;
        match self.duration_s {
            Some(duration_s) => {
                let (low, high) = (*DURATION_S.start(), *DURATION_S.end());
                require_range("duration_s", duration_s, low, high, "s")
            }
            None => Ok(()),
        }
    }

    /// Returns the time that a trial of this plan takes, s; a slow person takes longer if no duration is given.
    pub(super) fn expected_s(&self) -> f64 {
        self.duration_s
            .unwrap_or(UNLOADED_S + STROKE_S * f64::from(self.strokes) + TAIL_S)
    }
}
