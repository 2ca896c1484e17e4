//! Two-axis force sensor: a resonant mount, sampled by an independent clock.

use nalgebra::{Matrix2, Matrix4, Vector2};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::scenario::ForceSensorTable;
use crate::seed;

/// A sample of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorSample {
    /// True time of the sample, s; input frame 0 is time 0.
    pub time_s: f64,
    /// Device time of the sample, s since the beginning of the simulation.
    pub device_time_s: f64,
    /// Reading of the normal axis, N; positive for a pressing finger.
    pub normal_n: f64,
    /// Reading of the lateral axis, N, positive towards increasing position.
    pub lateral_n: f64,
    /// Whether the normal axis is at the end of its range.
    pub normal_saturated: bool,
    /// Whether the lateral axis is at the end of its range.
    pub lateral_saturated: bool,
}

/// Normal and lateral force on the plate at one moment, N.
pub(crate) type Forces = [f64; 2];

/// The force sensor with its state.
#[derive(Debug, Clone)]
pub(crate) struct ForceSensor {
    scenario: ForceSensorTable,
    mounts: [Mount; 2],
    axes: [Vector2<f64>; 2],
    lateral_lag: Lag,
    crept_n: Forces,
    wander: Wander,
    previous: Option<(f64, Forces)>,
    previous_input: Forces,
    sample_count: u64,
    start_s: f64,
    rng: ChaCha8Rng,
}

impl ForceSensor {
    pub fn new(scenario: &ForceSensorTable, start_s: f64, seed: u64) -> Self {
        Self {
            scenario: scenario.clone(),
            mounts: [Some(scenario.resonance_hz), scenario.lateral_resonance_hz]
                .map(|hz| Mount::new(scenario, hz.unwrap_or(scenario.resonance_hz))),
            lateral_lag: Lag::new(scenario),
            axes: [Vector2::zeros(); 2],
            crept_n: [0.0; 2],
            wander: Wander::new(scenario, seed),
            previous: None,
            previous_input: [0.0; 2],
            sample_count: 0,
            start_s,
            rng: seed::stream(seed, seed::RandomStream::ForceNoise),
        }
    }

    /// Takes all samples up to `time_s`, at which `forces` act; forces change linearly between calls.
    pub fn advance(&mut self, time_s: f64, forces: Forces, out: &mut Vec<SensorSample>) {
        let (from_s, from) = self.previous.unwrap_or((time_s, forces));
        loop {
            let device_time_s = self.sample_count as f64 / self.scenario.rate_hz;
            let at_s = self.start_s + device_time_s / (1.0 + self.scenario.clock_ppm * 1e-6);
            if at_s > time_s {
                break;
            }
            let share = if time_s > from_s {
                (at_s - from_s) / (time_s - from_s)
            } else {
                1.0
            };
            let input = [0, 1].map(|axis| from[axis] + share * (forces[axis] - from[axis]));
            let inputs = self.previous_input.iter().zip(&input);
            let axes = self.axes.iter_mut().zip(&self.mounts);
            for ((axis, mount), (&before, &after)) in axes.zip(inputs) {
                *axis = mount.step(axis, before, after);
            }
            self.lateral_lag.step(self.axes[1].x);
            self.previous_input = input;
            let rate = 1.0 / (self.scenario.creep_time_s * self.scenario.rate_hz);
            for (crept_n, axis) in self.crept_n.iter_mut().zip(&self.axes) {
                *crept_n += (axis.x - *crept_n) * rate;
            }
            self.wander.step();
            self.sample_count += 1;
            let sample = self.read(at_s, device_time_s);
            out.push(sample);
        }
        self.previous = Some((time_s, forces));
    }

    fn read(&mut self, time_s: f64, device_time_s: f64) -> SensorSample {
        let s = &self.scenario;
        let normal = self.axes[0].x + s.creep * self.crept_n[0];
        let lateral = self.lateral_lag.now + s.creep * self.crept_n[1];
        let noise: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(&mut self.rng));
        let minutes = time_s / 60.0;
        let [[nn, nl], [ln, ll]] = s.response();
        let normal_read = nn * normal
            + nl * lateral
            + s.normal_offset_n
            + s.normal_drift_n_per_min * minutes
            + self.wander.now_n[0]
            + s.noise_n * noise[0];
        let lateral_read = ln * normal
            + ll * lateral
            + s.lateral_offset_n
            + s.lateral_drift_n_per_min * minutes
            + self.wander.now_n[1]
            + s.noise_n * noise[1];
        SensorSample {
            time_s,
            device_time_s,
            normal_n: normal_read.clamp(-s.range_n, s.range_n),
            lateral_n: lateral_read.clamp(-s.range_n, s.range_n),
            normal_saturated: normal_read.abs() >= s.range_n,
            lateral_saturated: lateral_read.abs() >= s.range_n,
        }
    }
}

/// Slow random drift of both axes, each a first-order autoregression.
#[derive(Debug, Clone)]
struct Wander {
    now_n: Forces,
    keep: f64,
    kick_n: f64,
    rng: ChaCha8Rng,
}

