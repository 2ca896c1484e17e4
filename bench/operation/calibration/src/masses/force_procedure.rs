//! Steps of `calibrate force`: each mass is requested, read at rest and checked for plausibility. If an operator is present, a
//! missing, swinging or wrong mass is requested again; crossed wires end the measurement.

use anyhow::bail;
use metrology::crosstalk::{Crosstalk, Loading};

use crate::masses::common::{AXES, LEAST_SIGMA_N, TARE_WINDOWS};
use crate::masses::force_setup::{ForceSetup, require_enough};
use crate::masses::mass::Mass;
use crate::masses::plateau::{Plateau, WINDOW_S};
use calibration_rig::capture::Capture;
use calibration_rig::operator::{
    Answer, CalibrationProgress, ForceAxis, PointRead, Request, grams,
};
use calibration_rig::points::signed;
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::Correction;
use safety::SENSITIVITY;
use sources::channels::Fading;

/// Number of windows without rest after which the wait ends.
const MOST_WINDOWS: usize = 20;
/// Least change of the reading under a mass, relative to its weight.
const LEAST_CHANGE: f64 = 0.1;
/// Least change of the reading under a mass, in standard errors.
const LEAST_SIGMAS: f64 = 5.0;
/// Reading per newton, relative to that of a lighter mass, below which a heavier mass has reached the end of the range.
const STRAIGHT: f64 = 0.8;
/// Fraction of its weight below which a mass counts as removed.
const LEFT_BEHIND: f64 = 0.3;

#[derive(Debug, Clone, Copy, PartialEq)]
enum ForceStage {
    Begin,
    Naming(ForceAxis),
    Clearing,
    Taring,
    Loading(usize),
    Resting(usize),
    Unloading(usize),
    Returning(usize),
    Reviewing,
}

/// Reason for rejecting a reading.
enum Refusal {
    /// The operator can correct it: the request is repeated.
    Slip(String),
    /// The wiring is wrong: earlier readings are invalid too, and the measurement ends.
    Ends(String),
}

impl Refusal {
    fn into_words(self) -> String {
        match self {
            Self::Slip(why) | Self::Ends(why) => why,
        }
    }
}

/// Procedure of `calibrate force`.
pub struct ForceProcedure {
    pub(super) setup: ForceSetup,
    /// Whether an operator can repeat a step.
    attended: bool,
    stage: ForceStage,
    /// Reason for repeating a request.
    note: Option<String>,
    /// Number of windows of this stage so far.
    windows: usize,
    /// Windows at rest to average for the first zero.
    taring: Vec<Plateau>,
    /// Readings under the present load, to detect a capacitor in the signal path.
    fading: Option<Fading>,
    /// Readings without load, in time order.
    pub(super) zeros: Vec<Plateau>,
    /// Reading under each mass; `None` until it is read.
    pub(super) loads: Vec<Option<Plateau>>,
}

/// Interpolated zero at the time of a reading.
struct Zero {
    mean: [f64; 2],
    /// Standard error from those of the zeros before and after, N.
    error: [f64; 2],
    /// Variance of a random walk about the straight line between the two zeros, over its variance per second (Brownian bridge),
    /// s.
    bridge_s: f64,
}

impl ForceProcedure {
    /// Creates a procedure that has not begun; `attended` if an operator can repeat a step.
    #[must_use]
    pub fn new(setup: ForceSetup, attended: bool) -> Self {
        Self {
            loads: vec![None; setup.masses.len()],
            setup,
            attended,
            stage: ForceStage::Begin,
            note: None,
            windows: 0,
            taring: Vec::new(),
            fading: None,
            zeros: Vec::new(),
        }
    }

    fn listen(&mut self, stage: ForceStage) -> NextStep {
        self.stage = stage;
        self.windows = 0;
        NextStep::Listen(WINDOW_S)
    }

    fn ask(&mut self, stage: ForceStage, request: Request) -> NextStep {
        self.stage = stage;
        NextStep::Ask(request)
    }

