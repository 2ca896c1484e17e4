//! Signs that an instance does not follow the laws by which `paper` or `dynamic` fits it.
//!
//! Both methods assume S, q0, E, ν and η: a finger with other constants does not follow their laws either. The limits lie beyond
//! all simulated fingers that follow them, and have no effect on the fit:
//!
//! | sign | `paper` | `dynamic` |
//! | --- | --- | --- |
//! | σ_t | below 0.5 or above 5 µm | below 0.5 or above 3.5 µm |
//! | RMS residual of Z_m over its standard deviation in the instance, and over its noise | 0.6 and 4 | 0.006 and 4 |
//! | RMS of estimated − measured μ | 0.45 μ0 | 0.03 |
//! | Re Z_t | – | under −0.05 N·s/m by three standard errors |
//!
//! `paper` neglects envelope and lag. In a world of its own laws it reads σ_t 50 to 100 % high, leaves up to half of the change of
//! Z_m unexplained, reads friction up to 0.4 μ0 off and Re Z_t below 0 (docs/accuracy.md): its limits allow for this bias.
//! The noise of Z_m is estimated from the second differences of the residual, which laws that do not hold leave smooth.

use std::fmt;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::fit_agreement::Agreement;

/// A sign that an instance does not follow the laws of the method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum InstanceMisfit {
    /// A roughness that no finger has.
    Roughness {
        /// σ_t, m.
        sigma_t_m: f64,
        /// Nearest σ_t within the limits, m.
        limit_m: f64,
    },
    /// Tissues that give power to the plate.
    Tissue {
        /// Re Z_t, N·s/m.
        re_z_t_n_s_per_m: f64,
    },
    /// A residual of the impedance with a structure that its noise does not have.
    Impedance {
        /// RMS of the residual relative to the standard deviation of Z_m over the instance.
        part: f64,
        /// RMS of the residual relative to its noise.
        noise_ratio: f64,
    },
    /// Friction from the impedance that differs from the measured one.
    Friction {
        /// RMS of estimated − measured friction.
        rms_mu: f64,
    },
}

impl fmt::Display for InstanceMisfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Roughness { sigma_t_m, limit_m } => write!(
                f,
                "σ_t would be {:.1} µm, {} the range of fingers",
                sigma_t_m * 1e6,
                if sigma_t_m > limit_m {
                    "above"
                } else {
                    "below"
                }
            ),
            Self::Tissue { re_z_t_n_s_per_m } => write!(
                f,
                "the tissues would give power to the plate: Re Z_t would be {re_z_t_n_s_per_m:.2} N·s/m"
            ),
            Self::Impedance { part, noise_ratio } => write!(
                f,
                "the impedance of the fit is off the measured one by {:.1} % of its change (RMS), {noise_ratio:.0} times \
                 the noise",
                part * 100.0
            ),
            Self::Friction { rms_mu } => write!(
                f,
                "friction that follows from the impedance is {rms_mu:.3} off the measured one (RMS)"
            ),
        }
    }
}

/// Limits of a method.
pub(super) struct Limits {
    /// Smallest and largest σ_t, m.
    pub(super) sigma_t_m: [f64; 2],
    /// Smallest Re Z_t, N·s/m; negative infinity if the method may read any.
    pub(super) re_z_t_n_s_per_m: f64,
    /// Largest RMS residual of Z_m relative to the standard deviation of Z_m over the instance.
    pub(super) residual_part: f64,
    /// Largest RMS of estimated − measured friction.
    pub(super) rms_mu: f64,
}

/// Results of a fit from which its signs of misfit follow.
pub(super) struct Judged<'a> {
    pub(super) sigma_t_m: f64,
    /// Re Z_t and its standard error, N·s/m.
    pub(super) re_z_t_n_s_per_m: [f64; 2],
    pub(super) agreement: &'a Agreement,
    /// Measured impedance, N·s/m.
    pub(super) z_m: &'a [Complex64],
    /// Impedance of the fit, N·s/m.
    pub(super) z_m_model: &'a [Complex64],
}

/// Number of standard errors by which Re Z_t must be below its limit.
const TISSUE_DEVIATIONS: f64 = 3.0;
/// Largest RMS residual relative to its noise. Where it is larger in worlds of the laws of `dynamic`, it is because noise is small:
/// the residual is then under 0.004 of the standard deviation of Z_m.
const MAX_NOISE_RATIO: f64 = 4.0;

