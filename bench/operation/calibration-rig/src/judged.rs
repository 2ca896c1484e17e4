//! Results of a calibration, and whether they may be used.

use jiff::Timestamp;

use crate::procedure::Procedure;
use config::{CalibrationFile, Quantity};
use plotting::Figure;

/// A procedure with a result for the calibration file.
pub trait Calibrates: Procedure {
    /// Name of its command and of its table.
    const NAME: &'static str;
    /// Whether a finger is on the plate, so that the driving time counts for a person.
    const DRIVES_A_FINGER: bool = false;

    /// Judges the measurement, made on `date` by `operator`.
    ///
    /// # Errors
    /// If the measurement determines no result.
    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged>;

    /// Judges the results under review: those of the part measured last, if the measurement has several.
    ///
    /// # Errors
    /// If the measurement determines no result.
    fn judge_review(&self) -> anyhow::Result<Judged> {
        // Date and operator are no part of the results.
        self.judge(Timestamp::UNIX_EPOCH, "")
    }
}

/// A judged measurement.
#[derive(Debug)]
pub struct Judged {
    /// Part of the calibration file.
    pub part: Part,
    /// Measured values by name.
    pub values: Vec<(&'static str, Quantity)>,
    /// Further figures, a line each.
    pub remarks: Vec<String>,
    /// Reasons to reject the measurement; empty when it passes.
    pub faults: Vec<String>,
    /// Suffix for the names of its table and figure, which begin with the calibration's name.
    pub stem: &'static str,
    /// Points and residuals as CSV.
    pub table: String,
    /// Points and residuals as a figure.
    pub figure: Option<Figure>,
    /// Further tables and figures.
    pub side_files: Vec<SideFile>,
}

/// A further table of a measurement, with its figure if it has one.
#[derive(Debug)]
pub struct SideFile {
    /// Suffix for the names of its files, which begin with the calibration's name.
    pub stem: &'static str,
    /// Points as CSV.
    pub table: String,
    /// Points as a figure.
    pub figure: Option<Figure>,
}

/// A part of the calibration file.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// `[pickup]`: the pickup's sensitivity.
    Pickup(Box<config::MeasuredPickup>),
    /// `[plate]`: the plate's constants.
    Plate {
        /// Measured constants.
        plate: Box<config::MeasuredPlate>,
        /// The same plate under a finger, if measured.
        finger: Option<Box<config::MeasuredFinger>>,
        /// The amplitude along its length, if measured.
        profile: Option<Box<config::MeasuredProfile>>,
        /// The amplitude across its width, if measured.
        across: Option<Box<config::MeasuredAcross>>,
    },
    /// `[force]`: the force sensor's matrix and tare.
    Force {
        /// Measured constants.
        force: Box<config::MeasuredForce>,
        /// Identity of the sensor.
        sensor: String,
    },
    /// `[channels]`: the inputs compared with the drive's.
    Channels(Box<config::MeasuredChannels>),
    /// `[output]`: the volts against an independent meter.
    Output(Box<config::MeasuredOutput>),
}

impl Part {
    /// Writes the part into `calibration`; returns a remark on the parts that it invalidates, if any.
    pub fn put_into(self, calibration: &mut CalibrationFile) -> Option<String> {
        match self {
            Self::Pickup(pickup) => {
                calibration.pickup = Some(*pickup);
                // All of them depend on the pickup's previous sensitivity.
                (calibration.finger, calibration.profile) = (None, None);
                calibration.across = None;
                calibration.plate.take().map(|_| {
                    "the plate's force factor was computed with the old sensitivity and no longer holds: run `friction-bench calibrate plate` again".to_owned()
                })
            }
            Self::Plate {
                plate,
                finger,
                profile,
                across,
            } => {
                calibration.plate = Some(*plate);
                if let Some(profile) = profile {
                    calibration.profile = Some(*profile);
                }
                if let Some(across) = across {
                    calibration.across = Some(*across);
                }
                let is_removed = calibration.finger.is_some() && finger.is_none();
                calibration.finger = finger.map(|finger| *finger);
                is_removed.then(|| {
                    "the response under a finger belonged to the plate's old constants and was taken out; --finger measures \
                     it again"
                        .to_owned()
                })
            }
            Self::Force { force, sensor } => {
                calibration.force = Some(*force);
                calibration.identity.force_sensor = Some(sensor);
                None
            }
            Self::Channels(channels) => {
                calibration.channels = Some(*channels);
                None
            }
            Self::Output(output) => {
                calibration.output = Some(*output);
                None
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use config::{Config, MeasuredPickup, Provenance};

    /// Returns the pickup of a bench as if it had been measured without error.
    pub(crate) fn pickup_part(config: &Config) -> Part {
        let exact = |value: f64| Quantity::new(value, 0.0, 1, "m");
        Part::Pickup(Box::new(MeasuredPickup {
            measured: Provenance {
                date: Timestamp::UNIX_EPOCH,
                operator: String::new(),
                method: String::new(),
            },
            metres_per_unit: exact(config.channels.pickup.metres_per_unit),
            phase_rad: None,
            offset: exact(0.0),
            nonlinearity: 0.0,
            points: 1,
            carrier_hz: config.plate.resonance_hz,
        }))
    }
}
