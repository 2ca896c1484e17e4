//! Factors that name their cause.

use std::f64::consts::SQRT_2;
use std::fmt;

use serde::{Deserialize, Serialize};
use statistics::significant;

/// Cause of a factor between a stated scale and the true one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// Gain of an amplifier or of a probe.
    Gain,
    /// Peak-to-peak value for peak, or the reverse.
    PeakToPeak,
    /// RMS value for peak, or the reverse.
    Rms,
    /// Peak-to-peak value for RMS, or the reverse.
    PeakToPeakForRms,
    /// Prefix of a unit.
    Prefix,
}

/// Factors and their causes; each also stands for its inverse.
const FACTORS: [(f64, Cause); 10] = [
    (SQRT_2, Cause::Rms),
    (2.0, Cause::PeakToPeak),
    (2.0 * SQRT_2, Cause::PeakToPeakForRms),
    (5.0, Cause::Gain),
    (10.0, Cause::Gain),
    (20.0, Cause::Gain),
    (50.0, Cause::Gain),
    (100.0, Cause::Gain),
    (1e3, Cause::Prefix),
    (1e6, Cause::Prefix),
];

/// Factor by which a scale is off, with its cause.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TellingFactor {
    /// Factor, from 1e-6 to 1e6.
    pub factor: f64,
    /// Cause.
    pub cause: Cause,
}

impl TellingFactor {
    /// Returns the factor that a measured ratio shows within `tolerance`, relative; `None` if it shows none.
    ///
    /// ```
    /// use force_alignment::{Cause, TellingFactor};
    ///
    /// let found = TellingFactor::of_ratio(0.0502, 0.05).unwrap();
    /// assert_eq!((found.factor, found.cause), (1.0 / 20.0, Cause::Gain));
    /// assert_eq!(TellingFactor::of_ratio(1.1, 0.05), None);
    /// ```
    #[must_use]
    pub fn of_ratio(ratio: f64, tolerance: f64) -> Option<Self> {
        let both = FACTORS
            .iter()
            .flat_map(|(factor, cause)| [(*factor, *cause), (factor.recip(), *cause)]);
        let distance = |factor: f64| (ratio / factor).ln().abs();
        let (factor, cause) = both.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))?;
        (distance(factor) <= tolerance).then_some(Self { factor, cause })
    }
}

impl TellingFactor {
    /// Returns the factor without its cause, as in "1/20" and "2√2".
    #[must_use]
    pub fn number(&self) -> String {
        let is_inverse = self.factor < 1.0;
        let size = if is_inverse {
            self.factor.recip()
        } else {
            self.factor
        };
        let size = match self.cause {
            Cause::Rms => "√2".to_owned(),
            Cause::PeakToPeakForRms => "2√2".to_owned(),
            Cause::Gain | Cause::PeakToPeak | Cause::Prefix => significant(size),
        };
        if is_inverse {
            format!("1/{size}")
        } else {
            size
        }
    }
}

impl fmt::Display for TellingFactor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.number())?;
        f.write_str(match self.cause {
            Cause::Gain => ", as the gain of an amplifier or a probe makes it",
            Cause::PeakToPeak => ", as peak-to-peak values make it",
            Cause::Rms => ", as RMS values make it",
            Cause::PeakToPeakForRms => ", as peak-to-peak values in place of RMS values make it",
            Cause::Prefix => ", as another prefix of the unit makes it",
        })
    }
}
