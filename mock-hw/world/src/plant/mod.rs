//! Physics of the bench in the time domain: plate, fingertip, film, force sensor, converters.
//!
//! Input frame `n` shows the plate at true time `n / (rate·(1 + 1e-6·clock_ppm))` since the rate was set. A generator sample
//! reaches the actuators [`Plant::loop_latency_frames`] later, as through the filters of a real converter.
//!
//! Accuracy (`tests/integration/plant` and `tests.rs` of this module): Z_m from samples within 2e-5 of the harmonic solution
//! without a finger and 5e-4 with one, at 96 and 192 kHz; friction under 6 Hz modulation within 4e-4 of a run with four
//! times finer slow steps.

mod converter;
mod exposure;
mod force_sensor;
mod friction;
mod gauges;
mod heights;
mod known_masses;
mod mechanics;
mod mode_under_finger;
mod moisture;
mod patch;
mod plate_drift;
mod reconstruction;
mod reference;
mod squeeze_film;
#[cfg(test)]
mod tests;
mod touch;

use converter::{Converter, Delay, LATENCY, Tap};
use force_sensor::ForceSensor;
pub use force_sensor::SensorSample;
use gauges::GaugeBridge;
pub use gauges::MAKERS_MATRIX;
use known_masses::KnownMasses;
pub use known_masses::LoadedAxis;
use mechanics::{Modes, PlateState, Propagator, SkinContact, Tissue};
use moisture::Moisture;
pub use patch::InputWiring;
use patch::Patch;
use plate_drift::{PlateDrift, Tuning};
pub use reconstruction::kaiser_sinc;
use reconstruction::{History, Polynomial, Reconstruction, evaluate};
use reference::VibrometerOutput;
use touch::Touch;

use crate::fingertip::Fingertip;
use crate::person::FingerState;
use crate::run_truth::{TruthConstants, TruthSample};
use crate::scenario::{FIRST_GAUGE, ForceInterface, REFERENCE_INPUT, Scenario};

/// Sum of squared voltages across the actuators.
#[derive(Debug, Clone, Copy, Default)]
pub struct SquaredVolts {
    /// The sum, V².
    pub sum_v2: f64,
    /// Number of frames over which they were summed.
    pub frames: u32,
}

/// Period of the updates of film, friction and forces, s.
const SLOW_STEP_S: f64 = 1e-4;
/// Time constant of each of the two first-order averages of the squared surface motion, s.
const MEAN_SQUARE_S: f64 = 1e-4;
/// Time constant of the amplifier's output stage when it opens and closes, s.
const GATE_S: f64 = 50e-6;
/// Force below which the finger counts as off the plate, N.
const LEAST_CONTACT_N: f64 = 1e-3;
/// Static stiffness of the tissue, N/m, which keeps the skin in place; its reactance at the carrier is 0.01 N·s/m.
const TISSUE_STIFFNESS_N_PER_M: f64 = 2e3;
/// Mean square motion below which it is set to zero before it decays into denormal numbers, m².
const INVISIBLE_M2: f64 = 1e-50;
/// Period of the truth samples, s.
const TRUTH_STEP_S: f64 = 1e-3;

/// The simulated apparatus without its interfaces.
///
/// ```
/// use mock_world::person::FingerState;
/// use mock_world::plant::Plant;
/// use mock_world::scenario::Scenario;
///
/// let mut plant = Plant::new(&Scenario::default(), 1, 192e3);
/// let drive: Vec<f32> = (0..1_920)
///     .map(|n| (0.3 * (std::f64::consts::TAU * 35e3 * f64::from(n) / 192e3).sin()) as f32)
///     .collect();
/// let mut inputs = vec![0.0; drive.len() * plant.channels()];
/// plant.step(&drive, true, &FingerState::default(), &mut inputs);
/// let pickup = inputs.iter().skip(1).step_by(plant.channels());
/// assert!(pickup.copied().fold(0.0, f32::max) > 0.1);
/// ```
#[derive(Debug, Clone)]
pub struct Plant {
    scenario: Scenario,
    fingertip: Fingertip,
    interval_s: f64,
    omega_rad_per_s: f64,

    history: History,
    amplifier: Reconstruction,
    line_weights: Vec<f64>,
    gate: f64,
    gate_rate: f64,
    /// Gain of the amplifier relative to the scenario's.
    amplifier_gain: f64,
    readback_moment: f64,
    delays: [Delay; 3],
    patch: Patch,
    /// Voltages at the inputs in the present frame, before conversion.
    ideal: Vec<f64>,
    converter: Converter,