    fn begin(&mut self) -> NextStep {
        if self.setup.masses.is_empty() && self.setup.kept.is_none() {
            return self.name(ForceAxis::Normal);
        }
        self.ask(ForceStage::Clearing, Request::Unload)
    }

    fn name(&mut self, axis: ForceAxis) -> NextStep {
        self.ask(ForceStage::Naming(axis), Request::NameMass { axis })
    }

    /// Handles an answer that lists the masses available for `axis`.
    fn take_mass(&mut self, axis: ForceAxis, answer: Answer) -> NextStep {
        match answer {
            Answer::Number(mass_kg) => {
                let mass = Mass {
                    axis,
                    mass_kg,
                    sigma_kg: 0.0,
                };
                match self.setup.require(&mass) {
                    Ok(()) => self.setup.masses.push(mass),
                    Err(why) => self.note = Some(why.to_string()),
                }
            }
            Answer::Redo(i) => {
                if i < self.setup.masses.len() {
                    self.setup.masses.remove(i);
                }
            }
            Answer::Ready => return self.all_named(axis),
        }
        self.name(axis)
    }

    fn all_named(&mut self, axis: ForceAxis) -> NextStep {
        let setup = &mut self.setup;
        if axis == ForceAxis::Lateral
            && setup
                .masses
                .iter()
                .all(|mass| mass.axis == ForceAxis::Normal)
        {
            let copies = setup.masses.iter().map(|mass| Mass { axis, ..*mass });
            let copies: Vec<_> = copies.filter(|mass| setup.require(mass).is_ok()).collect();
            setup.masses.extend(copies);
        }
        let short = AXES
            .into_iter()
            .take(1 + axis.index())
            .find_map(|axis| Some((axis, require_enough(&setup.masses, axis).err()?)));
        match (short, axis) {
            (Some((axis, why)), _) => {
                self.note = Some(why.to_string());
                self.name(axis)
            }
            (None, ForceAxis::Normal) => self.name(ForceAxis::Lateral),
            (None, ForceAxis::Lateral) => {
                self.loads = vec![None; self.setup.masses.len()];
                self.begin()
            }
        }
    }

    /// Repeats the request of the present reading if an operator is present; otherwise ends the measurement.
    fn ask_again(&mut self, refusal: Refusal) -> anyhow::Result<NextStep> {
        let why = match refusal {
            Refusal::Slip(why) if self.attended => why,
            refusal => bail!(refusal.into_words()),
        };
        self.note = Some(format!("{why}. This reading is rejected."));
        Ok(match self.stage {
            ForceStage::Resting(i) => self.load(i),
            ForceStage::Returning(i) => self.ask(ForceStage::Unloading(i), Request::Unload),
            _ => self.ask(ForceStage::Clearing, Request::Unload),
        })
    }

    /// Requests mass `i`, or the review after the last mass.
    fn load(&mut self, i: usize) -> NextStep {
        match self.setup.masses.get(i) {
            Some(&Mass { axis, mass_kg, .. }) => {
                self.ask(ForceStage::Loading(i), Request::Load { axis, mass_kg })
            }
            None if self.setup.masses.is_empty() => NextStep::Done,
            None => self.ask(ForceStage::Reviewing, Request::Review),
        }
    }

    /// Returns the index of the first mass not yet read, or the number of masses if all have been.
    fn missing(&self) -> usize {
        let missing = self.loads.iter().position(Option::is_none);
        missing.unwrap_or(self.loads.len())
    }

