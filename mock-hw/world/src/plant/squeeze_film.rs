//! Squeeze film and asperities under the finger: mean gap, stiffness, friction (`Huloux 2021`, Eqs. 13–19), and alternatives to
//! the published laws.

use super::heights::Heights;
use crate::fingertip::Pad;
use crate::scenario::LawsTable;

/// Reference gap of [`Pad::lag_s`], m.
const LAG_REFERENCE_GAP_M: f64 = 10e-6;
/// Reference stiffness of [`Pad::loss_factor`] if the loss factor depends on it, N/m.
const LOSS_REFERENCE_N_PER_M: f64 = 1e5;
/// Least gap, m, for a load that the asperities cannot carry at any gap.
const LEAST_GAP_M: f64 = 10e-9;
/// Greatest factor of the loss factor for a contact stiffer than the reference.
const MOST_LOSS: f64 = 3.0;
/// Least and greatest factor of Z_t: the tissue of a barely touching finger still has an impedance.
const TISSUE_FACTORS: [f64; 2] = [0.2, 5.0];
/// Upper bound of the gap, m; never reached by a finger.
const GREATEST_GAP_M: f64 = 5e-3;

/// Deviations from the published laws.
#[derive(Debug, Clone)]
pub(crate) struct Laws {
    laws: LawsTable,
    heights: Option<Heights>,
}

impl Laws {
    pub fn new(laws: &LawsTable) -> Self {
        Self {
            laws: laws.clone(),
            heights: laws.asperity_cutoff.map(Heights::new),
        }
    }

    /// Returns the factor of Z_t under a normal force.
    pub fn tissue_factor(&self, normal_n: f64) -> f64 {
        if self.laws.tissue_force_exponent == 0.0 {
            return 1.0;
        }
        let [least, most] = TISSUE_FACTORS;
        normal_n
            .powf(self.laws.tissue_force_exponent)
            .clamp(least, most)
    }

    /// Returns whether the force is a convex function of the gap, as in the published laws.
    fn are_convex(&self) -> bool {
        self.heights.is_none() && self.laws.adhesion_n == 0.0 && self.laws.leak_gap_m.is_none()
    }
}

/// The film for one asperity scale σ_t and one contact area.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SqueezeFilm<'a> {
    laws: &'a Laws,
    sigma_m: f64,
    /// Asperity force p_c S at zero gap, N.
    asperity_n: f64,
    /// Levitation force (5/4) p0 S at an amplitude equal to the gap, N.
    squeeze_n: f64,
    loss_factor: f64,
    lag_s: f64,
    lag_gap_exponent: f64,
}

impl<'a> SqueezeFilm<'a> {
    pub fn new(
        laws: &'a Laws,
        pad: &Pad,
        ambient_pressure_pa: f64,
        sigma_m: f64,
        area_m2: f64,
    ) -> Self {
        let modulus_pa = pad.youngs_modulus_pa / (1.0 - pad.poisson_ratio.powi(2));
        let asperity_pa = 0.375 * pad.q0_rad_per_m * sigma_m * modulus_pa;
        Self {
            laws,
            sigma_m,
            asperity_n: asperity_pa * area_m2,
            squeeze_n: 1.25 * ambient_pressure_pa * area_m2,
            loss_factor: pad.loss_factor,
            lag_s: pad.lag_s,
            lag_gap_exponent: pad.lag_gap_exponent,
        }
    }

    /// Returns the force carried by the asperities, N.
    pub fn asperity_force(&self, gap_m: f64) -> f64 {
        self.asperity_n
            * match &self.laws.heights {
                None => (-gap_m / self.sigma_m).exp(),
                Some(heights) => heights.force(gap_m, self.sigma_m),
            }
    }

    /// Returns the levitation force for a squared peak amplitude, N.
    pub fn squeeze_force(&self, gap_m: f64, amplitude2_m2: f64) -> f64 {
        let share = match self.laws.laws.leak_gap_m {
            None => 1.0,
            Some(leak_gap_m) => 1.0 / (1.0 + (gap_m / leak_gap_m).powi(4)),
        };
        self.squeeze_n * amplitude2_m2 / gap_m.powi(2) * share
    }

    /// Returns the attraction between skin and plate, N.
    fn adhesion_force(&self, gap_m: f64) -> f64 {
        let laws = &self.laws.laws;
        if laws.adhesion_n == 0.0 {
            return 0.0;
        }
        laws.adhesion_n * (-gap_m / laws.adhesion_range_m).exp()
    }

    /// Returns the gap without vibration, m.
    pub fn rest_gap(&self, normal_n: f64) -> f64 {
        if self.laws.are_convex() {
            (self.sigma_m * (self.asperity_n / normal_n).ln()).max(LEAST_GAP_M)
        } else {
            self.bracketed_root(normal_n, 0.0, 5.0 * self.sigma_m)
        }
    }

