//! Six gauges of a force sensor, amplified and connected to inputs of the sound card.

use std::collections::VecDeque;

use nalgebra::{SMatrix, SVector};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::force_sensor::{ForceSensor, Forces, SensorSample};
use crate::scenario::{ForceSensorTable, GAUGES};
use crate::seed;

/// Volts at the end of an input's range.
const VOLTS_PER_UNIT: f64 = 10.0;
/// Lever arms of a press about the sensor's y axis, and of a pull about its z axis, m.
const LEVERS_M: [f64; 2] = [0.011, -0.004];
/// Fraction of the press that a tilted mount shows as Fy.
const TILT: f64 = 0.02;

/// Forces (N) and torques (N·m) per volt of each gauge, from the maker's calibration: rows Fx, Fy, Fz, Tx, Ty, Tz. The geometry
/// is that of six-axis sensors: three beams at 120°, two gauges on each.
pub const MAKERS_MATRIX: [[f64; GAUGES]; GAUGES] = [
    [-0.002, 0.010, 0.060, -1.650, -0.050, 1.670],
    [0.010, 1.970, -0.040, -0.960, 0.070, -0.940],
    [1.880, -0.010, 1.900, -0.060, 1.870, -0.020],
    [0.000_1, 0.000_2, -0.010, 0.000_3, 0.011, 0.000_05],
    [0.012, 0.000_01, -0.006, 0.000_2, -0.007, -0.000_1],
    [0.000_01, -0.009, 0.000_02, -0.009_1, 0.000_03, -0.009_2],
];

/// The gauges with their amplifier.
#[derive(Debug, Clone)]
pub(crate) struct GaugeBridge {
    sensor: ForceSensor,
    samples: Vec<SensorSample>,
    queue: VecDeque<SensorSample>,
    volts: SMatrix<f64, GAUGES, GAUGES>,
    offset_v: f64,
    noise_v: f64,
    /// Factor by which the voltage behind the coupling capacitor decays per sample; 1 without a capacitor.
    keep: f64,
    /// Voltage before and behind the capacitor.
    coupled: [(f64, f64); GAUGES],
    rng: ChaCha8Rng,
}

impl GaugeBridge {
    /// Creates the gauges of `scenario` on a card that takes `rate_hz` true frames per second, starting at `epoch_s`.
    pub(crate) fn new(scenario: &ForceSensorTable, rate_hz: f64, epoch_s: f64, seed: u64) -> Self {
        let gauges = &scenario.gauges;
        // On the card's clock; the filter's delay shifts the readings.
        let sensor = ForceSensorTable {
            rate_hz,
            clock_ppm: 0.0,
            ..scenario.clone()
        };
        let matrix =
            SMatrix::<f64, GAUGES, GAUGES>::from_fn(|row, column| MAKERS_MATRIX[row][column]);
        Self {
            sensor: ForceSensor::new(&sensor, epoch_s - gauges.delay_s, seed),
            samples: Vec::new(),
            queue: VecDeque::new(),
            volts: matrix.try_inverse().unwrap_or_else(SMatrix::identity),
            offset_v: gauges.offset_v,
            noise_v: gauges.noise_v,
            keep: gauges
                .ac_hz
                .map_or(1.0, |hz| (-std::f64::consts::TAU * hz / rate_hz).exp()),
            coupled: [(0.0, 0.0); GAUGES],
            rng: seed::stream(seed, seed::RandomStream::Gauges),
        }
    }

    /// Takes all samples up to `time_s`, at which `forces` act.
    pub(crate) fn advance(&mut self, time_s: f64, forces: Forces) {
        self.sensor.advance(time_s, forces, &mut self.samples);
        self.queue.extend(self.samples.drain(..));
    }

    /// Returns the values at the six inputs in the next frame.
    pub(crate) fn frame(&mut self) -> [f64; GAUGES] {
        let Some(sample) = self.queue.pop_front() else {
            return [0.0; GAUGES];
        };
        let (press_n, pull_n) = (sample.normal_n, sample.lateral_n);
        let load = SVector::from([
            pull_n,
            TILT * press_n,
            -press_n,
            0.0,
            LEVERS_M[0] * press_n,
            LEVERS_M[1] * pull_n,
        ]);
        let volts = self.volts * load;
        std::array::from_fn(|gauge| {
            let noise: f64 = StandardNormal.sample(&mut self.rng);
            let now = volts[gauge] + self.offset_v;
            let (previous, filtered) = &mut self.coupled[gauge];
            *filtered = if self.keep < 1.0 {
                self.keep * (*filtered + now - *previous)
            } else {
                now
            };
            *previous = now;
            (*filtered + self.noise_v * noise) / VOLTS_PER_UNIT
        })
    }
}
