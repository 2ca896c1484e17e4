//! Stiffness of the contact at the carrier, part by part, and the gap from it.
//!
//! Huloux 2021, Eq. 18 is the slope of the mean forces, k_c = −∂(f_r + f_s)/∂x. Air that cannot leave the film within a cycle
//! answers otherwise: a layer at the pressure p0 that changes its height x isothermally has the stiffness p0 S/x, thirty times that
//! of Eq. 18 at the forces of a finger. With a share α of such air,
//!
//! ```text
//! k_c = p_c S e^(−x/σ_t)/σ_t + (1 − α) 2 f_s/x + α p0 S/x
//! ```
//!
//! The published law has α = 0.

use crate::contact::Contact;
use crate::error::{ModelError, not_negative};
use crate::parameters::ContactSlopes;
use crate::root::increasing_root;

/// Parts of the stiffness at the carrier, N/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StiffnessParts {
    /// Asperities: f_r/σ_t.
    pub asperities: f64,
    /// Film whose air leaves it within a cycle: (1 − α) 2 f_s/x.
    pub film: f64,
    /// Trapped air: α p0 S/x.
    pub trapped: f64,
}

/// Derivatives of one part of the stiffness.
#[derive(Debug, Clone, Copy, Default)]
pub struct PartSlopes {
    /// Derivative by the gap, N/m².
    pub by_gap: f64,
    /// Derivatives by the contact at constant gap and amplitude, N/m.
    pub by_contact: ContactSlopes,
}

/// Smallest gap of a film with a negative share of trapped air that is looked for, relative to the largest possible one.
const SMALLEST_GAP: f64 = 1e-6;

impl Contact {
    /// Returns the parts of k_c at a gap and an amplitude, whether or not the forces balance.
    pub fn stiffness_parts_n_per_m(&self, gap_m: f64, amplitude_m: f64) -> StiffnessParts {
        StiffnessParts {
            asperities: self.asperity_n_per_m * (-gap_m / self.sigma_t_m).exp(),
            film: (1.0 - self.trapped_share) * (2.0 * self.squeeze_force_n(gap_m, amplitude_m))
                / gap_m,
            trapped: self.trapped_share * self.ambient_n / gap_m,
        }
    }

    /// Returns the derivatives of asperities, film and trapped air, in this order.
    pub fn stiffness_part_slopes(&self, gap_m: f64, amplitude_m: f64) -> [PartSlopes; 3] {
        let StiffnessParts {
            asperities,
            film,
            trapped,
        } = self.stiffness_parts_n_per_m(gap_m, amplitude_m);
        // Asperities are a e^(−u), u = x/σ_t; a = p_c S/σ_t does not depend on σ_t, and ∂e^(−u)/∂ln σ_t = u e^(−u). The film goes
        // as 1/x³, trapped air as 1/x.
        [
            PartSlopes {
                by_gap: -asperities / self.sigma_t_m,
                by_contact: ContactSlopes {
                    by_ln_sigma_t: asperities * (gap_m / self.sigma_t_m),
                    by_ln_area: asperities,
                    by_ln_q0: asperities,
                    ..ContactSlopes::default()
                },
            },
            PartSlopes {
                by_gap: -3.0 * film / gap_m,
                by_contact: ContactSlopes {
                    by_ln_area: film,
                    by_ln_film: film,
                    by_trapped_share: -2.0 * self.squeeze_force_n(gap_m, amplitude_m) / gap_m,
                    ..ContactSlopes::default()
                },
            },
            PartSlopes {
                by_gap: -trapped / gap_m,
                by_contact: ContactSlopes {
                    by_ln_area: trapped,
                    by_trapped_share: self.ambient_n / gap_m,
                    ..ContactSlopes::default()
                },
            },
        ]
    }

    /// Returns k_c = p_c S e^(−x/σ_t)/σ_t + 2 · (5/4) p0 S |x̃_p|²/x³, N/m (Huloux 2021, Eqs. 14, 15, 18), whether or
    /// not the forces balance: k_c = −∂(f_r + f_s)/∂x at constant amplitude; with the share of trapped air, if there is any.
    pub fn stiffness_n_per_m(&self, gap_m: f64, amplitude_m: f64) -> f64 {
        let parts = self.stiffness_parts_n_per_m(gap_m, amplitude_m);
        parts.asperities + (parts.film + parts.trapped)
    }

