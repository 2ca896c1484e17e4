//! Output of a vibrometer on a spare input: the delayed motion of the plate's middle, interpolated between samples.

use std::collections::VecDeque;
use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::converter::LATENCY;
use crate::scenario::{Follows, REFERENCE_INPUT, Scenario};
use crate::seed;

/// Number of samples on either side used for an interpolated value.
const REACH: usize = 7;
/// Time within a sample interval at which the middle's displacement is known, in intervals from its start.
const KNOWN_AT: f64 = 0.5;

/// Output of the vibrometer.
#[derive(Debug, Clone)]
pub(super) struct VibrometerOutput {
    /// Latest displacements of the plate's middle, m, newest first.
    recent: VecDeque<f64>,
    /// Weights of the displacements, sample units per metre.
    weights: Vec<f64>,
    noise_units: f64,
    rng: ChaCha8Rng,
}

impl VibrometerOutput {
    /// Creates the vibrometer of `scenario` for frames of `interval_s`; `None` if the scenario has none.
    pub fn new(scenario: &Scenario, interval_s: f64, seed: u64) -> Option<Self> {
        let table = &scenario.reference;
        let skew = scenario.converter.skew(REFERENCE_INPUT);
        // Intervals from the requested moment to the newest displacement.
        let latency = LATENCY as f64 + KNOWN_AT - skew + table.delay_s / interval_s;
        let length = latency.floor() as usize + REACH + 2;
        let weights_of = |weight: fn(f64) -> f64, scale: f64| -> Vec<f64> {
            (0..length)
                .map(|k| scale * weight(k as f64 - latency))
                .collect()
        };
        let units_per = 1.0 / (table.per_volt * table.volts_per_unit);
        let weights = match table.follows {
            Follows::Nothing => return None,
            Follows::Displacement => weights_of(sinc_weight, units_per),
            Follows::Velocity => weights_of(slope, units_per / interval_s),
        };
        Some(Self {
            recent: vec![0.0; length].into(),
            weights,
            noise_units: table.noise_v / table.volts_per_unit,
            rng: seed::stream(seed, seed::RandomStream::Reference),
        })
    }

    /// Takes the displacement of the plate's middle, m, and returns the value at the input.
    pub fn push(&mut self, middle_m: f64) -> f64 {
        self.recent.pop_back();
        self.recent.push_front(middle_m);
        let white: f64 = StandardNormal.sample(&mut self.rng);
        let products = self.recent.iter().zip(&self.weights);
        products.map(|(x, weight)| x * weight).sum::<f64>() + self.noise_units * white
    }
}

/// Weight of a sample `x` intervals away: a windowed sinc, accurate to 1e-4 up to a third of the rate.
fn sinc_weight(x: f64) -> f64 {
    let reach = REACH as f64 + 1.0;
    if x.abs() >= reach {
        return 0.0;
    }
    let sinc = if x.abs() < 1e-9 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    };
    // Blackman window.
    let place = PI * x / reach;
    sinc * (0.42 + 0.5 * place.cos() + 0.08 * (2.0 * place).cos())
}

/// Weight of a sample in the slope per interval; older samples have larger `x`.
fn slope(x: f64) -> f64 {
    const STEP: f64 = 1e-4;
    (sinc_weight(x + STEP) - sinc_weight(x - STEP)) / (2.0 * STEP)
}