    fn after_capture(&mut self, capture: &Capture) -> anyhow::Result<NextStep> {
        self.windows += 1;
        let doing = self.doing();
        require_in_range(capture, &doing)?;
        let rest_n = self.setup.config.calibration.force_rest_n;
        let plateau = Plateau::read(capture)?;
        if let (Some(fading), ForceStage::Resting(i)) = (&mut self.fading, self.stage) {
            fading.window(capture.force_n(self.setup.masses[i].axis.index()));
        }
        if !plateau.at_rest(rest_n) {
            if self.windows >= MOST_WINDOWS {
                if let Some(why) = self.coupled() {
                    return self.ask_again(Refusal::Slip(why));
                }
                let remedy = match self.stage {
                    ForceStage::Resting(_) => {
                        "let the mass hang still, keep hands and draughts off"
                    }
                    _ => "let the sensor warm up until it drifts less, keep hands and draughts off",
                };
                return self.ask_again(Refusal::Slip(format!(
                    "the reading does not come to rest in {:.0} s while {doing}: it still moves by {:.2} mN; {remedy}, or raise calibration.force_rest_n = {rest_n} N",
                    MOST_WINDOWS as f64 * WINDOW_S,
                    1e3 * plateau.scatter.into_iter().fold(0.0, f64::max)
                )));
            }
            if self.stage == ForceStage::Taring {
                self.taring.clear();
            }
            return Ok(NextStep::Listen(WINDOW_S));
        }
        match self.stage {
            ForceStage::Taring => {
                self.taring.push(plateau);
                if self.taring.len() < TARE_WINDOWS {
                    return Ok(NextStep::Listen(WINDOW_S));
                }
                let zero = Plateau::mean_of(&self.taring);
                self.require_tare(&zero)?;
                self.zeros.push(zero);
                Ok(self.load(self.missing()))
            }
            ForceStage::Resting(i) => {
                if let Err(refusal) = self.require_load(i, &plateau) {
                    return self.ask_again(self.coupled().map_or(refusal, Refusal::Slip));
                }
                self.loads[i] = Some(plateau);
                Ok(self.ask(ForceStage::Unloading(i), Request::Unload))
            }
            ForceStage::Returning(i) => {
                if let Err(refusal) = self.require_return(i, &plateau) {
                    return self.ask_again(refusal);
                }
                self.zeros.push(plateau);
                Ok(self.load(self.missing()))
            }
            _ => bail!("no capture was requested in this stage"),
        }
    }

    fn require_tare(&self, zero: &Plateau) -> anyhow::Result<()> {
        let tare = Correction {
            tare_n: zero.mean,
            ..Correction::default()
        };
        Ok(tare.require_plausible(self.setup.config.safety.max_forces_n())?)
    }

    fn change(&self, plateau: &Plateau) -> [f64; 2] {
        let zero = self.zeros.last().map_or([0.0; 2], |zero| zero.mean);
        [0, 1].map(|axis| plateau.mean[axis] - zero[axis])
    }

    /// Requires that the reading under mass `i` is plausible.
    fn require_load(&self, i: usize, plateau: &Plateau) -> Result<(), Refusal> {
        let Mass { axis, mass_kg, .. } = self.setup.masses[i];
        let (row, other_row) = (axis.index(), 1 - axis.index());
        let grams = grams(mass_kg);
        let (axis, weight_n) = (axis.name(), self.setup.weight_n(mass_kg));
        let change = self.change(plateau);
        let least_n = (LEAST_CHANGE * weight_n).max(LEAST_SIGMAS * plateau.error[row]);
        if change[row].abs() < least_n {
            if change[other_row].abs() > 2.0 * least_n {
                return Err(Refusal::Ends(format!(
                    "{grams} g on the {axis} axis changed the {} axis by {:.3} N and the {axis} axis by {:.3} N: the axes are exchanged; exchange their wires, or put the mass where it was asked for",
                    AXES[other_row].name(),
                    change[other_row],
                    change[row]
                )));
            }
            return Err(Refusal::Slip(format!(
                "{grams} g on the {axis} axis changed the reading by {:.1} mN, {:.0} mN were expected: check that it was placed and that nothing else carries it",
                1e3 * change[row],
                1e3 * weight_n
            )));
        }
        if change[row] < 0.0 {
            let remedy = if row == 0 {
                "pressing must read positive: exchange the wires of the normal axis or its sign in the sensor"
            } else {
                "the thread must pull towards increasing position: hang the mass on the other side, or exchange the wires of the lateral axis"
            };
            return Err(Refusal::Ends(format!(
                "the {axis} axis has the wrong sign: {grams} g changed it by {:.3} N; {remedy}",
                change[row]
            )));
        }
        let gain = change[row] / weight_n;
        let [low, high] = SENSITIVITY;
        if !(low..=high).contains(&gain.recip()) {
            return Err(Refusal::Slip(format!(
                "{grams} g on the {axis} axis read {:.3} N instead of {weight_n:.3} N: check that the mass is {grams} g and that the sensor sends newtons in the format of force.protocol",
                change[row]
            )));
        }
        let lighter = self.gains(AXES[row], mass_kg);
        if let Some(lighter_gain) = lighter
            && gain < STRAIGHT * lighter_gain
        {
            return Err(Refusal::Slip(format!(
                "{grams} g read {gain:.3} N per newton where a lighter mass read {lighter_gain:.3}: the range of the {axis} axis is exceeded, or the mass touches something; use lighter masses",
            )));
        }
        Ok(())
    }

