//! The person at the bench, as a calibration sees them: asked for one thing at a time, shown what happens, answering.

use safety::SafetyState;

/// Standard gravity, m/s² (ISO 80000-3).
pub const GRAVITY_M_PER_S2: f64 = 9.806_65;
/// Grams, as weights are marked.
pub const GRAM_KG: f64 = 1e-3;
/// Micrometres, as people type amplitudes.
const MICROMETRE_M: f64 = 1e-6;

/// A direction of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ForceAxis {
    /// Pressing on the plate.
    Normal,
    /// Along the plate.
    Lateral,
}

impl ForceAxis {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Lateral => "lateral",
        }
    }

    /// Its place among readings: normal first.
    #[must_use]
    pub fn index(self) -> usize {
        match self {
            Self::Normal => 0,
            Self::Lateral => 1,
        }
    }
}

/// A mass in grams, to the microgram.
#[must_use]
pub fn grams(mass_kg: f64) -> f64 {
    (mass_kg * 1e9).round() * 1e-6
}

/// How the signal's cables run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Cabling {
    /// One signal on all inputs at once.
    AllInputs,
    /// The drive's read-back alone; the other inputs are open.
    DriveOnly,
    /// As the bench is wired for measurements.
    Bench,
}

/// What the operator is asked to do; its words are derived from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Request {
    /// Put this mass, and nothing else, on this axis of the force sensor.
    Load {
        /// Which axis.
        axis: ForceAxis,
        /// How much, kg; gravity pulls at it.
        mass_kg: f64,
    },
    /// Name a mass that is at hand for this axis, or say that these are all; [`Answer::Redo`] takes one out again.
    NameMass {
        /// Which axis.
        axis: ForceAxis,
    },
    /// Take everything off: weights, finger.
    Unload,
    /// Change the cables.
    Connect(Cabling),
    /// Read the plate's peak amplitude on an instrument and type it.
    KnownAmplitude {
        /// At this drive level, V peak.
        drive_v: f64,
        /// What the points so far let expect, m.
        expected_m: Option<f64>,
    },
    /// Look at what was measured: keep it, or name a point to measure again.
    Review,
}

/// How a number is typed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NumberEntry {
    /// Its unit on the screen.
    pub unit: &'static str,
    /// That unit in SI.
    pub si_per_unit: f64,
    /// There may be none: then it is [`Answer::Ready`].
    pub optional: bool,
}

impl Request {
    /// One instruction in plain words.
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
                "Type the masses that you will put on the plate, one at a time; Enter alone when these are all, r takes the chosen one out.".to_owned()
            }
            Self::NameMass {
                axis: ForceAxis::Lateral,
            } => {
                "Type the masses that you will hang over the pulley, one at a time; Enter alone when these are all, or at once for those of the plate, as far as the axis may carry them.".to_owned()
            }
            Self::Unload => "Take everything off the plate: finger, weights, threads.".to_owned(),
            Self::Connect(Cabling::AllInputs) => {
                "Connect the drive's read-back to all inputs at once.".to_owned()
            }
            Self::Connect(Cabling::DriveOnly) => {
                "Connect the read-back to the drive's input alone; leave the other inputs open."
                    .to_owned()
            }
            Self::Connect(Cabling::Bench) => "Connect the bench as for a measurement.".to_owned(),
            Self::KnownAmplitude { .. } => {
                "Read the plate's peak amplitude on your instrument and type it.".to_owned()
            }
            Self::Review => {
                "Look at the points. Keep them, or measure one of them again.".to_owned()
            }
        }
    }

    /// The number that it wants, if it wants one.
    #[must_use]
    pub fn input(&self) -> Option<NumberEntry> {
        match self {
            Self::KnownAmplitude { .. } => Some(NumberEntry {
                unit: "µm",
                si_per_unit: MICROMETRE_M,
                optional: false,
            }),
            Self::NameMass { .. } => Some(NumberEntry {
                unit: "g",
                si_per_unit: GRAM_KG,
                optional: true,
            }),
            Self::Load { .. } | Self::Unload | Self::Connect(_) | Self::Review => None,
        }
    }
}

/// What the operator says to a request.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// It is done; at a review: keep.
    Ready,
    /// A number, SI.
    Number(f64),
    /// Measure this point again, counted from 0.
    Redo(usize),
}

/// What an operator may want at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OperatorInput {
    /// To answer the request.
    Answer(Answer),
    /// To leave; nothing is written.
    Leave,
    /// The drive stopped at once.
    Stop,
}

/// What is read just now; means over the time since the reading before.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LiveReading {
    /// Time on the audio clock, s.
    pub t_s: f64,
    /// Normal force, N.
    pub normal_n: Option<f64>,
    /// Lateral force, N.
    pub lateral_n: Option<f64>,
    /// Drive read back, V peak.
    pub drive_v: f64,
    /// Pickup by the sensitivity in force, m peak.
    pub amplitude_m: f64,
    /// Largest sample of any input, of full scale.
    pub level: f64,
    /// Latest reading of the instrument, m peak.
    pub known_m: Option<f64>,
    /// The safety watch.
    pub safety: SafetyState,
    /// The plate is driven, or a ramp is not over.
    pub sounds: bool,
}

/// How far a measurement has come.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CalibrationProgress {
    /// Number of the present step, from 1.
    pub step: usize,
    /// How many there are.
    pub steps: usize,
    /// What happens in it, in a few words, while nothing is asked.
    pub doing: String,
    /// What the operator should know about the last answer or step: why it is asked again.
    pub note: Option<String>,
    /// The points so far.
    pub points: Vec<PointRead>,
    /// The points as a curve.
    pub curve: Option<Curve>,
    /// What has come out so far, a line each.
    pub findings: Vec<String>,
}

/// One measured point, in words.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointRead {
    /// Where it was taken, with its unit.
    pub at: String,
    /// What was read, with its unit.
    pub value: String,
    /// By how much it departs from all together, with its unit.
    pub residual: Option<String>,
    /// It departs most.
    pub worst: bool,
}

/// Points over an axis, and what was fitted to them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// What lies along, with its unit.
    pub x: String,
    /// What lies up, with its unit.
    pub y: String,
    /// The points.
    pub points: Vec<(f64, f64)>,
    /// The fit, as a line through these.
    pub fit: Vec<(f64, f64)>,
}

/// Whoever is asked.
pub trait Operator: Send {
    /// Asks for one thing; an earlier request is over. `None` when nothing is asked any more.
    fn ask(&mut self, request: Option<&Request>);

    /// Shows how far the measurement has come: after every step.
    fn progress(&mut self, progress: &CalibrationProgress);

    /// Shows what is read, some twenty times a second.
    fn show(&mut self, now: &LiveReading);

    /// What the operator wants next.
    ///
    /// # Errors
    /// When what is asked is not going to happen: names what to do.
    fn next_input(&mut self) -> anyhow::Result<Option<OperatorInput>>;

    /// Says that the measurement has failed; true when somebody wants to read it before it ends, and will then leave.
    fn failed(&mut self, why: &str) -> bool;

    /// The measurement is over.
    fn close(&mut self);
}

/// Does what a calibration asks of its operator, at once: the hands of a simulated apparatus.
pub type Hands = Box<dyn FnMut(&Request) + Send>;
