//! The operator of a calibration, who receives one request at a time, sees the readings, and answers.

use config::MeterReads;
use safety::{DoseLeft, SafetyState};
use tui::event::SystemHealth;

/// Standard gravity, m/s² (ISO 80000-3).
pub const GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Mass of a gram, kg: weights are marked in grams.
pub const GRAM_KG: f64 = 1e-3;
/// Length of a micrometre, the unit of typed amplitudes and of instruments, m.
pub(crate) const MICROMETRE_M: f64 = 1e-6;

/// A direction of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ForceAxis {
    /// Pressing on the plate.
    Normal,
    /// Along the plate.
    Lateral,
}

impl ForceAxis {
    /// Returns the name of the axis.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Lateral => "lateral",
        }
    }

    /// Returns the index of the axis among readings: normal 0, lateral 1.
    #[must_use]
    pub fn index(self) -> usize {
        match self {
            Self::Normal => 0,
            Self::Lateral => 1,
        }
    }
}

/// Returns a mass in grams, rounded to the microgram: a typed mass is printed as it was typed.
///
/// ```
/// use calibration_rig::operator::{GRAM_KG, grams};
///
/// assert_eq!(grams(0.05 * GRAM_KG).to_string(), "0.05");
/// assert_eq!(grams(0.7 * GRAM_KG).to_string(), "0.7");
/// ```
#[must_use]
pub fn grams(mass_kg: f64) -> f64 {
    // A division gives the number nearest to the typed one; a product with 1e-6 may be its neighbour.
    (mass_kg * 1e9).round() / 1e6
}

/// A way to connect the signal's cables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cabling {
    /// The same signal is connected to all inputs.
    AllInputs,
    /// Only the drive's read-back is connected; the other inputs are open.
    DriveOnly,
    /// The bench is wired for measurements.
    Bench,
}

/// A request to the operator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Request {
    /// Load one axis of the force sensor with one mass and nothing else.
    Load {
        /// Axis of the force sensor.
        axis: ForceAxis,
        /// Mass, kg.
        mass_kg: f64,
    },
    /// Name an available mass for this axis, or report that the list is complete; [`Answer::Redo`] removes one.
    NameMass {
        /// Axis of the force sensor.
        axis: ForceAxis,
    },
    /// Remove everything from the plate, including weights and the finger.
    Unload,
    /// Rest a finger on the plate and keep it still.
    RestFinger {
        /// Smallest normal force, N.
        least_n: f64,
        /// Largest normal force, N.
        most_n: f64,
    },
    /// Aim the vibrometer at a place on the plate.
    MoveVibrometer {
        /// Position along the plate, m.
        position_m: f64,
    },
    /// Aim the vibrometer at a place across the plate.
    MoveVibrometerAcross {
        /// Position along the plate, m.
        position_m: f64,
        /// Distance from the line that the finger follows, m; positive on the side away from the participant.
        across_m: f64,
    },
    /// Change the cables.
    Connect(Cabling),
    /// Read the plate's peak amplitude on an instrument and type it.
    KnownAmplitude {
        /// Drive level, V peak.
        drive_v: f64,
        /// Amplitude predicted by the points so far, m.
        expected_m: Option<f64>,
    },
    /// Read the meter at the actuators and type its reading.
    MeterReading {
        /// Drive level, V peak.
        drive_v: f64,
        /// Quantity of a sine that the meter reads.
        reads: MeterReads,
    },
    /// Review the points: keep them, or name one to measure again.
    Review,
    /// Remove the cause of the break; the step is then repeated.
    GoOn,
}

/// Unit of a typed number, and whether the number is optional.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberEntry {
    /// Unit on the screen.
    pub unit: &'static str,
    /// Size of that unit in SI.
    pub si_per_unit: f64,
    /// Whether Enter alone is accepted, as [`Answer::Ready`].
    pub optional: bool,
}