    /// Returns the reason why the reading under the present load decays, if it does.
    fn coupled(&self) -> Option<String> {
        let (Some(fading), ForceStage::Resting(i)) = (&self.fading, self.stage) else {
            return None;
        };
        let Mass { axis, mass_kg, .. } = self.setup.masses[i];
        let [most_n, last_n] = fading.faded(self.setup.weight_n(mass_kg))?;
        Some(format!(
            "{} g on the {} axis read up to {most_n:.3} N, which faded to {last_n:.3} N while they lay there: the inputs are \
             AC-coupled and cannot read a constant force; take DC-coupled ones (force.channels.inputs in bench.toml)",
            grams(mass_kg),
            axis.name()
        ))
    }

    /// Returns the reading per newton of the lightest mass on `axis` below `than_kg`; `None` if no such mass was read.
    fn gains(&self, axis: ForceAxis, than_kg: f64) -> Option<f64> {
        let masses = self.setup.masses.iter().zip(&self.loads);
        masses
            .filter(|(mass, _)| mass.axis == axis && mass.mass_kg < than_kg)
            .filter_map(|(mass, load)| {
                let load = load.as_ref()?;
                let change_n =
                    load.mean[axis.index()] - self.zero_at(load.at_s)?.mean[axis.index()];
                Some((mass.mass_kg, change_n / self.setup.weight_n(mass.mass_kg)))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, gain)| gain)
    }

    fn require_return(&self, i: usize, plateau: &Plateau) -> Result<(), Refusal> {
        let Mass { axis, mass_kg, .. } = self.setup.masses[i];
        let left_n = self.change(plateau)[axis.index()];
        let weight_n = self.setup.weight_n(mass_kg);
        if left_n.abs() > LEFT_BEHIND * weight_n {
            return Err(Refusal::Slip(format!(
                "the {} axis still reads {left_n:.3} N more than before {} g were placed: remove the mass and its thread",
                axis.name(),
                grams(mass_kg)
            )));
        }
        Ok(())
    }

    /// Returns the zero at a time, interpolated between the zeros measured before and after.
    fn zero_at(&self, at_s: f64) -> Option<Zero> {
        let next_index = self.zeros.partition_point(|zero| zero.at_s <= at_s);
        let previous = self.zeros.get(next_index.checked_sub(1)?)?;
        let Some(next) = self.zeros.get(next_index) else {
            return Some(Zero {
                mean: previous.mean,
                error: previous.error,
                bridge_s: 0.0,
            });
        };
        let span_s = next.at_s - previous.at_s;
        let share = (at_s - previous.at_s) / span_s;
        Some(Zero {
            mean: [0, 1].map(|k| previous.mean[k] + share * (next.mean[k] - previous.mean[k])),
            error: [0, 1].map(|k| ((1.0 - share) * previous.error[k]).hypot(share * next.error[k])),
            bridge_s: share * (1.0 - share) * span_s,
        })
    }