    /// Returns the gap at which the total force equals `normal_n`, m; a good `guess_m` saves iterations.
    pub fn equilibrium(&self, normal_n: f64, amplitude2_m2: f64, guess_m: f64) -> f64 {
        if self.laws.are_convex() {
            self.convex_root(normal_n, amplitude2_m2, guess_m)
        } else {
            self.bracketed_root(normal_n, amplitude2_m2, guess_m)
        }
    }

    /// Returns the root of a convex force: Newton's method from the left never overshoots.
    fn convex_root(&self, normal_n: f64, amplitude2_m2: f64, guess_m: f64) -> f64 {
        let least_gap = self.rest_gap(normal_n);
        let mut gap = guess_m.max(least_gap);
        for _ in 0..60 {
            let (asperity, squeeze) = (
                self.asperity_force(gap),
                self.squeeze_force(gap, amplitude2_m2),
            );
            let slope = asperity / self.sigma_m + 2.0 * squeeze / gap;
            let next = (gap + (asperity + squeeze - normal_n) / slope).max(least_gap);
            let step = next - gap;
            gap = next;
            if step.abs() < 1e-12 * gap {
                break;
            }
        }
        gap
    }

    /// Returns the root by Newton's method within a shrinking bracket.
    fn bracketed_root(&self, normal_n: f64, amplitude2_m2: f64, guess_m: f64) -> f64 {
        let (mut low, mut high) = (LEAST_GAP_M, GREATEST_GAP_M);
        let mut gap = guess_m.clamp(low, high);
        for _ in 0..80 {
            let excess_n = self.asperity_force(gap) + self.squeeze_force(gap, amplitude2_m2)
                - self.adhesion_force(gap)
                - normal_n;
            if excess_n > 0.0 {
                low = gap;
            } else {
                high = gap;
            }
            let next = gap + excess_n / self.stiffness(gap, amplitude2_m2);
            let next = if next > low && next < high {
                next
            } else {
                0.5 * (low + high)
            };
            let step = next - gap;
            gap = next;
            if step.abs() < 1e-12 * gap {
                break;
            }
        }
        gap
    }

    /// Returns the contact stiffness k_c, N/m: the negative derivative of the force with respect to the gap.
    pub fn stiffness(&self, gap_m: f64, amplitude2_m2: f64) -> f64 {
        let asperities = match &self.laws.heights {
            None => self.asperity_force(gap_m) / self.sigma_m,
            Some(heights) => self.asperity_n * heights.slope_per_m(gap_m, self.sigma_m),
        };
        let squeeze_n = self.squeeze_force(gap_m, amplitude2_m2);
        let squeeze_slope = match self.laws.laws.leak_gap_m {
            None => 2.0 * squeeze_n / gap_m,
            Some(leak_gap_m) => {
                let leaks = (gap_m / leak_gap_m).powi(4);
                (2.0 + 4.0 * leaks / (1.0 + leaks)) * squeeze_n / gap_m
            }
        };
        let adhesion_slope = self.adhesion_force(gap_m) / self.laws.laws.adhesion_range_m;
        asperities + squeeze_slope - adhesion_slope
    }

    /// Returns the loss factor η of a contact of this stiffness.
    pub fn loss_factor(&self, k_c_n_per_m: f64) -> f64 {
        let exponent = self.laws.laws.loss_exponent;
        if exponent == 0.0 || k_c_n_per_m <= 0.0 {
            return self.loss_factor;
        }
        let stiffer = k_c_n_per_m / LOSS_REFERENCE_N_PER_M;
        // The limit keeps a stiff contact from acting as a rigid dashpot.
        self.loss_factor * stiffer.powf(exponent).min(stiffer.recip().max(MOST_LOSS))
    }

    /// Returns the time constant of the gap, s.
    pub fn lag(&self, gap_m: f64) -> f64 {
        self.lag_s * (gap_m / LAG_REFERENCE_GAP_M).powf(self.lag_gap_exponent)
    }

    /// Returns the asperities' force relative to that at rest under `normal_n`, at most 1.
    pub fn relative_asperities(&self, gap_m: f64, normal_n: f64) -> f64 {
        let at_rest_n = if self.laws.laws.adhesion_n == 0.0 {
            normal_n
        } else {
            self.asperity_force(self.rest_gap(normal_n))
        };
        (self.asperity_force(gap_m) / at_rest_n).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::scenario::Scenario;

    fn film(laws: &Laws) -> SqueezeFilm<'_> {
        let pad = Pad::draw(&Scenario::default(), 1);
        SqueezeFilm::new(laws, &pad, 101_325.0, 2e-6, 314e-6)
    }

    fn published_laws() -> Laws {
        Laws::new(&LawsTable::default())
    }

