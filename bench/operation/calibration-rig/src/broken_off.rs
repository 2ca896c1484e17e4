//! Steps that were broken off and can be repeated; earlier measurements are kept.

use safety::Trip;

use crate::operator::{CalibrationProgress, PointRead};

/// Read-back below which the carrier counts as lost rather than as a gain error, as a share of the command.
const VANISHED: f64 = 0.3;

/// Reason why a step was broken off.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct BrokenOff(pub(super) String);

impl BrokenOff {
    /// Returns the break caused by a trip of the safety watch, with a reason in terms of the calibration.
    pub(super) fn from_trip(trip: &Trip) -> Self {
        Self(match trip {
            Trip::Readback {
                measured_v,
                commanded_v: (_, high_v),
            } if *measured_v < VANISHED * high_v => format!(
                "the carrier does not come back: {high_v:.2} V were played and {measured_v:.3} V read; a sound layer of 48 kHz or less resamples it away (use a raw device such as hw:…), the amplifier is off, or a cable is out"
            ),
            Trip::ReadbackMissing => format!(
                "the safety watch stopped the calibration: {trip}: this computer was too busy to look at the samples \
                 in time, or the sound card stalled; close other programs"
            ),
            _ => format!("the safety watch stopped the calibration: {trip}"),
        })
    }
}

/// A measurement that ended early because no operator was present to continue it.
#[derive(Debug, thiserror::Error)]
#[error("{}", bounded_files::cause_line(why.as_ref()))]
pub struct EndedEarly {
    /// Reason for the end.
    pub why: anyhow::Error,
    /// Points measured before the end.
    pub points: Vec<PointRead>,
}

impl EndedEarly {
    /// Creates the error of a measurement with this progress.
    pub(super) fn from_progress(progress: Option<CalibrationProgress>, why: anyhow::Error) -> Self {
        let points = progress.map_or_else(Vec::new, |progress| progress.points);
        Self { why, points }
    }

    /// Returns the points as CSV, each number with its unit.
    ///
    /// # Errors
    /// Never for text that can be printed.
    pub fn table(&self) -> anyhow::Result<String> {
        let mut table = csv::Writer::from_writer(Vec::new());
        table.write_record(["at", "value", "residual"])?;
        for point in &self.points {
            let residual = point.residual.as_deref().unwrap_or_default();
            table.write_record([&point.place, &point.value, residual])?;
        }
        Ok(String::from_utf8(table.into_inner()?)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_busy_computer_and_a_carrier_that_is_gone_are_named() {
        let words = BrokenOff::from_trip(&Trip::ReadbackMissing).to_string();
        assert!(words.contains("too busy"), "{words}");
        let reads = |measured_v| {
            let commanded_v = (4.9, 5.0);
            let trip = Trip::Readback {
                measured_v,
                commanded_v,
            };
            BrokenOff::from_trip(&trip).to_string()
        };
        assert!(reads(0.1).contains("does not come back"), "{}", reads(0.1));
        assert!(reads(4.0).starts_with("the safety watch"), "{}", reads(4.0));
        let words = BrokenOff::from_trip(&Trip::Operator).to_string();
        assert!(words.starts_with("the safety watch stopped"), "{words}");
    }
}
