//! `calibrate plate --along N` and `--across N`: measures the amplitude at places along or across the plate, with a movable
//! vibrometer, relative to the amplitude read by the pickup.

use crate::instrument_mean::{WINDOW_S, instrument_mean, too_few};
use crate::plate_look;
use crate::plate_procedure::PlateProcedure;
use anyhow::{Context, bail};
use calibration_rig::capture::Capture;
use calibration_rig::known::INSTRUMENT_LAG_S;
use calibration_rig::operator::{Answer, CalibrationProgress, Curve, PointRead, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;
use signalgen::{ToneList, Waveform};

use crate::survey::cosine;
use crate::survey::profile_point::ProfilePoint;
use crate::survey::survey_axis::SurveyAxis;

/// Amplitude below any instrument's resolution, m.
const INVISIBLE_M: f64 = 1e-13;
/// Level of the tone, V peak; lowered where a limit requires it.
const LEVEL_V: f64 = 20.0;
/// Relative standard error assumed of a typed amplitude: its last digit.
const TYPED: f64 = 2e-3;
/// Smallest ratio of which that share counts: near a nodal line the last digit does not shrink.
const TYPED_RATIO: f64 = 0.1;

/// Procedure of `calibrate plate --along N` and `--across N`.
pub struct ProfileProcedure {
    pub(crate) axis: SurveyAxis,
    pub(crate) plate: PlateProcedure,
    pub(crate) config: Config,
    metres_per_unit: f64,
    /// Whether an instrument is read; otherwise the operator types.
    instrument: bool,
    places_m: Vec<f64>,
    pub(crate) places: Vec<ProfilePoint>,
    /// Index of the place being measured, from 0.
    place_index: usize,
    stage: Stage,
    pub(crate) level_v: f64,
    note: Option<String>,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Plate,
    Moving,
    Reading,
    Review,
    Done,
}

impl ProfileProcedure {
    /// Creates a procedure that has not begun, with this number of places along the plate; `metres_per_unit` is the pickup's
    /// measured sensitivity.
    ///
    /// # Errors
    /// If there are too few or too many places, or the plate is too short for them.
    pub fn along(
        plate: PlateProcedure,
        config: &Config,
        metres_per_unit: f64,
        places: u32,
        instrument: bool,
    ) -> anyhow::Result<Self> {
        let axis = SurveyAxis::Along;
        Self::new(axis, plate, config, (metres_per_unit, places), instrument)
    }

    /// Creates a procedure like [`ProfileProcedure::along`], with its places across the plate.
    ///
    /// # Errors
    /// If there are too few or too many places, or the plate's width is not configured or too small for them.
    pub fn across(
        plate: PlateProcedure,
        config: &Config,
        metres_per_unit: f64,
        places: u32,
        instrument: bool,
    ) -> anyhow::Result<Self> {
        let axis = SurveyAxis::across(&config.plate);
        Self::new(axis, plate, config, (metres_per_unit, places), instrument)
    }

    fn new(
        axis: SurveyAxis,
        plate: PlateProcedure,
        config: &Config,
        (metres_per_unit, places): (f64, u32),
        instrument: bool,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            axis,
            plate,
            config: config.clone(),
            metres_per_unit,
            instrument,
            places_m: axis.places_m(&config.plate, places)?,
            places: Vec::new(),
            place_index: 0,
            stage: Stage::Plate,
            level_v: LEVEL_V,
            note: None,
        })
    }

    pub(crate) fn carrier_hz(&self) -> f64 {
        self.plate
            .fit
            .as_ref()
            .map_or(0.0, |fit| fit.resonance_hz.value)
    }

    fn step(&mut self) -> NextStep {
        let Some(&position_m) = self.places_m.get(self.place_index) else {
            self.stage = Stage::Review;
            return NextStep::Ask(Request::Review);
        };
        self.stage = Stage::Moving;
        NextStep::Ask(self.axis.request(position_m))
    }

    fn begin(&mut self) -> anyhow::Result<NextStep> {
        self.plate
            .fit
            .as_ref()
            .context("the plate was not measured")?;
        let largest = self
            .plate
            .responses
            .iter()
            .map(|response| response.ratio.norm());
        let largest = largest.fold(f64::MIN_POSITIVE, f64::max);
        let units_per_v = largest / self.config.channels.drive.volts_per_unit;
        let highest_v =
            plate_look::highest_level_v(units_per_v, self.metres_per_unit, &self.config);
        self.level_v = LEVEL_V.min(highest_v);
        Ok(self.step())
    }

    fn settle_s(&self) -> f64 {
        self.plate.settle_s()
            + if self.instrument {
                INSTRUMENT_LAG_S
            } else {
                0.0
            }
    }

    fn play(&mut self) -> anyhow::Result<NextStep> {
        self.stage = Stage::Reading;
        let carrier_hz = self.carrier_hz();
        if self.instrument {
            return Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
                tones: ToneList::new(&[carrier_hz])?,
                dwell_s: self.settle_s() + WINDOW_S,
                amplitude_v: self.level_v,
            })));
        }
        let tone = Waveform::Tone {
            carrier_hz,
            amplitude_v: self.level_v,
        };
        let request = Request::KnownAmplitude {
            drive_v: self.level_v,
            expected_m: None,
        };
        Ok(NextStep::Sound(Box::new(tone), request))
    }

    /// Returns the amplitude `known_m` relative to the pickup's.
    fn ratio(&self, capture: &Capture, known_m: f64, settle_s: f64) -> anyhow::Result<f64> {
        let dwell = capture.dwells.first().context("no tone was played")?;
        let pickup = capture.tone(dwell, self.config.channels.pickup.index, settle_s)?;
        let ratio = known_m / (self.metres_per_unit * pickup.value.norm());
        if !(ratio.is_finite() && ratio >= 0.0) {
            bail!(
                "the pickup reads nothing at {:.0} Hz: check its cable",
                dwell.carrier_hz
            );
        }
        Ok(ratio)
    }

    /// Stores the ratio, with this relative error, at the present place.
    fn keep(&mut self, ratio: f64, relative: f64) {
        let place = ProfilePoint {
            position_m: self.places_m[self.place_index],
            ratio,
            error: relative * ratio,
        };
        match self.places.get_mut(self.place_index) {
            Some(previous) => *previous = place,
            None => self.places.push(place),
        }
        self.place_index = self.places.len();
    }

    /// Returns the cosine through the places so far; empty along the plate.
    fn fitted_curve(&self) -> Vec<(f64, f64)> {
        let fit = match self.axis {
            SurveyAxis::Along => None,
            SurveyAxis::Across { .. } => cosine::fit(&self.places),
        };
        fit.map_or_else(Vec::new, |fit| cosine::curve(&self.places, &fit))
    }

    fn take_typed(&mut self, known_m: f64, capture: &Capture) -> anyhow::Result<NextStep> {
        let most_m = self.config.calibration.max_amplitude_m;
        // On a nodal line an instrument may show nothing.
        let on_node = known_m == 0.0 && self.axis != SurveyAxis::Along;
        let known_m = if on_node { INVISIBLE_M } else { known_m };
        if !(known_m > 0.0 && known_m <= most_m) {
            self.note = Some(format!(
                "{:.4} µm is outside 0 to calibration.max_amplitude_m = {:.3} µm: type it again.",
                known_m * 1e6,
                most_m * 1e6
            ));
            return self.play();
        }
        let ratio = self.ratio(capture, known_m, 0.0)?;
        if let Some(why) = self.axis.unusable(ratio) {
            self.note = Some(format!("{why}: look where it aims, and type it again."));
            return self.play();
        }
        self.keep(ratio, TYPED * (TYPED_RATIO / ratio).max(1.0));
        Ok(self.step())
    }
}