    propagator: Propagator,
    state: PlateState,
    mean_square: [f64; 2],
    mean_square_rate: f64,

    moisture: Moisture,
    finger: FingerState,
    touch: Touch,
    drift: PlateDrift,
    /// Tuning of the plate in use by the propagator.
    tuning: Tuning,
    force_sensor: ForceSensor,
    /// `None` if no gauge is on the sound card.
    gauges: Option<GaugeBridge>,
    /// `None` if no vibrometer is on the sound card.
    reference: Option<VibrometerOutput>,
    masses: KnownMasses,
    /// Squared voltage across the actuators during the last step.
    volts: SquaredVolts,

    seed: u64,
    /// True time of frame 0 at the present rate, s.
    epoch_s: f64,
    frame: u64,
    frames_per_slow_step: u32,
    until_slow_step: u32,
    forces: Vec<SensorSample>,
    /// Number of samples in `forces` that are complete at the end of the last step.
    forces_due: usize,
    truth: Vec<TruthSample>,
    next_truth_s: f64,
}

impl Plant {
    /// Builds the apparatus of `scenario` drawn from `seed`, with the fingertip of the same seed.
    ///
    /// It runs at `rate_hz` audio frames per second of its clock.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64, rate_hz: f64) -> Self {
        let fingertip = Fingertip::draw(scenario, seed);
        Self::with_fingertip(scenario, fingertip, seed, rate_hz)
    }

    /// Builds the apparatus of `scenario` drawn from `seed`, with a given fingertip.
    #[must_use]
    pub fn with_fingertip(
        scenario: &Scenario,
        fingertip: Fingertip,
        seed: u64,
        rate_hz: f64,
    ) -> Self {
        Self::build(scenario.draw(seed), fingertip, seed, rate_hz, SLOW_STEP_S)
    }

    /// Changes the audio frame rate and the delay of each channel, samples, as if the card were reopened: skin, finger, sensor
    /// and time continue, the plate comes to rest.
    pub fn set_rate(&mut self, rate_hz: f64, skew_samples: Vec<f64>) {
        self.scenario.converter.skew_samples = skew_samples;
        let fresh = Self::build(
            self.scenario.clone(),
            self.fingertip,
            self.seed,
            rate_hz,
            SLOW_STEP_S,
        );
        let previous = std::mem::replace(self, fresh);
        self.wire(previous.patch.wiring());
        self.epoch_s = previous.end_s();
        self.forces = previous.forces;
        self.forces_due = previous.forces_due;
        self.moisture = previous.moisture;
        self.finger = previous.finger;
        self.touch = previous.touch;
        self.drift = previous.drift;
        self.force_sensor = previous.force_sensor;
        self.masses = previous.masses;
        self.next_truth_s = previous.next_truth_s;
        self.gauges = bridge(&self.scenario, self.interval_s, self.epoch_s, self.seed);
    }

    fn build(
        scenario: Scenario,
        fingertip: Fingertip,
        seed: u64,
        rate_hz: f64,
        slow_step_s: f64,
    ) -> Self {
        let interval_s = 1.0 / (rate_hz * (1.0 + scenario.converter.clock_ppm * 1e-6));
        let omega_rad_per_s = scenario.plate.omega_rad_per_s();
        let amplifier =
            Reconstruction::dac_and_amplifier(scenario.amplifier.bandwidth_hz, 1.0 / interval_s);
        let pickup_delay = scenario.pickup.phase_rad / omega_rad_per_s / interval_s;
        let skew = |channel| scenario.converter.skew(channel);
        let taps = [
            Tap::new(skew(0)),
            Tap::new(skew(1) - pickup_delay),
            Tap::new(skew(2)),
        ];
        let mut line_weights = Reconstruction::dac().taps_at(taps[2].moment);
        line_weights.resize(amplifier.taps(), 0.0);
        let frames_per_slow_step = (slow_step_s / interval_s).round().max(1.0) as u32;
        let mut propagator =
            Propagator::new(Modes::new(&scenario.plate), interval_s, taps[1].moment);
        propagator.set(
            SkinContact::default(),
            tissue(fingertip.z_t_n_s_per_m, omega_rad_per_s),
        );
        Self {
            history: History::new(amplifier.taps()),
            amplifier,
            line_weights,
            gate: 0.0,
            amplifier_gain: 1.0,
            gate_rate: 1.0 - (-interval_s / GATE_S).exp(),
            readback_moment: taps[0].moment,
            delays: taps.map(Delay::new),
            patch: Patch::new(&scenario.converter),
            ideal: vec![0.0; scenario.converter.channels],
            converter: Converter::new(&scenario.converter, rate_hz, seed),
            propagator,
            state: PlateState::default(),
            mean_square: [0.0; 2],
            mean_square_rate: 1.0 - (-interval_s / MEAN_SQUARE_S).exp(),
            moisture: Moisture::new(&scenario.participant.moisture, seed),
            finger: FingerState::default(),
            touch: Touch::new(&scenario, &fingertip),
            drift: PlateDrift::new(&scenario.plate.drift),
            tuning: Tuning::default(),
            force_sensor: ForceSensor::new(&scenario.force_sensor, 0.0, seed),
            gauges: bridge(&scenario, interval_s, 0.0, seed),
            reference: VibrometerOutput::new(&scenario, interval_s, seed),
            masses: KnownMasses::new(&scenario.masses, seed),
            volts: SquaredVolts::default(),
            seed,
            epoch_s: 0.0,
            frame: 0,
            frames_per_slow_step,
            until_slow_step: 0,
            forces: Vec::with_capacity(1024),
            forces_due: 0,
            truth: Vec::with_capacity(1024),
            next_truth_s: 0.0,
            interval_s,
            omega_rad_per_s,
            fingertip,
            scenario,
        }
    }

    /// Returns the number of input channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.scenario.converter.channels
    }

    /// Returns the number of frames from a generator sample to its arrival on the line loop (channel 2).
    #[must_use]
    pub fn loop_latency_frames() -> usize {
        Reconstruction::DAC_LATENCY + LATENCY
    }

    /// Simulates one period of one or more frames: generator samples in, interleaved inputs out.
    ///
    /// `finger` is the finger's state at the end of the period; it changes linearly from the previous one.
    ///
    /// # Panics
    /// If `inputs` is not `drive.len() · channels()` long.
    pub fn step(
        &mut self,
        drive: &[f32],
        amplifier_on: bool,
        finger: &FingerState,
        inputs: &mut [f32],
    ) {
        let channels = self.channels();
        assert_eq!(
            inputs.len(),
            drive.len() * channels,
            "one input frame for each drive sample"
        );
        self.forces.drain(..self.forces_due);
        self.truth.clear();
        self.volts = SquaredVolts::default();
        let from = self.finger;
        let gate_target = if amplifier_on {
            self.amplifier_gain
        } else {
            0.0
        };
        for (i, (&sample, frame)) in drive
            .iter()
            .zip(inputs.chunks_exact_mut(channels))
            .enumerate()
        {
            if self.until_slow_step == 0 {
                self.finger = interpolate(&from, finger, (i + 1) as f64 / drive.len() as f64);
                self.slow_step();
                self.until_slow_step = self.frames_per_slow_step;
            }
            self.until_slow_step -= 1;
            self.frame += 1;
            self.fast_step(dac(sample), gate_target);
            self.read_gauges();
            self.converter.frame(&self.ideal, frame);
        }
        self.finger = *finger;
        let end_s = self.end_s();
        self.forces_due = self.forces.partition_point(|s| s.time_s <= end_s);
    }

    /// Sets the amplifier's gain to this fraction of the scenario's, between two periods.
    pub fn set_amplifier_gain(&mut self, share: f64) {
        self.amplifier_gain = share;
    }

    /// Reconnects the cables of the inputs, between two periods.
    pub fn wire(&mut self, wiring: InputWiring) {
        if wiring != self.patch.wiring() {
            self.patch.wire(wiring);
            self.delays.iter_mut().for_each(Delay::clear);
            self.ideal.fill(0.0);
        }
    }

    /// Puts the mass marked `mass_kg` on the plate or over the pulley, replacing the present one.
    pub fn place_mass(&mut self, axis: LoadedAxis, mass_kg: f64) {
        let now_s = self.end_s();
        self.masses.place(axis, mass_kg, now_s);
    }

    /// Removes all masses.
    pub fn remove_masses(&mut self) {
        let now_s = self.end_s();
        self.masses.remove(now_s);
    }

    /// Returns the samples that the force sensor took during the last [`Self::step`].
    #[must_use]
    pub fn forces(&self) -> &[SensorSample] {
        &self.forces[..self.forces_due]
    }

    /// Returns the truth during the last [`Self::step`], one sample per millisecond.
    #[must_use]
    pub fn truth(&self) -> &[TruthSample] {
        &self.truth
    }

    /// Returns the squared voltage of the amplifier during the last [`Self::step`].
    #[must_use]
    pub fn volts(&self) -> SquaredVolts {
        self.volts
    }

    /// Returns the constants of the run.
    #[must_use]
    pub fn constants(&self) -> TruthConstants {
        let z_p = Modes::new(&self.scenario.plate).unloaded_impedance(self.omega_rad_per_s);
        TruthConstants {
            frames_per_s: 1.0 / self.interval_s,
            z_p_n_s_per_m: [z_p.re, z_p.im],
            fingertip: self.fingertip,
            scenario: self.scenario.clone(),
        }
    }

    /// Returns the true time at the end of the last step, s.
    fn end_s(&self) -> f64 {
        self.epoch_s + self.frame as f64 * self.interval_s
    }

    #[inline]
    fn fast_step(&mut self, sample: f64, gate_target: f64) {
        self.history.push(sample);
        self.gate += (gate_target - self.gate) * self.gate_rate;
        if (gate_target - self.gate).abs() < 1e-9 {
            self.gate = gate_target;
        }
        let (mut readback, mut pickup, mut line, mut middle_m) = (0.0, 0.0, 0.0, 0.0);
        let on_bench = self.patch.wiring() == InputWiring::Bench;
        let is_driven = !self.history.is_silent();
        if is_driven && on_bench {
            line = dot(&self.line_weights, self.history.newest_first());
        }
        let mut voltage: Polynomial = Polynomial::default();
        if is_driven && self.gate > 0.0 {
            voltage = self.amplifier.interval(self.history.newest_first());
            let gain = self.gate * self.scenario.amplifier.volts_per_unit;
            voltage.iter_mut().for_each(|c| *c *= gain);
        }
        self.volts.frames += 1;
        self.volts.sum_v2 += evaluate(&voltage, 0.5).powi(2);
        if is_driven && self.gate > 0.0 || !self.state.is_zero() {
            readback = evaluate(&voltage, self.readback_moment)
                / self.scenario.converter.readback_volts_per_unit;
            // A patched amplifier feeds the inputs, not the actuators.
            let across_plate = if on_bench {
                voltage
            } else {
                Polynomial::default()
            };
            let outputs = self.propagator.step(&mut self.state, &across_plate);
            pickup = outputs.pickup_m / self.scenario.pickup.metres_per_unit;
            middle_m = outputs.surface_m;
        }
        // Two values per interval, so that the square of a 35 kHz motion does not alias at 96 kHz.
        let end_m = self.state.surface(self.propagator.modes());
        let square = 0.5 * (middle_m * middle_m + end_m * end_m);
        let [first, second] = &mut self.mean_square;
        *first += (square - *first) * self.mean_square_rate;
        *second += (*first - *second) * self.mean_square_rate;
        if on_bench {
            let bench = [readback, pickup, line];
            let delays = self.delays.iter_mut().zip(bench);
            for (input, (delay, value)) in self.ideal.iter_mut().zip(delays) {
                *input = delay.push(value);
            }
            if let Some(reference) = &mut self.reference {
                self.ideal[REFERENCE_INPUT] = reference.push(middle_m);
            }
        } else {
            let divider = self.scenario.converter.readback_volts_per_unit;
            self.patch.feed(&voltage, divider, &mut self.ideal);
        }
    }

    /// Writes the gauges' values to their inputs, unless another cable is connected.
    fn read_gauges(&mut self) {
        let Some(gauges) = &mut self.gauges else {
            return;
        };
        let values = gauges.frame();
        if self.patch.wiring() == InputWiring::Bench {
            let inputs = self.ideal.iter_mut().skip(FIRST_GAUGE);
            inputs.zip(values).for_each(|(input, value)| *input = value);
        }
    }

    /// Advances film, friction and forces to the present moment.
    fn slow_step(&mut self) {
        let dt_s = f64::from(self.frames_per_slow_step) * self.interval_s;
        self.state.flush();
        if self.mean_square.iter().all(|m| *m < INVISIBLE_M2) {
            self.mean_square = [0.0; 2];
        }
        let normal_n = self.finger.normal_n;
        let touching = self.finger.touching && normal_n > LEAST_CONTACT_N;
        let skin = self.moisture.advance(dt_s, touching, &self.fingertip);
        let amplitude2 = 2.0 * self.mean_square[1];

        // The converter shows this moment in a later frame, and time is counted in frames.
        let shown_frame = self.frame + LATENCY as u64;
        let time_s = self.epoch_s + shown_frame as f64 * self.interval_s;
        let tuning = self.drift.advance(dt_s, time_s, touching, amplitude2);
        let mut now = TruthSample {
            time_s,
            frame: shown_frame,
            sigma_t_m: skin.sigma_t_m,
            z_t_n_s_per_m: skin.z_t_n_s_per_m,
            mu0: skin.mu0,
            gap_m: f64::NAN,
            k_c_n_per_m: 0.0,
            mu: f64::NAN,
            normal_n: 0.0,
            lateral_n: 0.0,
            position_m: self.finger.position_m,
            velocity_m_per_s: self.finger.velocity_m_per_s,
            amplitude_m: amplitude2.sqrt(),
            resonance_shift_hz: tuning.shift_hz,
            damping_n_s_per_m: self.scenario.plate.damping_n_s_per_m * tuning.damping,
            contact_area_m2: 0.0,
            amplitude_ratio: 1.0,
            lag_s: f64::NAN,
        };
        if touching {
            let touch = self.touch.press(dt_s, &skin, &self.finger, amplitude2);
            let plate = &self.scenario.plate;
            let at_m = self.finger.position_m;
            let shapes = [plate.shape(at_m), plate.second_contact_ratio(at_m)];
            now.z_t_n_s_per_m = self.touch.z_t(&skin, normal_n);
            self.retune(tuning);
            self.propagator.set_shape(shapes);
            let tissue = tissue(now.z_t_n_s_per_m, self.omega_rad_per_s);
            self.propagator.set(touch.contact, tissue);

            now.mu0 = touch.mu0;
            now.gap_m = touch.gap_m;
            now.k_c_n_per_m = touch.k_c_n_per_m;
            now.mu = touch.mu;
            now.normal_n = normal_n;
            now.lateral_n = touch.lateral_n;
            now.contact_area_m2 = touch.area_m2;
            now.amplitude_ratio = shapes[0];
            now.lag_s = touch.lag_s;
        } else if self.touch.lift(dt_s) || tuning.differs_from(&self.tuning) {
            self.retune(tuning);
            let tissue = tissue(skin.z_t_n_s_per_m, self.omega_rad_per_s);
            self.propagator.set(SkinContact::default(), tissue);
        }
        let [weight_n, pull_n] = self.masses.forces(time_s);
        let on_sensor = [now.normal_n + weight_n, now.lateral_n + pull_n];
        self.force_sensor
            .advance(time_s, on_sensor, &mut self.forces);
        if let Some(gauges) = &mut self.gauges {
            gauges.advance(time_s, on_sensor);
        }
        if time_s >= self.next_truth_s {
            self.next_truth_s += TRUTH_STEP_S;
            self.truth.push(now);
        }
    }

    /// Changes the tuning of the plate without a finger, from the next step of the propagator on.
    fn retune(&mut self, tuning: Tuning) {
        self.tuning = tuning;
        self.propagator.tune(tuning.shift_hz, tuning.damping);
    }
}

