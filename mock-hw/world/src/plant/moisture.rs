//! Slow change of the skin: its moisture fluctuates about the mean and grows during a touch.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::exposure::Exposure;
use crate::fingertip::Fingertip;
use crate::scenario::MoistureTable;
use crate::seed;

/// Relative change of Z_t per relative change of μ0 (assumed: wet skin has more friction and is softer).
const TISSUE_SHARE: f64 = -0.7;
/// Relative change of σ_t per relative change of μ0 (assumed for the same reason).
const ROUGHNESS_SHARE: f64 = -0.3;

/// An Ornstein–Uhlenbeck process that starts at its mean.
#[derive(Debug, Clone)]
pub(crate) struct Moisture {
    relative_sd: f64,
    time_s: f64,
    value: f64,
    growth_exposure: Exposure,
    rng: ChaCha8Rng,
}

impl Moisture {
    pub fn new(scenario: &MoistureTable, seed: u64) -> Self {
        Self {
            relative_sd: scenario.relative_sd,
            time_s: scenario.time_s,
            value: 0.0,
            growth_exposure: Exposure::new(scenario.growth_time_s),
            rng: seed::stream(seed, seed::RandomStream::Moisture),
        }
    }

    /// Advances by `dt_s`, touching or not; returns the present skin of `fingertip`.
    pub fn advance(&mut self, dt_s: f64, touching: bool, fingertip: &Fingertip) -> Fingertip {
        let decay = (-dt_s / self.time_s).exp();
        let white: f64 = StandardNormal.sample(&mut self.rng);
        self.value = decay * self.value + self.relative_sd * (1.0 - decay * decay).sqrt() * white;
        let tissue = 1.0 + TISSUE_SHARE * self.value;
        let growth = 1.0 + fingertip.pad.growth * self.growth_exposure.advance(dt_s, touching);
        let [re, im] = fingertip.z_t_n_s_per_m.map(|z| z * tissue);
        Fingertip {
            sigma_t_m: fingertip.sigma_t_m * (1.0 + ROUGHNESS_SHARE * self.value) * growth,
            z_t_n_s_per_m: [re, im * growth],
            mu0: fingertip.mu0 * (1.0 + self.value),
            pad: fingertip.pad,
        }
    }
}