/// Returns the mean of an instrument's readings during a steady tone, m, and its relative standard error.
fn instrument(capture: &Capture, settle_s: f64) -> anyhow::Result<(f64, f64)> {
    let dwell = capture.dwells.first().context("no tone was played")?;
    let window = capture.settled(dwell, settle_s);
    let (mean, error) = instrument_mean(capture, &window).map_err(too_few)?;
    // On a nodal line noise may make the mean negative or zero.
    let mean = mean.abs().max(INVISIBLE_M);
    // An instrument with rounded output can send the same number throughout.
    Ok((mean, (error / mean).abs().max(1e-5)))
}

impl Procedure for ProfileProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        self.note = None;
        match (self.stage, outcome) {
            (Stage::Plate, outcome) => match self.plate.next(outcome)? {
                NextStep::Done => self.begin(),
                step => Ok(step),
            },
            (Stage::Moving, StepOutcome::Answered(Answer::Ready, _)) => self.play(),
            (Stage::Reading, StepOutcome::Captured(capture)) => {
                let settle_s = self.settle_s();
                let (known_m, relative) = instrument(&capture, settle_s)?;
                let ratio = self.ratio(&capture, known_m, settle_s)?;
                if let Some(why) = self.axis.unusable(ratio) {
                    bail!("{why}: look where it aims, at its scale and at the pickup");
                }
                self.keep(ratio, relative);
                Ok(self.step())
            }
            (Stage::Reading, StepOutcome::Answered(Answer::Number(known_m), capture)) => {
                self.take_typed(known_m, &capture)
            }
            (Stage::Reading | Stage::Review, StepOutcome::Answered(Answer::Redo(place), _)) => {
                self.place_index = place.min(self.places.len());
                Ok(self.step())
            }
            (Stage::Review, StepOutcome::Answered(Answer::Ready, _)) | (Stage::Done, _) => {
                self.stage = Stage::Done;
                Ok(NextStep::Done)
            }
            (Stage::Reading, _) => self.play(),
            (Stage::Moving | Stage::Review, _) => Ok(self.step()),
        }
    }

    fn progress(&self) -> CalibrationProgress {
        let plate = self.plate.progress();
        let steps = plate.steps + self.places_m.len();
        if self.stage == Stage::Plate {
            return CalibrationProgress { steps, ..plate };
        }
        CalibrationProgress {
            step: plate.steps + (self.place_index + 1).min(self.places_m.len()),
            steps,
            doing: format!(
                "Driving at {:.2} V and {:.1} Hz.",
                self.level_v,
                self.carrier_hz()
            ),
            note: self.note.clone(),
            points: self.places.iter().map(read).collect(),
            curve: Some(Curve {
                x: self.axis.label().to_owned(),
                y: "over the pickup's".to_owned(),
                points: self
                    .places
                    .iter()
                    .map(|place| (1e3 * place.position_m, place.ratio))
                    .collect(),
                fit: self.fitted_curve(),
            }),
            findings: plate.findings,
            rejected: false,
        }
    }
}

fn read(place: &ProfilePoint) -> PointRead {
    PointRead {
        place: format!("{:.1} mm", 1e3 * place.position_m),
        value: statistics::with_error(place.ratio, place.error, 5),
        ..PointRead::default()
    }
}