    /// Returns ∂k_c/∂x of [`stiffness_n_per_m`](Self::stiffness_n_per_m), N/m², negative at every gap of a positive stiffness.
    pub fn stiffness_slope_n_per_m2(&self, gap_m: f64, amplitude_m: f64) -> f64 {
        // ∂k_c/∂x = −f_r/σ_t² − (1 − α) 6 f_s/x² − α p0 S/x².
        let asperity = self.asperity_n_per_m * (-gap_m / self.sigma_t_m).exp();
        -asperity / self.sigma_t_m
            - (1.0 - self.trapped_share) * (6.0 * self.squeeze_force_n(gap_m, amplitude_m))
                / gap_m.powi(2)
            - self.trapped_share * self.ambient_n / gap_m.powi(2)
    }

    /// Returns the derivatives of [`stiffness_n_per_m`](Self::stiffness_n_per_m) by the contact at constant gap and amplitude,
    /// N/m.
    pub fn stiffness_slopes_n_per_m(&self, gap_m: f64, amplitude_m: f64) -> ContactSlopes {
        // k_c = a e^(−u) + 2 f_s/x; a = p_c S/σ_t does not depend on σ_t, and ∂e^(−u)/∂ln σ_t = u e^(−u).
        let u = gap_m / self.sigma_t_m;
        let asperity = self.asperity_n_per_m * (-u).exp();
        let open_film = 2.0 * self.squeeze_force_n(gap_m, amplitude_m) / gap_m;
        let squeeze = (1.0 - self.trapped_share) * open_film;
        let closed_film = self.ambient_n / gap_m;
        ContactSlopes {
            by_ln_sigma_t: asperity * u,
            by_ln_area: asperity + squeeze + self.trapped_share * closed_film,
            by_ln_q0: asperity,
            by_ln_film: squeeze,
            by_ln_force: 0.0,
            by_trapped_share: closed_film - open_film,
        }
    }

