//! What a calibration has found, and whether it holds.

use jiff::Timestamp;

use crate::procedure::Procedure;
use ::figures::Figure;
use config::{CalibrationFile, Quantity};

/// A measurement of which a part of the calibration file is made.
pub trait Calibrates: Procedure {
    /// Name of its command, and of its table.
    const NAME: &'static str;

    /// Judges what was measured on `date` by `operator`.
    ///
    /// # Errors
    /// When it determines nothing.
    fn judge(&self, date: Timestamp, operator: &str) -> anyhow::Result<Judged>;
}

/// A judged measurement.
#[derive(Debug)]
pub struct Judged {
    /// For the file.
    pub part: Part,
    /// The values, by name.
    pub values: Vec<(&'static str, Quantity)>,
    /// Further figures, a line each.
    pub remarks: Vec<String>,
    /// Reasons not to use it; none when it passes.
    pub faults: Vec<String>,
    /// Of the name of their files, after that of the calibration's.
    pub stem: &'static str,
    /// The points and their residuals as CSV.
    pub table: String,
    /// The same, drawn.
    pub figure: Option<Figure>,
}

/// A part of the calibration file.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// `[pickup]`
    Pickup(Box<config::MeasuredPickup>),
    /// `[plate]`
    Plate(Box<config::MeasuredPlate>),
    /// `[force]`
    Force {
        /// What was measured.
        force: Box<config::MeasuredForce>,
        /// On which sensor.
        sensor: String,
    },
    /// `[channels]`
    Channels(Box<config::MeasuredChannels>),
}

impl Part {
    /// Puts it in force, and says what no longer is.
    pub fn put_into(self, calibration: &mut CalibrationFile) -> Option<String> {
        match self {
            Self::Pickup(pickup) => {
                calibration.pickup = Some(*pickup);
                calibration.plate.take().map(|_| {
                    "the plate's force factor rested on the sensitivity before: run `friction-bench calibrate plate` again".to_owned()
                })
            }
            Self::Plate(plate) => {
                calibration.plate = Some(*plate);
                None
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
        }
    }
}
