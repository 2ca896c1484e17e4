//! Motion of the finger along the plate.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::gaze::Pursuit;
use crate::scenario::BehaviourTable;

/// Speed of the hand in the air, m/s.
const REACH_M_PER_S: f64 = 0.25;
/// Speed towards the mark while the finger touches the plate, m/s.
const CREEP_M_PER_S: f64 = 0.02;
/// Distance within which the mark counts as reached, m.
const ON_MARK_M: f64 = 1e-3;
const REACH_TIME_S: f64 = 0.1;
/// Rate at which the hand reduces its lag behind the slider, 1/s.
const CATCH_UP_PER_S: f64 = 1.0;
/// Greatest catch-up speed, relative to the slider's speed.
const CATCH_UP_SHARE: f64 = 0.05;
const LEAST_CATCH_UP_M_PER_S: f64 = 2e-3;
/// Correlation time of fluctuating speed error, s.
const WANDER_TIME_S: f64 = 0.3;
const TREMOR_HZ: f64 = 9.5;
const TREMOR_COHERENCE_S: f64 = 0.3;

/// The exploring hand, with speed error and tremor.
#[derive(Debug, Clone)]
pub(crate) struct Hand {
    position_m: f64,
    velocity: f64,
    speed_bias: f64,
    wander: f64,
    wander_rms: f64,
    tracking_rad_per_s: f64,
    tremor: Tremor,
}

impl Hand {
    pub fn new(behaviour: &BehaviourTable, position_m: f64, speed_score: f64) -> Self {
        Self {
            position_m,
            velocity: 0.0,
            speed_bias: behaviour.speed_error * speed_score,
            wander: 0.0,
            wander_rms: behaviour.speed_wander,
            tracking_rad_per_s: TAU * behaviour.tracking_hz,
            tremor: Tremor::new(TREMOR_HZ, behaviour.tremor_m),
        }
    }

    /// Returns position, m, and velocity, m/s, with tremor.
    pub fn motion(&self) -> (f64, f64) {
        (
            self.position_m + self.tremor.value(),
            self.velocity + self.tremor.rate(),
        )
    }

    /// Decelerates to rest, starting from the present position.
    pub fn rest(&mut self, h_s: f64, rng: &mut ChaCha8Rng) {
        self.velocity *= (-h_s / REACH_TIME_S).exp();
        self.position_m += self.velocity * h_s;
        self.tremor.advance(h_s, rng);
    }

    /// Moves towards a mark; returns whether it has arrived.
    pub fn reach(&mut self, mark_m: f64, touching: bool, h_s: f64, rng: &mut ChaCha8Rng) -> bool {
        let fastest = if touching {
            CREEP_M_PER_S
        } else {
            REACH_M_PER_S
        };
        let target_velocity = ((mark_m - self.position_m) / REACH_TIME_S).clamp(-fastest, fastest);
        self.velocity +=
            (target_velocity - self.velocity) * (1.0 - (-4.0 * h_s / REACH_TIME_S).exp());
        self.position_m += self.velocity * h_s;
        self.tremor.advance(h_s, rng);
        (mark_m - self.position_m).abs() < ON_MARK_M
    }

    /// Follows the slider: its speed promptly, its position slowly.
    pub fn pursue(&mut self, pursuit: Pursuit, h_s: f64, rng: &mut ChaCha8Rng) {
        let Some((target_m, target_velocity)) = pursuit else {
            self.rest(h_s, rng);
            return;
        };
        let white: f64 = StandardNormal.sample(rng);
        let decay = (-h_s / WANDER_TIME_S).exp();
        self.wander = decay * self.wander + self.wander_rms * (1.0 - decay * decay).sqrt() * white;
        let hurry = (CATCH_UP_SHARE * target_velocity.abs()).max(LEAST_CATCH_UP_M_PER_S);
        let catch_up = CATCH_UP_PER_S * (target_m - self.position_m);
        let aim_velocity =
            target_velocity * (1.0 + self.speed_bias + self.wander) + catch_up.clamp(-hurry, hurry);
        self.velocity +=
            (aim_velocity - self.velocity) * (1.0 - (-self.tracking_rad_per_s * h_s).exp());
        self.position_m += self.velocity * h_s;
        self.tremor.advance(h_s, rng);
    }
}

/// Narrow-band oscillation: a rotating phasor that loses its phase coherence.
#[derive(Debug, Clone)]
pub(crate) struct Tremor {
    omega: f64,
    rms: f64,
    phasor: [f64; 2],
}

impl Tremor {
    pub fn new(frequency_hz: f64, rms: f64) -> Self {
        Self {
            omega: TAU * frequency_hz,
            rms,
            phasor: [0.0; 2],
        }
    }

    pub fn advance(&mut self, h_s: f64, rng: &mut ChaCha8Rng) {
        let decay = (-h_s / TREMOR_COHERENCE_S).exp();
        let kick = self.rms * (1.0 - decay * decay).sqrt();
        let (sin, cos) = (self.omega * h_s).sin_cos();
        let [a, b] = self.phasor;
        let white: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(rng));
        self.phasor = [
            decay * (cos * a - sin * b) + kick * white[0],
            decay * (sin * a + cos * b) + kick * white[1],
        ];
    }

    pub fn value(&self) -> f64 {
        self.phasor[0]
    }

    pub fn rate(&self) -> f64 {
        -self.omega * self.phasor[1]
    }
}