impl Wander {
    fn new(scenario: &ForceSensorTable, seed: u64) -> Self {
        let keep = (-1.0 / (scenario.wander_time_s * scenario.rate_hz)).exp();
        Self {
            now_n: [0.0; 2],
            keep,
            kick_n: scenario.wander_n * (1.0 - keep * keep).sqrt(),
            rng: seed::stream(seed, seed::RandomStream::ForceWander),
        }
    }

    fn step(&mut self) {
        if self.kick_n == 0.0 {
            return;
        }
        for axis_n in &mut self.now_n {
            let white: f64 = StandardNormal.sample(&mut self.rng);
            *axis_n = self.keep * *axis_n + self.kick_n * white;
        }
    }
}

/// Second-order mount, exact for an input that changes linearly between samples.
#[derive(Debug, Clone)]
struct Mount {
    state: Matrix2<f64>,
    from: Vector2<f64>,
    to: Vector2<f64>,
}

/// First-order lag, exact for an input that changes linearly between samples.
#[derive(Debug, Clone)]
struct Lag {
    /// Time constant in sampling intervals.
    samples: f64,
    keep: f64,
    previous: f64,
    now: f64,
}

impl Lag {
    fn new(scenario: &ForceSensorTable) -> Self {
        let samples = scenario.lateral_lag_s * scenario.rate_hz;
        Self {
            samples,
            keep: (-1.0 / samples).exp(),
            previous: 0.0,
            now: 0.0,
        }
    }

    fn step(&mut self, input: f64) {
        let lag = self.samples * (input - self.previous);
        self.now = input - lag + (self.now - self.previous + lag) * self.keep;
        self.previous = input;
    }
}

impl Mount {
    fn new(scenario: &ForceSensorTable, resonance_hz: f64) -> Self {
        // Time in units of the sampling interval; states: reading, its rate, input, input's rate.
        let omega = std::f64::consts::TAU * resonance_hz / scenario.rate_hz;
        let damping = 2.0 * scenario.damping_ratio * omega;
        #[rustfmt::skip]
        let a = Matrix4::new(
            0.0, 1.0, 0.0, 0.0,
            -omega * omega, -damping, omega * omega, 0.0,
            0.0, 0.0, 0.0, 1.0,
            0.0, 0.0, 0.0, 0.0,
        );
        let e = a.exp();
        let step = Vector2::new(e[(0, 2)], e[(1, 2)]);
        let ramp = Vector2::new(e[(0, 3)], e[(1, 3)]);
        Self {
            state: e.fixed_view::<2, 2>(0, 0).into_owned(),
            from: step - ramp,
            to: ramp,
        }
    }