    /// Returns the variance per second of the zero's random walk about its steady drift, N²/s: from the steps between zeros,
    /// less their noise.
    fn wander_n2_per_s(&self, axis: usize) -> f64 {
        let [first, .., last] = &self.zeros[..] else {
            return 0.0;
        };
        let whole_s = last.at_s - first.at_s;
        let slope = (last.mean[axis] - first.mean[axis]) / whole_s;
        let (mut squares, mut free_s) = (0.0, whole_s);
        for pair in self.zeros.windows(2) {
            let step_s = pair[1].at_s - pair[0].at_s;
            let step_n = pair[1].mean[axis] - pair[0].mean[axis] - slope * step_s;
            let noise_n = pair[0].error[axis].hypot(pair[1].error[axis]);
            squares += step_n * step_n - noise_n * noise_n;
            // The drift was fitted to the same zeros.
            free_s -= step_s * step_s / whole_s;
        }
        if free_s > 0.0 {
            (squares / free_s).max(0.0)
        } else {
            0.0
        }
    }

    /// Returns all masses read so far, as input of the fit.
    pub(super) fn loadings(&self) -> Vec<Loading> {
        let wander = [0, 1].map(|axis| self.wander_n2_per_s(axis));
        let masses = self.setup.masses.iter().zip(&self.loads);
        masses
            .filter_map(|(mass, load)| {
                let load = load.as_ref()?;
                let zero = self.zero_at(load.at_s)?;
                let mut force_n = [0.0; 2];
                force_n[mass.axis.index()] = self.setup.weight_n(mass.mass_kg);
                let reading = [0, 1].map(|k| load.mean[k] - zero.mean[k]);
                let mass_error = mass.sigma_kg / mass.mass_kg;
                let sigma = [0, 1].map(|k| {
                    load.error[k]
                        .hypot(zero.error[k])
                        .hypot((wander[k] * zero.bridge_s).sqrt())
                        .hypot(mass_error * reading[k])
                        .max(LEAST_SIGMA_N)
                });
                Some(Loading {
                    force_n,
                    reading,
                    sigma,
                })
            })
            .collect()
    }

    fn doing(&self) -> String {
        let mass = |i: usize| {
            let Mass { axis, mass_kg, .. } = self.setup.masses[i];
            format!("{} g on the {} axis", grams(mass_kg), axis.name())
        };
        match self.stage {
            ForceStage::Naming(axis) => format!("naming the masses of the {} axis", axis.name()),
            ForceStage::Begin | ForceStage::Clearing => "clearing the plate".to_owned(),
            ForceStage::Taring => "reading the zero".to_owned(),
            ForceStage::Loading(i) | ForceStage::Resting(i) => format!("reading {}", mass(i)),
            ForceStage::Unloading(i) | ForceStage::Returning(i) => {
                format!("reading the zero after {}", mass(i))
            }
            ForceStage::Reviewing => "looking at the masses".to_owned(),
        }
    }

    /// Returns the masses that have been named.
    fn points_named(&self) -> Vec<PointRead> {
        let point = |mass: &Mass| PointRead {
            place: format!("{} g {}", grams(mass.mass_kg), mass.axis.name()),
            value: format!("{:.3} N", self.setup.weight_n(mass.mass_kg)),
            ..PointRead::default()
        };
        self.setup.masses.iter().map(point).collect()
    }

