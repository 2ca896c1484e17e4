//! Clock of a recording's forces against that of drive and pickup.

use plausibility::Implausible;
use recording::ForceRow;
use serde::{Deserialize, Serialize};

/// Clock of the forces, as the recording itself shows it: t_drive = t_file + offset_s + ppm · 10⁻⁶ · (t_file − at_s).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ForceClock {
    /// Time at which the offset is stated: the middle of the slides, s.
    pub at_s: f64,
    /// Time from the first to the last slide, s.
    pub length_s: f64,
    /// Offset: negative if the forces come late.
    pub offset_s: Measured,
    /// Excess of the rate of true times over the file's, parts per million.
    pub ppm: Measured,
    /// Whether all other findings have the offset corrected.
    pub is_offset_corrected: bool,
    /// Whether all other findings have the rate corrected.
    pub is_rate_corrected: bool,
    /// Residual of the friction over the shift of the forces from the offset found.
    pub residual: Vec<ResidualPoint>,
}

/// Value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Value.
    pub value: f64,
    /// Standard error.
    pub std: f64,
}

impl Measured {
    /// Returns the half width of the 95 % interval.
    #[must_use]
    pub fn half_width95(self) -> f64 {
        statistics::NORMAL_95 * self.std
    }
}

impl From<force_alignment::Estimate> for Measured {
    fn from(estimate: force_alignment::Estimate) -> Self {
        Self {
            value: estimate.value,
            std: estimate.std,
        }
    }
}

/// Point of the residual over the shift.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualPoint {
    /// Further delay of the forces, s.
    pub shift_s: f64,
    /// Share of the friction's variance that the film's amplitude leaves unexplained.
    pub residual: f64,
}

impl ForceClock {
    /// Returns the same clock, of which nothing is corrected.
    pub(super) fn uncorrected(self) -> Self {
        Self {
            is_offset_corrected: false,
            is_rate_corrected: false,
            ..self
        }
    }

    /// Returns whether anything is corrected.
    #[must_use]
    pub fn is_corrected(&self) -> bool {
        self.is_offset_corrected || self.is_rate_corrected
    }

    /// Returns the flaws of the clock: its corrected values.
    pub(super) fn flaws(&self) -> impl Iterator<Item = Implausible> + use<> {
        let late = self.is_offset_corrected.then_some(Implausible::ForcesLate {
            late_s: -self.offset_s.value,
            half_width95_s: self.offset_s.half_width95(),
        });
        let rate = self.is_rate_corrected.then_some(Implausible::ForcesClock {
            ppm: self.ppm.value,
            half_width95_ppm: self.ppm.half_width95(),
        });
        late.into_iter().chain(rate)
    }

    /// Puts the readings on the clock of drive and pickup.
    pub(super) fn correct(&self, rows: &mut [ForceRow]) {
        let unless = |is_corrected: bool, value: f64| if is_corrected { value } else { 0.0 };
        let offset_s = unless(self.is_offset_corrected, self.offset_s.value);
        let ratio = 1.0 + 1e-6 * unless(self.is_rate_corrected, self.ppm.value);
        for row in rows {
            row.time_s = self.at_s + (row.time_s + offset_s - self.at_s) * ratio;
        }
    }
}