    fn step(&self, state: &Vector2<f64>, from: f64, to: f64) -> Vector2<f64> {
        self.state * state + self.from * from + self.to * to
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn quiet_table() -> ForceSensorTable {
        ForceSensorTable {
            noise_n: 0.0,
            clock_ppm: 100.0,
            ..ForceSensorTable::default()
        }
    }

    #[test]
    fn samples_follow_the_device_clock() {
        let mut sensor = ForceSensor::new(&quiet_table(), 0.0, 1);
        let mut out = Vec::new();
        for i in 0..=100 {
            sensor.advance(f64::from(i) * 0.01, [0.65, 0.3], &mut out);
        }
        // 10 kHz · (1 + 100 ppm) over 1 s, both ends included
        assert_eq!(out.len(), 10_002);
        assert_relative_eq!(out[10_000].device_time_s, 1.0, max_relative = 1e-12);
        assert_relative_eq!(out[10_000].time_s, 1.0 / 1.0001, max_relative = 1e-12);
        assert_relative_eq!(out[10_000].normal_n, 0.65, max_relative = 1e-9);
        assert_relative_eq!(out[10_000].lateral_n, 0.3, max_relative = 1e-9);
    }

    #[test]
    fn a_sine_is_read_with_the_mounts_gain_and_phase() {
        let mut sensor = ForceSensor::new(&quiet_table(), 0.0, 1);
        let mut out = Vec::new();
        let omega = std::f64::consts::TAU * 200.0;
        for i in 0..8000 {
            let t = f64::from(i) * 2.5e-5;
            sensor.advance(t, [(omega * t).sin(), 0.0], &mut out);
        }
        let r: f64 = 200.0 / 3000.0;
        let (re, im) = (1.0 - r * r, 2.0 * 0.4 * r);
        let (gain, phase) = (1.0 / re.hypot(im), -im.atan2(re));
        for s in &out[500..] {
            let expected = gain * (omega * s.time_s + phase).sin();
            assert!(
                (s.normal_n - expected).abs() < 2e-3,
                "{} {expected}",
                s.normal_n
            );
        }
    }

    /// Returns one second of readings, ten seconds after `forces` began to act.
    fn settled_samples(scenario: &ForceSensorTable, forces: Forces) -> Vec<SensorSample> {
        let mut sensor = ForceSensor::new(scenario, 0.0, 1);
        let mut out = Vec::new();
        for second in 0..=11 {
            out.clear();
            sensor.advance(f64::from(second), forces, &mut out);
        }
        out
    }

    #[test]
    fn gains_and_crosstalk_are_the_response() {
        let scenario = ForceSensorTable {
            normal_gain: 1.2,
            lateral_gain: 0.9,
            lateral_to_normal: 0.05,
            normal_to_lateral: -0.03,
            ..quiet_table()
        };
        let last = settled_samples(&scenario, [0.5, 0.2])[5_000];
        assert_relative_eq!(last.normal_n, 1.2 * (0.5 + 0.05 * 0.2), max_relative = 1e-9);
        assert_relative_eq!(
            last.lateral_n,
            0.9 * (0.2 - 0.03 * 0.5),
            max_relative = 1e-9
        );
        let [[nn, nl], [ln, ll]] = scenario.response();
        assert_relative_eq!(last.normal_n, nn * 0.5 + nl * 0.2, max_relative = 1e-9);
        assert_relative_eq!(last.lateral_n, ln * 0.5 + ll * 0.2, max_relative = 1e-9);
    }

    #[test]
    fn the_lateral_axis_has_a_lag_and_a_resonance_of_its_own() {
        let table = ForceSensorTable {
            lateral_lag_s: 2e-3,
            ..quiet_table()
        };
        let mut sensor = ForceSensor::new(&table, 0.0, 1);
        let mut out = Vec::new();
        for ms in 0..=40 {
            let force_n = 0.1 * f64::from(ms);
            sensor.advance(1e-3 * f64::from(ms), [force_n; 2], &mut out);
        }
        // A ramp is read late by the lag, plus by 2·0.4/(2π·3000 Hz) of the mount on both axes.
        let last = out[out.len() - 1];
        assert_relative_eq!(last.normal_n - last.lateral_n, 0.2, max_relative = 1e-3);

        let soft = ForceSensorTable {
            lateral_resonance_hz: Some(150.0),
            ..quiet_table()
        };
        let mut sensor = ForceSensor::new(&soft, 0.0, 1);
        out.clear();
        let omega = std::f64::consts::TAU * 150.0;
        for i in 0..8_000 {
            let t = f64::from(i) * 2.5e-5;
            sensor.advance(t, [(omega * t).sin(); 2], &mut out);
        }
        let peak =
            |value: fn(&SensorSample) -> f64| out[1_000..].iter().map(value).fold(0.0, f64::max);
        // At resonance the gain is 1/(2·0.4), and far below it 1.
        assert_relative_eq!(peak(|s| s.lateral_n), 1.25, max_relative = 5e-3);
        assert_relative_eq!(peak(|s| s.normal_n), 1.0, max_relative = 5e-3);
    }

    #[test]
    fn drift_creep_and_wander_are_slow() {
        let table = ForceSensorTable {
            normal_drift_n_per_min: 0.6,
            ..quiet_table()
        };
        let out = settled_samples(&table, [0.0, 0.0]);
        let rise_n = out[out.len() - 1].normal_n - out[0].normal_n;
        assert!((rise_n - 0.01).abs() < 1e-4, "{rise_n} N in a second");

        let table = ForceSensorTable {
            creep: 0.01,
            creep_time_s: 5.0,
            ..quiet_table()
        };
        let last = settled_samples(&table, [1.0, 0.0]);
        let expected = 1.0 + 0.01 * (1.0 - (-11.0f64 / 5.0).exp());
        assert!((last[last.len() - 1].normal_n - expected).abs() < 1e-4);

        let table = ForceSensorTable {
            wander_n: 0.01,
            wander_time_s: 1.0,
            ..quiet_table()
        };
        let mut sensor = ForceSensor::new(&table, 0.0, 1);
        let mut out = Vec::new();
        for second in 0..=400 {
            sensor.advance(f64::from(second), [0.0; 2], &mut out);
        }
        let mean_square = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = values.fold((0.0, 0u32), |(sum, n), x| (sum + x * x, n + 1));
            sum / f64::from(n)
        };
        let sd_n = mean_square(&mut out.iter().map(|s| s.normal_n)).sqrt();
        assert!((0.007..0.013).contains(&sd_n), "{sd_n} N");
        let step_n = mean_square(&mut out.windows(2).map(|w| w[1].normal_n - w[0].normal_n)).sqrt();
        assert!(step_n < 2e-4, "{step_n} N from sample to sample");
    }

    #[test]
    fn saturation_is_flagged_per_axis() {
        let mut sensor = ForceSensor::new(&quiet_table(), 0.0, 1);
        let mut out = Vec::new();
        sensor.advance(0.0, [12.0, 1.0], &mut out);
        sensor.advance(0.1, [12.0, 1.0], &mut out);
        let last = out[out.len() - 1];
        assert_eq!(
            (last.normal_n, last.normal_saturated, last.lateral_saturated),
            (10.0, true, false)
        );
    }
}