impl Limits {
    /// Returns the signs of misfit of a fit.
    pub(super) fn signs(&self, fit: &Judged<'_>) -> Vec<InstanceMisfit> {
        [
            self.roughness(fit.sigma_t_m),
            self.tissue(fit.re_z_t_n_s_per_m),
            self.impedance(fit),
            self.friction(fit.agreement.rms_mu),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn roughness(&self, sigma_t_m: f64) -> Option<InstanceMisfit> {
        let [low_m, high_m] = self.sigma_t_m;
        let limit_m = sigma_t_m.clamp(low_m, high_m);
        (limit_m != sigma_t_m).then_some(InstanceMisfit::Roughness { sigma_t_m, limit_m })
    }

    fn tissue(&self, [re_z_t_n_s_per_m, std]: [f64; 2]) -> Option<InstanceMisfit> {
        let greatest = re_z_t_n_s_per_m + TISSUE_DEVIATIONS * std;
        (greatest < self.re_z_t_n_s_per_m).then_some(InstanceMisfit::Tissue { re_z_t_n_s_per_m })
    }

    fn impedance(&self, fit: &Judged<'_>) -> Option<InstanceMisfit> {
        let part = (1.0 - fit.agreement.r2_impedance).max(0.0).sqrt();
        let residuals: Vec<Complex64> = fit
            .z_m
            .iter()
            .zip(fit.z_m_model)
            .map(|(z, model)| z - model)
            .collect();
        let noise_ratio = fit.agreement.rms_impedance_n_s_per_m / noise_n_s_per_m(&residuals);
        (part > self.residual_part && noise_ratio > MAX_NOISE_RATIO)
            .then_some(InstanceMisfit::Impedance { part, noise_ratio })
    }

    fn friction(&self, rms_mu: f64) -> Option<InstanceMisfit> {
        (rms_mu > self.rms_mu).then_some(InstanceMisfit::Friction { rms_mu })
    }
}

/// Returns the RMS of the noise in residuals, from their second differences: for white noise of variance σ²,
/// E|r₋₁ − 2r₀ + r₁|² = 6σ².
fn noise_n_s_per_m(residuals: &[Complex64]) -> f64 {
    let squares = residuals
        .windows(3)
        .map(|three| (three[0] - 2.0 * three[1] + three[2]).norm_sqr());
    let differences = residuals.len().saturating_sub(2) as f64;
    (squares.sum::<f64>() / differences / 6.0).sqrt()
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    const LIMITS: Limits = Limits {
        sigma_t_m: [0.5e-6, 3.5e-6],
        re_z_t_n_s_per_m: -0.05,
        residual_part: 0.006,
        rms_mu: 0.03,
    };

    fn white_noise(std: f64) -> Vec<Complex64> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        (0..2000)
            .map(|_| std * Complex64::new(normal(), normal()))
            .collect()
    }

    #[test]
    fn noise_is_told_from_a_smooth_residual() {
        let noise = white_noise(0.01);
        let estimate = noise_n_s_per_m(&noise);
        // Two components.
        assert!(
            (estimate / (0.01 * 2.0_f64.sqrt()) - 1.0).abs() < 0.1,
            "{estimate}"
        );
        let smooth = |n: usize| Complex64::new((0.01 * n as f64).sin(), 0.3);
        let both: Vec<Complex64> = noise
            .iter()
            .enumerate()
            .map(|(n, r)| r + smooth(n))
            .collect();
        assert!((noise_n_s_per_m(&both) / estimate - 1.0).abs() < 0.01);
    }

    /// A fit with no sign of misfit; each sign is given by one changed value alone.
    #[test]
    fn each_sign_has_its_limit() {
        let z_m = white_noise(1.0);
        let noise = white_noise(1e-4);
        let model_with = |smooth_error: f64| -> Vec<Complex64> {
            let rows = z_m.iter().zip(&noise).enumerate();
            rows.map(|(n, (z, noise))| z + noise + smooth_error * (0.01 * n as f64).sin())
                .collect()
        };
        let signs = |sigma_t_m: f64, re_z_t: [f64; 2], smooth_error: f64, rms_mu: f64| {
            let z_m_model = model_with(smooth_error);
            let pairs = z_m.iter().zip(&z_m_model);
            let squares: f64 = pairs.map(|(z, model)| (z - model).norm_sqr()).sum();
            let agreement = Agreement {
                r2_impedance: 1.0 - squares / (2.0 * z_m.len() as f64),
                rms_impedance_n_s_per_m: (squares / z_m.len() as f64).sqrt(),
                rms_mu,
            };
            LIMITS.signs(&Judged {
                sigma_t_m,
                re_z_t_n_s_per_m: re_z_t,
                agreement: &agreement,
                z_m: &z_m,
                z_m_model: &z_m_model,
            })
        };
        let sound = (1.7e-6, [0.47, 0.01]);
        assert_eq!(signs(sound.0, sound.1, 5e-3, 0.02), []);
        assert_eq!(signs(sound.0, [-0.04, 0.001], 5e-3, f64::NAN), []);
        let only = |signs: Vec<InstanceMisfit>| {
            assert_eq!(signs.len(), 1, "{signs:?}");
            signs[0].to_string()
        };
        assert_eq!(
            only(signs(4.2e-6, sound.1, 0.0, 0.02)),
            "σ_t would be 4.2 µm, above the range of fingers"
        );
        assert_eq!(
            only(signs(0.3e-6, sound.1, 0.0, 0.02)),
            "σ_t would be 0.3 µm, below the range of fingers"
        );
        assert_eq!(
            only(signs(sound.0, [-0.2, 0.04], 0.0, 0.02)),
            "the tissues would give power to the plate: Re Z_t would be -0.20 N·s/m"
        );
        assert_eq!(signs(sound.0, [-0.2, 0.06], 0.0, 0.02), []);
        let impedance = only(signs(sound.0, sound.1, 0.05, 0.02));
        assert!(
            impedance.starts_with(
                "the impedance of the fit is off the measured one by 2.5 % of its change (RMS), "
            ),
            "{impedance}"
        );
        assert_eq!(
            only(signs(sound.0, sound.1, 0.0, 0.04)),
            "friction that follows from the impedance is 0.040 off the measured one (RMS)"
        );
    }
}
