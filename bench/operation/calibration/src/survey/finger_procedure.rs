//! `calibrate plate --finger`: measures the bare plate's response, then plays the same tones with a finger resting on it.

use crate::plate_look;
use crate::plate_procedure::{PlateProcedure, WINDOW_S};
use anyhow::{Context, bail};
use calibration_rig::capture::Capture;
use calibration_rig::clear::ClearPlate;
use calibration_rig::operator::{Answer, CalibrationProgress, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;
use metrology::plate_fit::Response;
use signalgen::{ToneList, Waveform};

/// Level of the tones under the finger, V peak; lowered where a limit requires it. It moves the bare plate by about 0.5 µm,
/// which is also the amplitude that the finger feels if it leaves the plate during a tone: an eighth of the crest during
/// exploration (46.8 V), and just enough for the safety watch to detect an amplifier with half the gain.
pub const FINGER_V: f64 = 6.0;
/// Least and greatest mean normal force of the resting finger, N: about that of an exploration, and a third of
/// `safety.max_normal_n`, at which the safety watch stops the drive.
pub const FINGER_N: [f64; 2] = [0.3, 1.0];
/// Largest standard deviation of the normal force, relative to its mean.
const STEADY: f64 = 0.2;
/// Length of the silent reading of the resting finger before the plate is driven, s.
const REST_S: f64 = 0.5;
/// Number of attempts without an operator.
const TRIES: u32 = 3;

/// Procedure of `calibrate plate --finger`.
pub struct FingerProcedure {
    pub(crate) bare: ClearPlate<PlateProcedure>,
    pub(crate) config: Config,
    attended: bool,
    stage: Stage,
    tries: u32,
    note: Option<String>,
    /// Response under the finger at the tones of the bare plate; empty until measured.
    pub(crate) responses: Vec<Response>,
    /// Normal force during the tones, N.
    pub(crate) force: HeldForce,
    pub(crate) level_v: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// The bare plate is measured.
    Bare,
    /// A finger is requested.
    Placing,
    /// The finger rests; the plate is silent.
    Resting,
    /// The tones play under the finger.
    Tones,
    /// The operator is asked to lift the finger.
    Lifting,
    Done,
}

impl FingerProcedure {
    /// Creates a procedure that has not begun; `attended` if an operator is present.
    ///
    /// # Errors
    /// If the bench has no force sensor, or requires a held switch.
    pub fn new(bare: PlateProcedure, config: &Config, attended: bool) -> anyhow::Result<Self> {
        if config.force.is_none() {
            bail!(
                "--finger needs [force] in bench.toml: the force that the finger rests with is kept, and limited"
            );
        }
        if config.safety.dead_man.is_some() {
            bail!(
                "safety.dead_man is in use, but a calibration cannot watch the switch; no finger may be on a driven \
                 plate without it, so leave --finger out on this bench"
            );
        }
        Ok(Self {
            bare: ClearPlate::new(bare, config, attended),
            config: config.clone(),
            attended,
            stage: Stage::Bare,
            tries: 0,
            note: None,
            responses: Vec::new(),
            force: HeldForce::default(),
            level_v: FINGER_V,
        })
    }

    /// Requests a finger.
    pub(crate) fn ask(&mut self) -> NextStep {
        self.stage = Stage::Placing;
        NextStep::Ask(Request::RestFinger {
            least_n: FINGER_N[0],
            most_n: FINGER_N[1],
        })
    }

    /// Requests a finger again, or fails if no operator is present.
    fn ask_again(&mut self, why: String) -> anyhow::Result<NextStep> {
        self.tries += 1;
        if !self.attended && self.tries >= TRIES {
            bail!("the finger did not rest as it must, {TRIES} times: {why}");
        }
        self.note = Some(why);
        Ok(self.ask())
    }

    /// Returns the step that plays the bare plate's tones under the finger.
    fn tones(&mut self) -> anyhow::Result<NextStep> {
        let bare = self.bare.inner();
        let largest = bare.responses.iter().map(|response| response.ratio.norm());
        let largest = largest.fold(f64::MIN_POSITIVE, f64::max);
        let units_per_v = largest / self.config.channels.drive.volts_per_unit;
        let metres_per_unit = self.config.channels.pickup.metres_per_unit;
        let highest_v = plate_look::highest_level_v(units_per_v, metres_per_unit, &self.config);
        self.level_v = FINGER_V.min(highest_v);
        let tones: Vec<f64> = bare
            .responses
            .iter()
            .map(|response| response.frequency_hz)
            .collect();
        self.stage = Stage::Tones;
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(&tones)?,
            dwell_s: bare.settle_s() + WINDOW_S,
            amplitude_v: self.level_v,
        })))
    }

    fn read(&mut self, capture: &Capture) -> anyhow::Result<NextStep> {
        if let Some(why) = restless(capture) {
            return self.ask_again(why);
        }
        let settle_s = self.bare.inner().settle_s();
        self.responses = plate_look::responses(capture, &self.config, settle_s)?;
        self.force = HeldForce::from_readings(&capture.normal_n);
        self.stage = Stage::Lifting;
        Ok(NextStep::Ask(Request::Unload))
    }
}

