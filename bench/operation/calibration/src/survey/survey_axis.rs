//! Axis on which the places of a survey lie: along the plate, or across it.

use anyhow::{Context, bail};
use calibration_rig::operator::Request;
use config::{PROFILE_RATIOS, Plate};

/// Fewest and most places along the plate.
pub const PLACES: [u32; 2] = [3, 50];
/// Fewest and most places across the plate: the cosine has three parameters.
pub const PLACES_ACROSS: [u32; 2] = [6, 50];
/// Distance of the first and last place from the plate's ends, m: a laser spot needs a margin.
const MARGIN_M: f64 = 5e-3;
/// The same distance across the plate, m.
const MARGIN_ACROSS_M: f64 = 1e-3;
/// Length across the plate on which the places lie, m: a fingertip is at most 14 mm wide, and at the edges the mode is not a cosine.
const REACH_ACROSS_M: f64 = 16e-3;
/// Shortest such length, m.
const LEAST_REACH_M: f64 = 3e-3;
/// Smallest and largest usable ratio across the plate; a place may lie on a nodal line.
const ACROSS_RATIOS: [f64; 2] = [0.0, 5.0];

/// Axis of a survey.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SurveyAxis {
    /// Along the plate; positions are those of the finger's path.
    Along,
    /// Across the plate, at the middle of its length; positions are distances from the line that the finger follows.
    Across {
        /// Middle of the plate's length, m.
        middle_m: f64,
    },
}

impl SurveyAxis {
    /// Returns the axis across a plate.
    pub fn across(plate: &Plate) -> Self {
        Self::Across {
            middle_m: plate.centre_m,
        }
    }

    /// Returns the positions of this number of places on `plate`, m.
    ///
    /// # Errors
    /// If there are too few or too many places, or the plate is too short or narrow for them.
    pub fn places_m(self, plate: &Plate, places: u32) -> anyhow::Result<Vec<f64>> {
        let (option, words, [fewest, most]) = match self {
            Self::Along => ("--along", "along", PLACES),
            Self::Across { .. } => ("--across", "across", PLACES_ACROSS),
        };
        if !(fewest..=most).contains(&places) {
            bail!(
                "{option} = {places} is outside {fewest} to {most}: so many places are measured {words} the plate"
            );
        }
        let (first_m, reach_m) = match self {
            Self::Along => along_m(plate)?,
            Self::Across { .. } => across_m(plate)?,
        };
        let step_m = reach_m / f64::from(places - 1);
        Ok((0..places)
            .map(|i| first_m + f64::from(i) * step_m)
            .collect())
    }

    /// Returns the request to aim at a place.
    pub fn request(self, position_m: f64) -> Request {
        match self {
            Self::Along => Request::MoveVibrometer { position_m },
            Self::Across { middle_m } => Request::MoveVibrometerAcross {
                position_m: middle_m,
                across_m: position_m,
            },
        }
    }

    /// Returns the reason why a ratio cannot be used, if it cannot.
    pub fn unusable(self, ratio: f64) -> Option<String> {
        let [least, greatest] = match self {
            Self::Along => PROFILE_RATIOS,
            Self::Across { .. } => ACROSS_RATIOS,
        };
        (!(least..=greatest).contains(&ratio)).then(|| {
            format!("the vibrometer reads {ratio:.2} times what the pickup reads, outside {least} to {greatest}")
        })
    }

    /// Returns the name of the positions on the screen.
    pub fn label(self) -> &'static str {
        match self {
            Self::Along => "position, mm",
            Self::Across { .. } => "across, mm",
        }
    }
}

/// Returns the first place along a plate and the length to the last, m.
fn along_m(plate: &Plate) -> anyhow::Result<(f64, f64)> {
    let reach_m = plate.length_m - 2.0 * MARGIN_M;
    if reach_m <= 0.0 {
        bail!(
            "plate.length_m = {} m leaves no places {} mm from both ends",
            plate.length_m,
            1e3 * MARGIN_M
        );
    }
    Ok((MARGIN_M, reach_m))
}

/// Returns the first place across a plate and the length to the last, m, symmetric about the finger's line.
fn across_m(plate: &Plate) -> anyhow::Result<(f64, f64)> {
    let width_m = plate.width_m.context(
        "--across needs the plate's width: set plate.width_m in bench.toml, such as width_m = 0.022",
    )?;
    let reach_m = (width_m - 2.0 * MARGIN_ACROSS_M).min(REACH_ACROSS_M);
    if reach_m < LEAST_REACH_M {
        bail!(
            "plate.width_m = {width_m} m leaves less than {} mm for places {} mm from both edges",
            1e3 * LEAST_REACH_M,
            1e3 * MARGIN_ACROSS_M
        );
    }
    Ok((-0.5 * reach_m, reach_m))
}
