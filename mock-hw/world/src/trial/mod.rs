//! A trial of the published protocol without a bench: a person on a driven plate, recorded as samples with their truth.
//!
//! `mock-hw` shows the same plate and person to a bench, which controls them through its interfaces. Here a script does: unloaded
//! plate, countdown, strokes in alternating directions with the mean force shown after each, unloaded plate.

mod course;
mod plan;
mod readings;
mod script;
mod stated;

pub use plan::{DURATION_S, RATE_HZ, STROKES, TrialPlan};
pub use readings::{SensorReadings, Stroke, TrialRecording};
pub use stated::StatedConstants;

use std::f64::consts::TAU;

use strict_toml::OutOfRange;

use crate::fingertip::Fingertip;
use crate::person::VirtualPerson;
use crate::plant::Plant;
use crate::scenario::Scenario;
use script::Script;

/// Periods of the simulation per second.
const PERIODS_PER_S: f64 = 1_000.0;
/// Length of the ramp at the start of the drive, s.
const RAMP_S: f64 = 0.05;
/// Input channels that a trial records: read-back of the drive, and pickup.
const DRIVE: usize = 0;
const PICKUP: usize = 1;

/// A trial in progress.
///
/// ```
/// use mock_world::scenario::built_in;
/// use mock_world::trial::{Trial, TrialPlan};
///
/// let steady = built_in("steady")?;
/// let plan = TrialPlan { rate_hz: 96_000, strokes: 1, ..TrialPlan::default() };
/// let mut trial = Trial::new(&steady, &plan, 1, 1)?;
/// while trial.advance() {}
/// let recording = trial.finish();
/// assert_eq!(recording.strokes.len(), 1);
/// assert!(recording.truth.iter().any(|truth| truth.gap_m > 10e-6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Trial {
    plan: TrialPlan,
    plant: Plant,
    person: VirtualPerson,
    script: Script,
    /// Actuator volts per generator unit.
    volts_per_unit: f64,
    counts_per_m: f64,
    drive: Vec<f32>,
    inputs: Vec<f32>,
    periods: u64,
    recording: TrialRecording,
}

impl Trial {
    /// Begins a trial of the person of `participant_seed` on the bench of `seed`.
    ///
    /// # Errors
    /// A value of the plan that this scenario's bench cannot produce.
    pub fn new(
        scenario: &Scenario,
        plan: &TrialPlan,
        seed: u64,
        participant_seed: u64,
    ) -> Result<Self, OutOfRange> {
        plan.check(scenario)?;
        let rate_hz = f64::from(plan.rate_hz);
        let skin = Fingertip::draw(scenario, participant_seed);
        let plant = Plant::with_fingertip(scenario, skin, seed, rate_hz);
        let frames = (rate_hz / PERIODS_PER_S).round() as usize;
        let constants = plant.constants();
        let uncalibrated = Scenario::default();
        let assumed = if plan.calibrated {
            &constants.scenario
        } else {
            &uncalibrated
        };
        let stated = StatedConstants::new(assumed, rate_hz);
        Ok(Self {
            person: VirtualPerson::draw(&scenario.participant, participant_seed),
            script: Script::new(plan),
            volts_per_unit: scenario.amplifier.volts_per_unit,
            counts_per_m: scenario.encoder.counts_per_m,
            drive: vec![0.0; frames],
            inputs: vec![0.0; frames * plant.channels()],
            periods: 0,
            recording: TrialRecording::new(plan, constants, stated),
            plan: plan.clone(),
            plant,
        })
    }

    /// Simulates one period of about a millisecond; returns whether the trial continues.
    pub fn advance(&mut self) -> bool {
        let rate_hz = f64::from(self.plan.rate_hz);
        let (start_s, dt_s) = (self.elapsed_s(), self.drive.len() as f64 / rate_hz);
        let Some(percept) = self.script.percept(start_s) else {
            return false;
        };
        let act = self.person.step(start_s, dt_s, &percept);
        self.render(rate_hz);
        self.plant
            .step(&self.drive, true, &act.finger, &mut self.inputs);
        self.periods += 1;
        for frame in self.inputs.chunks_exact(self.plant.channels()) {
            self.recording.drive.push(frame[DRIVE]);
            self.recording.pickup.push(frame[PICKUP]);
        }
        let counts = (act.finger.position_m * self.counts_per_m).floor();
        self.recording
            .position
            .push(start_s + dt_s, counts / self.counts_per_m);
        self.recording.read_forces(self.plant.forces());
        self.recording.truth.extend_from_slice(self.plant.truth());
        self.script.watch(start_s + dt_s, &act);
        true
    }

    /// Returns the recorded time, s of the converter's clock.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        (self.periods * self.drive.len() as u64) as f64 / f64::from(self.plan.rate_hz)
    }

    /// Returns the time that the trial is expected to take, s.
    #[must_use]
    pub fn expected_s(&self) -> f64 {
        self.plan.expected_s().max(self.elapsed_s())
    }

    /// Returns the recording.
    #[must_use]
    pub fn finish(mut self) -> TrialRecording {
        let end_s = self.elapsed_s();
        (self.recording.unloaded_s, self.recording.strokes) = self.script.finish(end_s);
        self.recording
    }

    /// Writes the generator's samples of the next period.
    fn render(&mut self, rate_hz: f64) {
        let (plan, carrier_hz) = (&self.plan, self.recording.carrier_hz);
        let mean_level = plan.mean_amplitude_v / self.volts_per_unit;
        let first = self.periods * self.drive.len() as u64;
        for (frame, sample) in (first..).zip(&mut self.drive) {
            let t_s = frame as f64 / rate_hz;
            let ramp = 0.5 - 0.5 * (0.5 * TAU * (t_s / RAMP_S).min(1.0)).cos();
            let modulation = (TAU * (plan.modulation_hz * t_s).fract()).sin();
            let carrier = (TAU * (carrier_hz * t_s).fract()).sin();
            let envelope = mean_level * (1.0 + plan.modulation_index * modulation);
            *sample = (ramp * envelope * carrier) as f32;
        }
    }
}
