//! The skin of one person, drawn from the published population or pinned by the scenario.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

use crate::scenario::{ParticipantTable, PopulationTable};
use crate::seed;

/// Skin of a fingertip at the beginning of a session.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fingertip {
    /// Asperity scale σ_t, m.
    pub sigma_t_m: f64,
    /// Tissue impedance Z_t at the plate's resonance, real and imaginary part, N·s/m.
    pub z_t_n_s_per_m: [f64; 2],
    /// Friction coefficient without vibration.
    pub mu0: f64,
}

impl Fingertip {
    /// Draws the fingertip of `seed`; pinned values replace drawn ones.
    ///
    /// ```
    /// use mock_world::fingertip::Fingertip;
    /// use mock_world::scenario::built_in;
    ///
    /// let pinned = built_in("nominal")?.participant;
    /// assert_eq!(Fingertip::draw(&pinned, 1), Fingertip::draw(&pinned, 2));
    /// let drawn = built_in("population")?.participant;
    /// assert_ne!(Fingertip::draw(&drawn, 1), Fingertip::draw(&drawn, 2));
    /// # Ok::<(), mock_world::scenario::ScenarioError>(())
    /// ```
    ///
    /// σ_t and Z_t are normal, truncated to physical values; μ0 has the published Spearman correlation ρ_S with Im Z_t
    /// through a Gaussian copula, whose Pearson correlation is 2 sin(π ρ_S/6).
    #[must_use]
    pub fn draw(participant: &ParticipantTable, seed: u64) -> Self {
        let mut rng = seed::stream(seed, seed::Stream::Fingertip);
        let PopulationTable {
            sigma_t_m,
            re_z_t_n_s_per_m,
            im_z_t_n_s_per_m,
            mu0,
            spearman_mu0_im_z_t,
        } = &participant.population;
        let sigma = drawn(&mut rng, *sigma_t_m, 0.4e-6, f64::MAX).0;
        let re = drawn(&mut rng, *re_z_t_n_s_per_m, 0.05, f64::MAX).0;
        let (im, im_score) = drawn(&mut rng, *im_z_t_n_s_per_m, 0.5, f64::MAX);
        let pearson = 2.0 * (std::f64::consts::PI * spearman_mu0_im_z_t / 6.0).sin();
        let own: f64 = StandardNormal.sample(&mut rng);
        let score = pearson * im_score + (1.0 - pearson * pearson).max(0.0).sqrt() * own;
        Self {
            sigma_t_m: participant.sigma_t_m.unwrap_or(sigma),
            z_t_n_s_per_m: participant.z_t_n_s_per_m.unwrap_or([re, im]),
            mu0: participant
                .mu0
                .unwrap_or((mu0[0] + mu0[1] * score).clamp(0.2, 1.8)),
        }
    }
}

/// Draws a normal value within limits, by rejection; returns it and its standard score.
fn drawn(rng: &mut impl Rng, [mean, sd]: [f64; 2], low: f64, high: f64) -> (f64, f64) {
    loop {
        let score: f64 = StandardNormal.sample(rng);
        let value = mean + sd * score;
        if (low..=high).contains(&value) {
            return (value, score);
        }
    }
}
