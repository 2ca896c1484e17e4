//! Skin of one person, drawn from a population or given by the scenario.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;

use crate::scenario::{PopulationTable, Scenario};
use crate::seed;

/// Skin of a fingertip at the beginning of a session.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fingertip {
    /// Asperity scale σ_t, m.
    pub sigma_t_m: f64,
    /// Tissue impedance Z_t at the plate's resonance, real and imaginary part, N·s/m.
    pub z_t_n_s_per_m: [f64; 2],
    /// Friction coefficient without vibration, at 50 mm/s and 1 N at the beginning of a touch.
    pub mu0: f64,
    /// Contact with the plate.
    pub pad: Pad,
}

/// Mechanical contact of a fingertip with the plate, at rest and sliding.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Pad {
    /// Apparent contact area S at a normal force of 1 N, m².
    pub contact_area_m2: f64,
    /// Exponent of the normal force in the contact area.
    pub area_force_exponent: f64,
    /// Roughness cut-off q0, rad/m.
    pub q0_rad_per_m: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Loss factor η of the contact.
    pub loss_factor: f64,
    /// Time constant of levitation at a gap of 10 µm, s.
    pub lag_s: f64,
    /// Exponent of the gap in the time constant of levitation.
    pub lag_gap_exponent: f64,
    /// Fraction of the friction that levitation cannot remove.
    pub floor: f64,
    /// Exponent of the sliding speed, relative to 50 mm/s, in the friction coefficient.
    pub speed_exponent: f64,
    /// Relative growth of friction after a long touch.
    pub ageing: f64,
    /// Time constant of the growth of friction, s.
    pub ageing_time_s: f64,
    /// Relative growth of σ_t and Im Z_t after a long touch.
    pub growth: f64,
}

impl Pad {
    /// Draws the contact of `seed`; constants without a range in `[participant.spread]` keep the scenario's value.
    ///
    /// ```
    /// use mock_world::fingertip::Pad;
    /// use mock_world::scenario::{Scenario, built_in};
    ///
    /// let plain = Scenario::default();
    /// assert_eq!(Pad::draw(&plain, 1), Pad::draw(&plain, 2));
    /// let unkind = built_in("population-unkind")?;
    /// assert_ne!(Pad::draw(&unkind, 1), Pad::draw(&unkind, 2));
    /// # Ok::<(), mock_world::scenario::ScenarioError>(())
    /// ```
    #[must_use]
    pub fn draw(scenario: &Scenario, seed: u64) -> Self {
        let (film, friction) = (&scenario.film, &scenario.friction);
        let mut rng = seed::stream(seed, seed::RandomStream::Pad);
        let values = scenario.participant.spread.draw_values(&mut rng);
        Self {
            contact_area_m2: values.contact_area_m2.unwrap_or(film.contact_area_m2),
            area_force_exponent: values
                .area_force_exponent
                .unwrap_or(film.area_force_exponent),
            q0_rad_per_m: values.q0_rad_per_m.unwrap_or(film.q0_rad_per_m),
            youngs_modulus_pa: values.youngs_modulus_pa.unwrap_or(film.youngs_modulus_pa),
            poisson_ratio: film.poisson_ratio,
            loss_factor: values.loss_factor.unwrap_or(film.loss_factor),
            lag_s: values.lag_s.unwrap_or(film.lag_s),
            lag_gap_exponent: values.lag_gap_exponent.unwrap_or(film.lag_gap_exponent),
            floor: values.floor.unwrap_or(friction.floor),
            speed_exponent: values.speed_exponent.unwrap_or(friction.speed_exponent),
            ageing: values.ageing.unwrap_or(friction.ageing),
            ageing_time_s: values.ageing_time_s.unwrap_or(friction.ageing_time_s),
            growth: values
                .growth
                .unwrap_or(scenario.participant.moisture.growth),
        }
    }

    /// Returns the apparent contact area S under a normal force, m².
    pub(crate) fn area_m2(&self, normal_n: f64) -> f64 {
        if self.area_force_exponent == 0.0 {
            return self.contact_area_m2;
        }
        self.contact_area_m2 * normal_n.powf(self.area_force_exponent)
    }
}

impl Fingertip {
    /// Draws the fingertip of `seed`; values given by the scenario replace drawn ones.
    ///
    /// ```
    /// use mock_world::fingertip::Fingertip;
    /// use mock_world::scenario::built_in;
    ///
    /// let pinned = built_in("nominal")?;
    /// assert_eq!(Fingertip::draw(&pinned, 1), Fingertip::draw(&pinned, 2));
    /// let drawn = built_in("population")?;
    /// assert_ne!(Fingertip::draw(&drawn, 1), Fingertip::draw(&drawn, 2));
    /// # Ok::<(), mock_world::scenario::ScenarioError>(())
    /// ```
    ///
    /// σ_t and Z_t are normal, truncated to physical values; μ0 has the published Spearman correlation ρ_S with Im Z_t through
    /// a Gaussian copula of Pearson correlation 2 sin(π ρ_S/6).
    #[must_use]
    pub fn draw(scenario: &Scenario, seed: u64) -> Self {
        let participant = &scenario.participant;
        let mut rng = seed::stream(seed, seed::RandomStream::Fingertip);
        let PopulationTable {
            sigma_t_m,
            re_z_t_n_s_per_m,
            im_z_t_n_s_per_m,
            mu0,
            spearman_mu0_im_z_t,
        } = &participant.population;
        let sigma = draw_normal(&mut rng, *sigma_t_m, 0.4e-6, f64::MAX).0;
        let re = draw_normal(&mut rng, *re_z_t_n_s_per_m, 0.05, f64::MAX).0;
        let (im, im_score) = draw_normal(&mut rng, *im_z_t_n_s_per_m, 0.5, f64::MAX);
        let pearson = 2.0 * (std::f64::consts::PI * spearman_mu0_im_z_t / 6.0).sin();
        let own_score: f64 = StandardNormal.sample(&mut rng);
        let score = pearson * im_score + (1.0 - pearson * pearson).max(0.0).sqrt() * own_score;
        Self {
            sigma_t_m: participant.sigma_t_m.unwrap_or(sigma),
            z_t_n_s_per_m: participant.z_t_n_s_per_m.unwrap_or([re, im]),
            mu0: participant
                .mu0
                .unwrap_or((mu0[0] + mu0[1] * score).clamp(0.2, 1.8)),
            pad: Pad::draw(scenario, seed),
        }
    }
}

/// Draws a normal variate within limits, by rejection; returns it and its standard score.
fn draw_normal(rng: &mut impl Rng, [mean, sd]: [f64; 2], low: f64, high: f64) -> (f64, f64) {
    loop {
        let score: f64 = StandardNormal.sample(rng);
        let value = mean + sd * score;
        if (low..=high).contains(&value) {
            return (value, score);
        }
    }
}