/// Normal force of a resting finger.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct HeldForce {
    /// Mean, N.
    pub mean_n: f64,
    /// Standard deviation, N.
    pub spread_n: f64,
    /// Standard error of the mean, N.
    pub error_n: f64,
    /// Degrees of freedom of the error.
    pub degrees_of_freedom: usize,
}

impl HeldForce {
    /// Returns the statistics of `readings_n`. Force wanders and trembles, so neighbouring readings are correlated: the error
    /// is that of the means of pieces.
    fn from_readings(readings_n: &[f64]) -> Self {
        const PIECES: usize = 10;
        let (mean_n, spread_n) = mean_and_deviation(readings_n);
        let pieces = readings_n.chunks(readings_n.len().div_ceil(PIECES).max(1));
        let means: Vec<f64> = pieces.map(|piece| mean_and_deviation(piece).0).collect();
        let degrees_of_freedom = means.len().saturating_sub(1);
        Self {
            mean_n,
            spread_n,
            error_n: mean_and_deviation(&means).1 / (degrees_of_freedom.max(1) as f64).sqrt(),
            degrees_of_freedom,
        }
    }
}

/// Returns mean and standard deviation; NaN without values.
fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / n).sqrt())
}

/// Returns the reason why the finger of a capture did not rest as required; `None` if it did.
fn restless(capture: &Capture) -> Option<String> {
    let (mean_n, deviation_n) = mean_and_deviation(&capture.normal_n);
    let [least_n, most_n] = FINGER_N;
    if !(mean_n >= least_n && mean_n <= most_n) {
        return Some(format!(
            "the finger pressed with {mean_n:.2} N, not with {least_n} to {most_n} N"
        ));
    }
    (deviation_n > STEADY * mean_n).then(|| {
        format!(
            "the finger's force of {mean_n:.2} N changed by ± {deviation_n:.2} N: rest the hand, and keep it still"
        )
    })
}

impl Procedure for FingerProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        match (self.stage, outcome) {
            (Stage::Bare, outcome) => match self.bare.next(outcome)? {
                NextStep::Done => {
                    let fit = self.bare.inner().fit.as_ref();
                    fit.context("the plate was not measured")?;
                    Ok(self.ask())
                }
                step => Ok(step),
            },
            (Stage::Placing, StepOutcome::Answered(Answer::Ready, _)) => {
                self.stage = Stage::Resting;
                Ok(NextStep::Listen(REST_S))
            }
            (Stage::Resting, StepOutcome::Captured(capture)) => match restless(&capture) {
                Some(why) => self.ask_again(why),
                None => {
                    self.note = None;
                    self.tones()
                }
            },
            (Stage::Tones, StepOutcome::Captured(capture)) => self.read(&capture),
            (Stage::Lifting, StepOutcome::Answered(Answer::Ready, _)) => {
                self.stage = Stage::Done;
                Ok(NextStep::Done)
            }
            (Stage::Lifting, _) => Ok(NextStep::Ask(Request::Unload)),
            (Stage::Done, _) => Ok(NextStep::Done),
            _ => Ok(self.ask()),
        }
    }

    fn progress(&self) -> CalibrationProgress {
        let bare = self.bare.progress();
        let step = bare.steps + 1;
        let steps = step;
        let doing = match self.stage {
            Stage::Bare => return CalibrationProgress { steps, ..bare },
            Stage::Placing | Stage::Resting => {
                "Reading the force of the resting finger.".to_owned()
            }
            Stage::Tones | Stage::Lifting | Stage::Done => format!(
                "Playing {} tones under the finger at {:.1} V.",
                self.bare.inner().responses.len(),
                self.level_v
            ),
        };
        CalibrationProgress {
            step,
            steps,
            doing,
            note: self.note.clone(),
            ..bare
        }
    }
}
