//! Comparison of the volts that a bench commands and reads back with an independent meter.

use std::fmt;

use crate::regression::{FittedLine, LineFitError, LinePoint};

/// One level, V peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoltsPoint {
    /// Commanded value.
    pub commanded_v: f64,
    /// Value read back by the bench.
    pub read_back_v: f64,
    /// Reading of the meter.
    pub known_v: f64,
    /// Standard deviation of the meter's reading.
    pub sigma_v: f64,
}

/// Lines through the meter's readings against the commanded and against the read-back values.
///
/// ```
/// use metrology::volts::{VoltsFit, VoltsPoint};
///
/// // An amplifier of 64 V where 60 were typed, twice.
/// let points = [5.0, 10.0, 15.0, 20.0].map(|v| VoltsPoint {
///     commanded_v: v,
///     read_back_v: v,
///     known_v: 64.0 / 60.0 * v,
///     sigma_v: 0.01,
/// });
/// let fit = VoltsFit::fit(&points)?;
/// assert!((fit.per_commanded.slope - 1.0667).abs() < 1e-4);
/// # Ok::<(), metrology::regression::LineFitError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VoltsFit {
    /// Meter against command.
    pub per_commanded: FittedLine,
    /// Meter against read-back.
    pub per_read_back: FittedLine,
}

impl VoltsFit {
    /// Fits both lines.
    ///
    /// # Errors
    /// Same as [`FittedLine::fit`].
    pub fn fit(points: &[VoltsPoint]) -> Result<Self, LineFitError> {
        let line_over = |x: fn(&VoltsPoint) -> f64| {
            let points: Vec<LinePoint> = points
                .iter()
                .map(|point| LinePoint {
                    x: x(point),
                    y: point.known_v,
                    sigma: point.sigma_v,
                })
                .collect();
            FittedLine::fit(&points)
        };
        Ok(Self {
            per_commanded: line_over(|point| point.commanded_v)?,
            per_read_back: line_over(|point| point.read_back_v)?,
        })
    }
}

/// Mistake of units inferred from the factor between a meter and a bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSlip {
    /// RMS of a sine in place of its peak.
    RmsForPeak,
    /// Peak in place of the RMS.
    PeakForRms,
    /// Peak-to-peak value in place of the peak.
    PeakToPeakForPeak,
    /// Peak in place of the peak-to-peak value.
    PeakForPeakToPeak,
    /// Peak-to-peak value in place of the RMS.
    PeakToPeakForRms,
    /// RMS in place of the peak-to-peak value.
    RmsForPeakToPeak,
}

/// Largest relative difference from a slip's factor for it to be named.
const NEAR: f64 = 0.04;

impl UnitSlip {
    /// Returns the slip with a factor close to the ratio of the meter's to the bench's volts; `None` if there is no such slip.
    #[must_use]
    pub fn from_ratio(known_over_believed: f64) -> Option<Self> {
        let near = |slip: &Self| (known_over_believed / slip.factor() - 1.0).abs() <= NEAR;
        [
            Self::RmsForPeak,
            Self::PeakForRms,
            Self::PeakToPeakForPeak,
            Self::PeakForPeakToPeak,
            Self::PeakToPeakForRms,
            Self::RmsForPeakToPeak,
        ]
        .into_iter()
        .find(near)
    }

    /// Returns the ratio of the value read to the value asked for.
    #[must_use]
    pub fn factor(self) -> f64 {
        use std::f64::consts::SQRT_2;
        match self {
            Self::RmsForPeak => 1.0 / SQRT_2,
            Self::PeakForRms => SQRT_2,
            Self::PeakToPeakForPeak => 2.0,
            Self::PeakForPeakToPeak => 0.5,
            Self::PeakToPeakForRms => 2.0 * SQRT_2,
            Self::RmsForPeakToPeak => 0.5 / SQRT_2,
        }
    }
}

impl fmt::Display for UnitSlip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (typed, requested) = match self {
            Self::RmsForPeak => ("RMS", "peak"),
            Self::PeakForRms => ("peak", "RMS"),
            Self::PeakToPeakForPeak => ("peak to peak", "peak"),
            Self::PeakForPeakToPeak => ("peak", "peak to peak"),
            Self::PeakToPeakForRms => ("peak to peak", "RMS"),
            Self::RmsForPeakToPeak => ("RMS", "peak to peak"),
        };
        write!(
            f,
            "a factor of {:.3} suggests {typed} where {requested} was asked for",
            self.factor()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_named_by_its_factor_and_others_are_not() {
        for (factor, slip) in [
            (0.71, Some(UnitSlip::RmsForPeak)),
            (0.72, Some(UnitSlip::RmsForPeak)),
            (1.4, Some(UnitSlip::PeakForRms)),
            (2.02, Some(UnitSlip::PeakToPeakForPeak)),
            (0.5, Some(UnitSlip::PeakForPeakToPeak)),
            (2.83, Some(UnitSlip::PeakToPeakForRms)),
            (0.3535, Some(UnitSlip::RmsForPeakToPeak)),
            (1.0, None),
            (1.069, None),
            (0.9, None),
            (1e3, None),
            (f64::NAN, None),
        ] {
            assert_eq!(UnitSlip::from_ratio(factor), slip, "{factor}");
        }
        let words = UnitSlip::PeakForRms.to_string();
        assert!(
            words.contains("1.414") && words.contains("peak where RMS"),
            "{words}"
        );
    }

    #[test]
    fn one_factor_may_be_wrong_alone() {
        let points = [4.0, 12.0, 20.0].map(|v| VoltsPoint {
            commanded_v: v,
            read_back_v: 0.9 * v,
            known_v: 0.9 * v,
            sigma_v: 1e-3,
        });
        let fit = VoltsFit::fit(&points).unwrap();
        assert!((fit.per_commanded.slope - 0.9).abs() < 1e-9);
        assert!((fit.per_read_back.slope - 1.0).abs() < 1e-9);
        assert!(VoltsFit::fit(&points[..2]).is_err());
    }
}