/// Returns the gauges of a scenario if they are on the sound card.
fn bridge(scenario: &Scenario, interval_s: f64, epoch_s: f64, seed: u64) -> Option<GaugeBridge> {
    let sensor = &scenario.force_sensor;
    let on_card = sensor.interface == ForceInterface::Gauges;
    on_card.then(|| GaugeBridge::new(sensor, 1.0 / interval_s, epoch_s, seed))
}

/// Returns the output of a DAC for a sample: full scale is ±1, and NaN gives 0.
#[inline]
fn dac(sample: f32) -> f64 {
    if sample.is_nan() {
        0.0
    } else {
        f64::from(sample.clamp(-1.0, 1.0))
    }
}

/// Returns the tissue with the impedance Z_t at `omega`.
fn tissue(z_t_n_s_per_m: [f64; 2], omega: f64) -> Tissue {
    let [damping_n_s_per_m, im] = z_t_n_s_per_m;
    Tissue {
        mass_kg: (im + TISSUE_STIFFNESS_N_PER_M / omega) / omega,
        stiffness_n_per_m: TISSUE_STIFFNESS_N_PER_M,
        damping_n_s_per_m,
    }
}

/// Returns the finger's state at the fraction `share` between two states.
fn interpolate(from: &FingerState, to: &FingerState, share: f64) -> FingerState {
    let mix = |a: f64, b: f64| a + share * (b - a);
    FingerState {
        position_m: mix(from.position_m, to.position_m),
        velocity_m_per_s: mix(from.velocity_m_per_s, to.velocity_m_per_s),
        normal_n: mix(from.normal_n, to.normal_n),
        touching: from.touching || to.touching,
    }
}

#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
