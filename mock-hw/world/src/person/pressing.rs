//! Normal force of the person: target, misjudgement, learning, wander and tremor.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::hand::Tremor;
use crate::scenario::BehaviourTable;

const TREMOR_HZ: f64 = 10.0;
/// Time constant of landing and lifting the finger, s.
const LANDING_S: f64 = 0.03;
/// Fraction of the target force below which the finger is off the plate.
const LIFTED: f64 = 0.01;
/// Least force of a touching finger, relative to the target.
const LEAST_SHARE: f64 = 0.1;

/// The pressing finger.
#[derive(Debug, Clone)]
pub(crate) struct Pressing {
    aim_n: f64,
    /// Relative excess of the exerted force over the intended one.
    misjudgement: f64,
    learning: f64,
    wander_n: f64,
    wander_rms_n: f64,
    wander_time_s: f64,
    tremor: Tremor,
    is_down: bool,
    /// Progress of landing, from 0 in the air to 1 on the plate.
    landing: f64,
}

impl Pressing {
    pub fn new(behaviour: &BehaviourTable, misjudgement_score: f64) -> Self {
        Self {
            aim_n: behaviour.force_aim_n,
            misjudgement: (behaviour.force_misjudgement * misjudgement_score).max(-0.6),
            learning: behaviour.force_learning,
            wander_n: 0.0,
            wander_rms_n: behaviour.force_drift_n,
            wander_time_s: behaviour.force_drift_time_s,
            tremor: Tremor::new(TREMOR_HZ, behaviour.tremor_n),
            is_down: false,
            landing: 0.0,
        }
    }

    pub fn aim_at(&mut self, aim_n: f64) {
        self.aim_n = aim_n;
    }

    /// Corrects part of the error in the displayed mean force.
    pub fn learn(&mut self, mean_n: f64) {
        if mean_n > 0.0 {
            self.misjudgement -= self.learning * (mean_n / self.aim_n - 1.0);
            self.misjudgement = self.misjudgement.max(-0.6);
        }
    }

    pub fn press(&mut self) {
        self.is_down = true;
    }

    pub fn lift(&mut self) {
        self.is_down = false;
    }

    pub fn is_touching(&self) -> bool {
        self.landing > LIFTED
    }

    pub fn advance(&mut self, h_s: f64, rng: &mut ChaCha8Rng) {
        let decay = (-h_s / self.wander_time_s).exp();
        let white: f64 = StandardNormal.sample(rng);
        self.wander_n =
            decay * self.wander_n + self.wander_rms_n * (1.0 - decay * decay).sqrt() * white;
        self.tremor.advance(h_s, rng);
        let goal = if self.is_down { 1.0 } else { 0.0 };
        self.landing += (goal - self.landing) * (1.0 - (-h_s / LANDING_S).exp());
    }

    /// Returns the force on the plate, N; 0 in the air.
    pub fn force_n(&self) -> f64 {
        if !self.is_touching() {
            return 0.0;
        }
        let steady_n = self.aim_n * (1.0 + self.misjudgement) + self.wander_n + self.tremor.value();
        self.landing * steady_n.max(LEAST_SHARE * self.aim_n)
    }
}
