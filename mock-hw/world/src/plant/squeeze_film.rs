//! Squeeze film and asperities under the finger: mean gap, stiffness, friction (`Huloux 2021`, Eqs. 13–19).

use crate::scenario::FilmTable;

/// Gap at which [`FilmTable::lag_s`] holds, m.
const LAG_REFERENCE_GAP_M: f64 = 10e-6;

/// The film for one asperity scale σ_t.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SqueezeFilm {
    sigma_m: f64,
    /// Asperity force p_c S at zero gap, N.
    asperity_n: f64,
    /// Levitation force (5/4) p0 S where the amplitude equals the gap, N.
    squeeze_n: f64,
    loss_factor: f64,
    lag_s: f64,
    lag_gap_exponent: f64,
}

impl SqueezeFilm {
    pub fn new(film: &FilmTable, sigma_m: f64) -> Self {
        let modulus_pa = film.youngs_modulus_pa / (1.0 - film.poisson_ratio.powi(2));
        let asperity_pa = 0.375 * film.q0_rad_per_m * sigma_m * modulus_pa;
        Self {
            sigma_m,
            asperity_n: asperity_pa * film.contact_area_m2,
            squeeze_n: 1.25 * film.ambient_pressure_pa * film.contact_area_m2,
            loss_factor: film.loss_factor,
            lag_s: film.lag_s,
            lag_gap_exponent: film.lag_gap_exponent,
        }
    }

    /// Returns the force carried by the asperities, N.
    pub fn asperity_force(&self, gap_m: f64) -> f64 {
        self.asperity_n * (-gap_m / self.sigma_m).exp()
    }

    /// Returns the levitation force for a squared peak amplitude, N.
    pub fn squeeze_force(&self, gap_m: f64, amplitude2_m2: f64) -> f64 {
        self.squeeze_n * amplitude2_m2 / gap_m.powi(2)
    }

    /// Returns the gap without vibration, m.
    pub fn rest_gap(&self, normal_n: f64) -> f64 {
        self.sigma_m * (self.asperity_n / normal_n).ln()
    }

    /// Returns the gap at which both forces together carry `normal_n`, m; a good `guess_m` saves iterations.
    ///
    /// Force falls convexly with gap, so Newton's method from the left of the root never oversteps it.
    pub fn equilibrium(&self, normal_n: f64, amplitude2_m2: f64, guess_m: f64) -> f64 {
        let least = self.rest_gap(normal_n);
        let mut gap = guess_m.max(least);
        for _ in 0..60 {
            let (asperity, squeeze) = (
                self.asperity_force(gap),
                self.squeeze_force(gap, amplitude2_m2),
            );
            let slope = asperity / self.sigma_m + 2.0 * squeeze / gap;
            let next = (gap + (asperity + squeeze - normal_n) / slope).max(least);
            let step = next - gap;
            gap = next;
            if step.abs() < 1e-12 * gap {
                break;
            }
        }
        gap
    }

    /// Returns the contact stiffness k_c, N/m.
    pub fn stiffness(&self, gap_m: f64, amplitude2_m2: f64) -> f64 {
        self.asperity_force(gap_m) / self.sigma_m
            + 2.0 * self.squeeze_force(gap_m, amplitude2_m2) / gap_m
    }

    /// Returns the loss factor η of the contact.
    pub fn loss_factor(&self) -> f64 {
        self.loss_factor
    }

    /// Returns the time constant of the gap, s.
    pub fn lag(&self, gap_m: f64) -> f64 {
        self.lag_s * (gap_m / LAG_REFERENCE_GAP_M).powf(self.lag_gap_exponent)
    }

    /// Returns friction relative to rest: the share of the normal force that asperities carry, at most 1.
    pub fn relative_friction(&self, gap_m: f64, normal_n: f64) -> f64 {
        (self.asperity_force(gap_m) / normal_n).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn published() -> SqueezeFilm {
        let scenario = FilmTable {
            contact_area_m2: 314e-6,
            ..FilmTable::default()
        };
        SqueezeFilm::new(&scenario, 2e-6)
    }

    /// Independent of Newton: bisection on the force balance.
    fn bisected(film: &SqueezeFilm, normal_n: f64, amplitude2: f64) -> f64 {
        let (mut low, mut high) = (film.rest_gap(normal_n), 1e-2);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if film.asperity_force(middle) + film.squeeze_force(middle, amplitude2) > normal_n {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    #[test]
    fn forces_in_closed_form() {
        let film = published();
        // 0.375 · 1.4e4 · 2e-6 · 20e6/0.75 · 314e-6 = 87.92 N at zero gap, 1/e of it at σ_t
        assert_relative_eq!(
            film.asperity_force(2e-6),
            87.92 / std::f64::consts::E,
            max_relative = 1e-12
        );
        // 1.25 · 101325 · 314e-6 · (1/10)² N
        assert_relative_eq!(
            film.squeeze_force(10e-6, 1e-12),
            0.397_700_6,
            max_relative = 1e-6
        );
        assert_relative_eq!(
            film.asperity_force(film.rest_gap(0.65)),
            0.65,
            max_relative = 1e-12
        );
    }

    #[test]
    fn equilibrium_is_the_root_from_any_guess() {
        let film = published();
        for normal_n in [0.01, 0.1, 0.65, 1.0, 5.0] {
            for amplitude_m in [0.0f64, 0.05e-6, 0.5e-6, 2e-6, 5e-6, 10e-6] {
                let expected = bisected(&film, normal_n, amplitude_m.powi(2));
                for guess_m in [0.0, 8e-6, 200e-6] {
                    let found = film.equilibrium(normal_n, amplitude_m.powi(2), guess_m);
                    assert_relative_eq!(found, expected, max_relative = 1e-9);
                }
            }
        }
    }

    #[test]
    fn stiffness_falls_to_one_eighth_at_5_um_and_1_n() {
        // SCIENCE section 7: Eqs. 17–18 with σ_t = 2 µm and S = 314 mm² give a decrease of 87 %
        let film = published();
        let gap = film.equilibrium(1.0, 25e-12, 0.0);
        let rest = film.stiffness(film.rest_gap(1.0), 0.0);
        assert_relative_eq!(rest, 1.0 / 2e-6, max_relative = 1e-12);
        assert_relative_eq!(film.stiffness(gap, 25e-12) / rest, 0.127, epsilon = 2e-3);
    }

    #[test]
    fn friction_falls_with_amplitude_and_recovers_with_force() {
        let film = published();
        let friction = |normal_n: f64, amplitude_m: f64| {
            let gap = film.equilibrium(normal_n, amplitude_m.powi(2), 0.0);
            film.relative_friction(gap, normal_n)
        };
        let mut last = 1.0 + 1e-9;
        for i in 0..60 {
            let now = friction(0.65, 0.05e-6 * f64::from(i));
            assert!(now < last, "not monotone at step {i}");
            last = now;
        }
        assert!(friction(5.0, 1e-6) > friction(1.0, 1e-6));
        assert_relative_eq!(friction(0.65, 0.0), 1.0, max_relative = 1e-12);
    }
}