impl Request {
    /// Returns the request as an instruction in plain words.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Load {
                axis: ForceAxis::Normal,
                mass_kg,
            } => format!(
                "Put {} g on the middle of the plate, and nothing else.",
                grams(*mass_kg)
            ),
            Self::Load {
                axis: ForceAxis::Lateral,
                mass_kg,
            } => format!(
                "Hang {} g on a thread over the pulley, so that it pulls towards increasing position.",
                grams(*mass_kg)
            ),
            Self::NameMass { axis: ForceAxis::Normal } => {
                "Type the masses that you will put on the plate, one at a time. \
                Press Enter alone after the last; r removes the selected mass.".to_owned()
            }
            Self::NameMass {
                axis: ForceAxis::Lateral,
            } => {
                "Type the masses that you will hang over the pulley, one at a time. \
                Press Enter alone after the last, or at once to use the masses of the plate that the lateral axis can carry.".to_owned()
            }
            Self::Unload => "Take everything off the plate: finger, weights, threads.".to_owned(),
            Self::RestFinger { least_n, most_n } => format!(
                "Rest a finger on the middle of the plate with {least_n} to {most_n} N, and keep it still until you are asked to \
                 lift it; the plate will vibrate faintly."
            ),
            Self::MoveVibrometer { position_m } => format!(
                "Aim the vibrometer at the plate {:.1} mm from its left end, on the line that the finger follows; touch nothing else.",
                position_m * 1e3
            ),
            Self::MoveVibrometerAcross {
                position_m,
                across_m,
            } => format!(
                "Aim the vibrometer at the plate {:.1} mm from its left end and {}; touch nothing else.",
                position_m * 1e3,
                distance_in_words(*across_m)
            ),
            Self::Connect(Cabling::AllInputs) => {
                "Connect the drive's read-back to all inputs at once, and take everything off the plate. \
                It is driven next, up to the highest voltage: do not touch it or the cables.".to_owned()
            }
            Self::Connect(Cabling::DriveOnly) => {
                "Connect the read-back to the drive's input alone; leave the other inputs open. \
                The plate is driven again: do not touch it or the cables."
                    .to_owned()
            }
            Self::Connect(Cabling::Bench) => "Connect the bench as for a measurement.".to_owned(),
            Self::KnownAmplitude { .. } => {
                "Read the plate's peak amplitude on your instrument and type it.".to_owned()
            }
            Self::MeterReading { reads, .. } => format!(
                "Read the meter across the actuators, in {}, and type it; touch neither its leads nor the plate.",
                reads.unit()
            ),
            Self::GoOn => {
                "Measured points are kept. Remove the cause and put everything back as it was for this step; Enter begins the step \
                 again, and may drive the plate at once.".to_owned()
            }
            Self::Review => {
                "Look at the results and the points. Keep them, or measure one of the points again.".to_owned()
            }
        }
    }

    /// Returns the format of the number to type; `None` for a request without a number.
    #[must_use]
    pub fn input(&self) -> Option<NumberEntry> {
        match self {
            Self::KnownAmplitude { .. } => Some(NumberEntry {
                unit: "µm",
                si_per_unit: MICROMETRE_M,
                optional: false,
            }),
            Self::MeterReading { reads, .. } => Some(NumberEntry {
                unit: reads.unit(),
                si_per_unit: reads.peak_per_reading(),
                optional: false,
            }),
            Self::NameMass { .. } => Some(NumberEntry {
                unit: "g",
                si_per_unit: GRAM_KG,
                optional: true,
            }),
            Self::Load { .. }
            | Self::Unload
            | Self::RestFinger { .. }
            | Self::MoveVibrometer { .. }
            | Self::MoveVibrometerAcross { .. }
            | Self::Connect(_)
            | Self::GoOn
            | Self::Review => None,
        }
    }
}

/// Returns a place across the plate in words.
fn distance_in_words(across_m: f64) -> String {
    let mm = format!("{:.1}", 1e3 * across_m.abs());
    if mm == "0.0" {
        return "on the line that the finger follows".to_owned();
    }
    let side = if across_m > 0.0 { "beyond" } else { "before" };
    format!("{mm} mm {side} the line that the finger follows, as the participant sees it")
}