    fn points_read(&self) -> Vec<PointRead> {
        let fit = Crosstalk::fit(&self.loadings()).ok();
        let is_complete = self.missing() == self.loads.len();
        let residuals: Vec<Option<f64>> = match fit.filter(|_| is_complete) {
            Some(fit) => fit
                .residuals_n
                .iter()
                .zip(&self.setup.masses)
                .map(|(residual, mass)| Some(residual[mass.axis.index()]))
                .collect(),
            None => vec![None; self.loads.len()],
        };
        let worst = residuals
            .iter()
            .flatten()
            .map(|residual| residual.abs())
            .fold(0.0, f64::max);
        let masses = self.setup.masses.iter().zip(&self.loads).zip(residuals);
        masses
            .filter_map(|((mass, load), residual)| {
                let load = load.as_ref()?;
                let zero = self.zero_at(load.at_s)?.mean;
                let change = [0, 1].map(|k| 1e3 * (load.mean[k] - zero[k]));
                Some(PointRead {
                    place: format!("{} g {}", grams(mass.mass_kg), mass.axis.name()),
                    value: format!("normal {:.2} mN, lateral {:.2} mN", change[0], change[1]),
                    residual: residual.map(|n| signed(1e3 * n, 2) + " mN"),
                    worst: residual.is_some_and(|n| n.abs() == worst),
                })
            })
            .collect()
    }
}

fn require_in_range(capture: &Capture, doing: &str) -> anyhow::Result<()> {
    for (axis, &count) in AXES.into_iter().zip(&capture.force_saturated) {
        if count > 0 {
            bail!(
                "the {} axis is at the end of its range while {doing}: use lighter masses, tare the sensor itself, or set its range higher",
                axis.name()
            );
        }
    }
    Ok(())
}

impl Procedure for ForceProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        self.note = None;
        match (outcome, self.stage) {
            (StepOutcome::Captured(capture), _) => self.after_capture(&capture),
            (StepOutcome::Began, _) => Ok(self.begin()),
            (StepOutcome::Answered(answer, _), ForceStage::Naming(axis)) => {
                Ok(self.take_mass(axis, answer))
            }
            (StepOutcome::Answered(..), ForceStage::Clearing) => {
                // Earlier windows belong to another unloading.
                self.taring.clear();
                Ok(self.listen(ForceStage::Taring))
            }
            (StepOutcome::Answered(_, capture), ForceStage::Loading(i)) => {
                self.fading = self.setup.on_inputs.then(|| {
                    let axis = self.setup.masses[i].axis.index();
                    let mut fading =
                        Fading::new(self.zeros.last().map_or(0.0, |zero| zero.mean[axis]));
                    fading.rise(capture.force_n(axis));
                    fading
                });
                Ok(self.listen(ForceStage::Resting(i)))
            }
            (StepOutcome::Answered(..), ForceStage::Unloading(i)) => {
                Ok(self.listen(ForceStage::Returning(i)))
            }
            (StepOutcome::Answered(Answer::Redo(i), _), ForceStage::Reviewing)
                if i < self.loads.len() =>
            {
                self.loads[i] = None;
                Ok(self.load(i))
            }
            (StepOutcome::Answered(..), _) => Ok(NextStep::Done),
        }
    }

    fn progress(&self) -> CalibrationProgress {
        if let ForceStage::Naming(_) = self.stage {
            return CalibrationProgress {
                doing: self.doing(),
                note: self.note.clone(),
                points: self.points_named(),
                ..CalibrationProgress::default()
            };
        }
        let load_count = self.loads.iter().flatten().count();
        CalibrationProgress {
            step: 1 + match self.stage {
                ForceStage::Naming(_)
                | ForceStage::Begin
                | ForceStage::Clearing
                | ForceStage::Taring => 0,
                ForceStage::Loading(_) => load_count + 1,
                ForceStage::Resting(_) => load_count + 1,
                ForceStage::Unloading(_) | ForceStage::Returning(_) | ForceStage::Reviewing => {
                    load_count
                }
            },
            steps: 1 + self.loads.len(),
            doing: self.doing(),
            note: self.note.clone(),
            points: self.points_read(),
            ..CalibrationProgress::default()
        }
    }
}