    /// Returns the gap at which [`stiffness_n_per_m`](Self::stiffness_n_per_m) is `k_c_n_per_m` at this amplitude, m. It needs
    /// neither the normal force nor a steady state, and is unique for every stiffness.
    ///
    /// # Errors
    /// If the amplitude is negative, the stiffness not positive, or, at zero amplitude without trapped air, the stiffness not below
    /// p_c S/σ_t.
    pub fn gap_from_stiffness_m(
        &self,
        k_c_n_per_m: f64,
        amplitude_m: f64,
    ) -> Result<f64, ModelError> {
        not_negative("amplitude", "m", amplitude_m)?;
        // k_c = a e^(−u) + q/u³ + t/u with u = x/σ_t, a = p_c S/σ_t, q = (1 − α) 2 · (5/4) p0 S |x̃_p|²/σ_t³ and t = α p0 S/σ_t.
        let squeeze = (1.0 - self.trapped_share)
            * (2.0 * self.squeeze_scale_n() * amplitude_m.powi(2) / self.sigma_t_m.powi(3));
        let trapped = self.trapped_share * self.ambient_n / self.sigma_t_m;
        let possible = k_c_n_per_m.is_finite()
            && k_c_n_per_m > 0.0
            && squeeze.is_finite()
            && (squeeze > 0.0 || trapped > 0.0 || k_c_n_per_m < self.asperity_n_per_m);
        if !possible {
            return Err(ModelError::NoGapForStiffness {
                k_c_n_per_m,
                limit_n_per_m: self.asperity_n_per_m,
            });
        }
        // Each term alone gives a lower bound, u ≥ ln(a/k_c), u ≥ ∛(q/k_c) and u ≥ t/k_c; each term at its part of the target,
        // a half or a third, gives an upper bound. With t < 0 the root lies below that without t. There k_c > 0 makes
        // q/u³ > |t|/u − a e^(−u), and k_c falls in u as without t.
        let single_term = |target: f64| {
            let open = (self.asperity_n_per_m / target)
                .ln()
                .max((squeeze / target).cbrt());
            if trapped > 0.0 {
                open.max(trapped / target)
            } else {
                open
            }
        };
        let parts = if trapped > 0.0 { 3.0 } else { 2.0 };
        let hi = single_term(k_c_n_per_m / parts);
        let lo = if trapped < 0.0 {
            SMALLEST_GAP * hi
        } else {
            single_term(k_c_n_per_m)
        };
        // f(u) = k_c − a e^(−u) − q/u³ − t/u,    f′ = a e^(−u) + 3 q/u⁴ + t/u² > 0,    f″ = −a e^(−u) − 12 q/u⁵ − 2 t/u³.
        let u = increasing_root(lo, hi, lo.max(single_term(k_c_n_per_m).min(hi)), |u| {
            let asperity = self.asperity_n_per_m * (-u).exp();
            let film = squeeze / (u * u * u);
            let trapped = trapped / u;
            (
                k_c_n_per_m - asperity - film - trapped,
                asperity + 3.0 * film / u + trapped / u,
                -asperity - 12.0 * film / (u * u) - 2.0 * trapped / (u * u),
            )
        });
        Ok(u * self.sigma_t_m)
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::assumed::AssumedConstants;

    const AMPLITUDE_M: f64 = 2e-6;

    fn contact(trapped_share: f64) -> Contact {
        Contact::new(&AssumedConstants::default(), 1.7e-6)
            .unwrap()
            .with_film(0.8, trapped_share)
            .with_asperity_ratio(1.3)
    }

    #[test]
    fn the_parts_add_up() {
        for trapped_share in [0.0, 0.02, 0.5, -0.004] {
            let contact = contact(trapped_share);
            for gap_m in [4e-6, 8e-6, 12e-6] {
                let parts = contact.stiffness_parts_n_per_m(gap_m, AMPLITUDE_M);
                let k_c = contact.stiffness_n_per_m(gap_m, AMPLITUDE_M);
                let sum = parts.asperities + parts.film + parts.trapped;
                assert_relative_eq!(sum, k_c, max_relative = 1e-14);
                let slopes = contact.stiffness_part_slopes(gap_m, AMPLITUDE_M);
                let by_gap: f64 = slopes.iter().map(|slopes| slopes.by_gap).sum();
                let expected = contact.stiffness_slope_n_per_m2(gap_m, AMPLITUDE_M);
                assert_relative_eq!(by_gap, expected, max_relative = 1e-14);
                let step_m = 1e-6 * gap_m;
                let k_c_at = |gap_m: f64| contact.stiffness_n_per_m(gap_m, AMPLITUDE_M);
                let slope = (k_c_at(gap_m + step_m) - k_c_at(gap_m - step_m)) / (2.0 * step_m);
                assert_relative_eq!(by_gap, slope, max_relative = 1e-8);
                let total = contact.stiffness_slopes_n_per_m(gap_m, AMPLITUDE_M);
                let sum = |field: fn(&ContactSlopes) -> f64| {
                    slopes
                        .iter()
                        .map(|slopes| field(&slopes.by_contact))
                        .sum::<f64>()
                };
                for field in [
                    |slopes: &ContactSlopes| slopes.by_ln_sigma_t,
                    |slopes: &ContactSlopes| slopes.by_ln_area,
                    |slopes: &ContactSlopes| slopes.by_ln_q0,
                    |slopes: &ContactSlopes| slopes.by_ln_film,
                    |slopes: &ContactSlopes| slopes.by_trapped_share,
                ] {
                    assert_relative_eq!(sum(field), field(&total), max_relative = 1e-12);
                }
            }
        }
    }

    #[test]
    fn the_gap_follows_from_the_stiffness_with_trapped_air() {
        for trapped_share in [0.0, 1e-4, 0.02, 0.5, 1.0, -0.004] {
            let contact = contact(trapped_share);
            for (gap_m, amplitude_m) in [(4e-6, AMPLITUDE_M), (8e-6, AMPLITUDE_M), (12e-6, 4e-6)] {
                let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
                let found_m = contact.gap_from_stiffness_m(k_c, amplitude_m).unwrap();
                assert_relative_eq!(found_m, gap_m, max_relative = 1e-9);
            }
        }
    }
}