/// An answer to a request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// The request is done; at a review, the points are kept.
    Ready,
    /// A number in SI units.
    Number(f64),
    /// The point with this index, from 0, is to be measured again.
    Redo(usize),
}

/// An input of the operator, possible at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorInput {
    /// An answer to the request.
    Answer(Answer),
    /// Quit; nothing is written.
    Leave,
    /// Stop the drive at once.
    Stop,
    /// Release the latch of a trip.
    Rearm,
}

/// Present readings: means since the previous reading.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LiveReading {
    /// Time on the audio clock, s.
    pub t_s: f64,
    /// Normal force, N.
    pub normal_n: Option<f64>,
    /// Lateral force, N.
    pub lateral_n: Option<f64>,
    /// Read-back of the drive, V peak.
    pub drive_v: f64,
    /// Amplitude of the pickup by the present sensitivity, m peak.
    pub amplitude_m: f64,
    /// Largest sample of any input, of full scale.
    pub level: f64,
    /// Latest reading of an instrument in micrometres, m peak.
    pub known_m: Option<f64>,
    /// Latest reading of a meter in volts, V.
    pub known_v: Option<f64>,
    /// State of the safety watch.
    pub safety: SafetyState,
    /// Whether the plate is driven, including ramps.
    pub sounds: bool,
    /// Remaining driving time of the hour.
    pub dose: Option<DoseLeft>,
}

/// Progress of a measurement.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CalibrationProgress {
    /// Number of the present step, from 1.
    pub step: usize,
    /// Number of steps.
    pub steps: usize,
    /// Present activity in a few words, shown while no request is open.
    pub doing: String,
    /// Note on the last answer or step, such as the reason for a repetition.
    pub note: Option<String>,
    /// Points measured so far.
    pub points: Vec<PointRead>,
    /// Points as a curve.
    pub curve: Option<Curve>,
    /// Results so far, a line each.
    pub findings: Vec<String>,
    /// Whether the results under review do not pass.
    pub rejected: bool,
}

/// A measured point in words.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointRead {
    /// Position of the point on its axis, with unit.
    pub place: String,
    /// Reading, with unit.
    pub value: String,
    /// Residual, with unit.
    pub residual: Option<String>,
    /// Whether its residual is the largest.
    pub worst: bool,
}

/// Points of a curve and the fit to them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Label of the horizontal axis, with unit.
    pub x: String,
    /// Label of the vertical axis, with unit.
    pub y: String,
    /// Points of the curve.
    pub points: Vec<(f64, f64)>,
    /// Points of the fitted line.
    pub fit: Vec<(f64, f64)>,
}

/// An operator who receives requests and sees the progress: a person, or a program in their place.
pub trait Operator: Send {
    /// Replaces the present request; `None` ends it.
    fn ask(&mut self, request: Option<&Request>);

    /// Shows the progress of the measurement, after every step.
    fn progress(&mut self, progress: &CalibrationProgress);

    /// Shows the present readings, about twenty times a second.
    fn show(&mut self, now: &LiveReading);

    /// Shows the health of the bench, twice a second.
    fn health(&mut self, _now: &SystemHealth) {}

    /// Returns the operator's next input, if any.
    ///
    /// # Errors
    /// If the request cannot be fulfilled; the error gives the remedy.
    fn next_input(&mut self) -> anyhow::Result<Option<OperatorInput>>;

    /// Reports that a step was broken off, and waits for [`Answer::Ready`]; `obstacle` says why the last key did not help.
    /// Returns whether an operator is present to continue.
    fn broken_off(&mut self, why: &str, obstacle: Option<&str>) -> bool;

    /// Reports that the measurement has failed; returns whether an operator reads the report and will then quit.
    fn failed(&mut self, why: &str) -> bool;

    /// Closes the operator's screen at the end of the measurement.
    fn close(&mut self);
}

/// Simulated operator's hands, which carry out a calibration's requests at once.
pub type Hands = Box<dyn FnMut(&Request) + Send>;