    /// Root of the force balance by bisection, independent of Newton's method.
    fn bisect(film: &SqueezeFilm<'_>, normal_n: f64, amplitude2: f64) -> f64 {
        let (mut low, mut high) = (1e-7, 1e-2);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            let pushing_n = film.asperity_force(middle) + film.squeeze_force(middle, amplitude2);
            if pushing_n - film.adhesion_force(middle) > normal_n {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    #[test]
    fn forces_in_closed_form() {
        let laws = published_laws();
        let film = film(&laws);
        // 0.375 · 1.4e4 · 2e-6 · 20e6/0.75 · 314e-6 = 87.92 N at zero gap, 1/e of it at σ_t.
        assert_relative_eq!(
            film.asperity_force(2e-6),
            87.92 / std::f64::consts::E,
            max_relative = 1e-12
        );
        // 1.25 · 101325 · 314e-6 · (1/10)² N.
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
        let laws = published_laws();
        let film = film(&laws);
        for normal_n in [0.01, 0.1, 0.65, 1.0, 5.0] {
            for amplitude_m in [0.0f64, 0.05e-6, 0.5e-6, 2e-6, 5e-6, 10e-6] {
                let expected = bisect(&film, normal_n, amplitude_m.powi(2));
                for guess_m in [0.0, 8e-6, 200e-6] {
                    let gap_m = film.equilibrium(normal_n, amplitude_m.powi(2), guess_m);
                    assert_relative_eq!(gap_m, expected, max_relative = 1e-9);
                }
            }
        }
    }

    #[test]
    fn stiffness_falls_to_one_eighth_at_5_um_and_1_n() {
        // SCIENCE section 7: Eqs. 17–18 with σ_t = 2 µm and S = 314 mm² give a decrease of 87 %.
        let laws = published_laws();
        let film = film(&laws);
        let gap = film.equilibrium(1.0, 25e-12, 0.0);
        let rest = film.stiffness(film.rest_gap(1.0), 0.0);
        assert_relative_eq!(rest, 1.0 / 2e-6, max_relative = 1e-12);
        assert_relative_eq!(film.stiffness(gap, 25e-12) / rest, 0.127, epsilon = 2e-3);
    }

    #[test]
    fn friction_falls_with_amplitude_and_recovers_with_force() {
        let laws = published_laws();
        let film = film(&laws);
        let friction = |normal_n: f64, amplitude_m: f64| {
            let gap = film.equilibrium(normal_n, amplitude_m.powi(2), 0.0);
            film.relative_asperities(gap, normal_n)
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

    fn broken_laws() -> [LawsTable; 4] {
        [
            LawsTable {
                asperity_cutoff: Some(3.5),
                ..LawsTable::default()
            },
            LawsTable {
                adhesion_n: 0.1,
                ..LawsTable::default()
            },
            LawsTable {
                leak_gap_m: Some(12e-6),
                ..LawsTable::default()
            },
            LawsTable {
                asperity_cutoff: Some(2.5),
                adhesion_n: 1.0,
                leak_gap_m: Some(2e-6),
                ..LawsTable::default()
            },
        ]
    }

    #[test]
    fn broken_laws_have_a_root_from_any_guess_and_a_stiffness_that_is_the_slope() {
        for table in broken_laws() {
            let laws = Laws::new(&table);
            let film = film(&laws);
            for normal_n in [0.01, 0.1, 0.65, 5.0] {
                for amplitude_m in [0.0f64, 0.5e-6, 2e-6, 5e-6] {
                    let expected = bisect(&film, normal_n, amplitude_m.powi(2));
                    for guess_m in [0.0, 8e-6, 200e-6] {
                        let gap_m = film.equilibrium(normal_n, amplitude_m.powi(2), guess_m);
                        assert_relative_eq!(gap_m, expected, max_relative = 1e-6);
                    }
                    let force = |gap_m: f64| {
                        film.asperity_force(gap_m) + film.squeeze_force(gap_m, amplitude_m.powi(2))
                            - film.adhesion_force(gap_m)
                    };
                    let step_m = 1e-3 * expected;
                    let slope =
                        (force(expected - step_m) - force(expected + step_m)) / (2.0 * step_m);
                    let stiffness = film.stiffness(expected, amplitude_m.powi(2));
                    assert_relative_eq!(stiffness, slope, max_relative = 0.03);
                }
            }
        }
    }

    #[test]
    fn the_loss_factor_and_the_tissue_follow_their_exponents() {
        let laws = Laws::new(&LawsTable {
            loss_exponent: -1.0,
            tissue_force_exponent: 0.5,
            ..LawsTable::default()
        });
        let film = film(&laws);
        let damping = |k_c: f64| film.loss_factor(k_c) * k_c;
        assert_relative_eq!(damping(4e5), damping(1e4), max_relative = 1e-12);
        assert_relative_eq!(laws.tissue_factor(0.25), 0.5, max_relative = 1e-12);
        assert_eq!(published_laws().tissue_factor(0.25), 1.0);
    }

    #[test]
    fn a_load_that_the_asperities_cannot_carry_has_a_least_gap() {
        let laws = published_laws();
        let film = film(&laws);
        assert_eq!(film.rest_gap(1e3), LEAST_GAP_M);
        assert!(film.equilibrium(1e3, 0.0, 0.0).is_finite());
    }
}
