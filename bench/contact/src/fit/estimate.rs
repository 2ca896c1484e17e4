use nalgebra::{SMatrix, SVector};
use num_complex::Complex64;

use super::{Agreement, EstimatedSeries, FitConditions, FitError, Sensitivities, Sensitivity};
use crate::assumed::AssumedConstants;
use crate::contact::{Contact, InversionCounts, StiffnessBranch};
use crate::harmonic::{contact_from_observed, stiffness_n_per_m};

/// Which form of Eq. 18 leads from stiffness to gap.
#[derive(Clone, Copy)]
pub(super) enum Stiffness<'a> {
    /// In force balance at this normal force, N: `paper`.
    Balance(f64),
    /// From amplitude and gap, whether or not the forces balance: `dynamic`. Amplitude m, normal force N.
    Amplitude(&'a [f64], &'a [f64]),
}

/// A fitted instance: parameter 0 is ln σ_t, all else as `z_t_slopes` says.
pub(super) struct Fitted<'a, const N: usize> {
    pub(super) contact: Contact,
    pub(super) carrier_rad_per_s: f64,
    pub(super) z_p: Complex64,
    pub(super) z_t: Complex64,
    /// ∂Z_t/∂parameter.
    pub(super) z_t_slopes: [Complex64; N],
    pub(super) covariance: Option<SMatrix<f64, N, N>>,
    /// Standard deviation of one component of Z_m.
    pub(super) z_m_std: f64,
    pub(super) mu0: f64,
    /// ∂μ0/∂parameter.
    pub(super) mu0_slopes: [f64; N],
    /// What μ0 scatters by itself.
    pub(super) mu0_std: f64,
    pub(super) stiffness: Stiffness<'a>,
}

/// A quantity of one sample with what it depends on: the parameters, and that sample's impedance noise.
struct Dependent<const N: usize> {
    value: f64,
    slopes: SVector<f64, N>,
    noise: f64,
}

impl<const N: usize> Fitted<'_, N> {
    pub(super) fn std_of(&self, slopes: &SVector<f64, N>, noise: f64) -> f64 {
        self.covariance.map_or(f64::INFINITY, |c| {
            (slopes.dot(&(c * slopes)) + noise * noise).sqrt()
        })
    }

    pub(super) fn estimate(
        &self,
        time_s: &[f64],
        z_m: &[Complex64],
        z_m_model: Vec<Complex64>,
    ) -> EstimatedSeries {
        let n = time_s.len();
        let empty = || Vec::with_capacity(n);
        let mut series = EstimatedSeries {
            time_s: time_s.to_vec(),
            k_c_n_per_m: empty(),
            k_c_std_n_per_m: empty(),
            gap_m: empty(),
            gap_std_m: empty(),
            mu: empty(),
            mu_std: empty(),
            z_m_model_n_s_per_m: z_m_model,
            inversion: InversionCounts::default(),
        };
        for (index, &z) in z_m.iter().enumerate() {
            let k_c = self.stiffness(z);
            let (gap, mu) = self.gap_and_friction(&k_c, index, &mut series.inversion);
            for (quantity, values, stds) in [
                (k_c, &mut series.k_c_n_per_m, &mut series.k_c_std_n_per_m),
                (gap, &mut series.gap_m, &mut series.gap_std_m),
                (mu, &mut series.mu, &mut series.mu_std),
            ] {
                values.push(quantity.value);
                stds.push(self.std_of(&quantity.slopes, quantity.noise));
            }
        }
        series
    }

    fn stiffness(&self, z_m: Complex64) -> Dependent<N> {
        let finger = z_m - self.z_p;
        let rest = self.z_t - finger;
        let by_z_t = -(finger / rest).powi(2);
        let by_z_m = (self.z_t / rest).powi(2);
        Dependent {
            value: stiffness_n_per_m(
                contact_from_observed(z_m, self.z_p, self.z_t),
                self.carrier_rad_per_s,
            ),
            slopes: SVector::from_fn(|i, _| {
                -self.carrier_rad_per_s * (by_z_t * self.z_t_slopes[i]).im
            }),
            noise: self.carrier_rad_per_s * by_z_m.norm() * self.z_m_std,
        }
    }

    fn gap_and_friction(
        &self,
        k_c: &Dependent<N>,
        index: usize,
        counts: &mut InversionCounts,
    ) -> (Dependent<N>, Dependent<N>) {
        let contact = &self.contact;
        let sigma = contact.sigma_t_m();
        let gap = match self.stiffness {
            Stiffness::Balance(normal_n) => contact
                .gap_from_balance_stiffness(k_c.value, normal_n)
                .map(|inverted| {
                    match inverted.branch {
                        StiffnessBranch::Unique => {}
                        StiffnessBranch::Ambiguous { .. } => counts.ambiguous += 1,
                        StiffnessBranch::AboveMaximum => counts.above_maximum += 1,
                    }
                    inverted.gap_m
                }),
            Stiffness::Amplitude(amplitude_m, _) => {
                contact.gap_from_stiffness_m(k_c.value, amplitude_m[index])
            }
        };
        let Ok(gap_m) = gap else {
            counts.without_gap += 1;
            let none = || Dependent {
                value: f64::NAN,
                slopes: SVector::repeat(f64::NAN),
                noise: f64::NAN,
            };
            return (none(), none());
        };
        let u = gap_m / sigma;
        // ∂k_c/∂x and ∂k_c/∂ln σ_t at constant gap.
        let (by_gap, by_ln_sigma, normal_n) = match self.stiffness {
            Stiffness::Balance(normal_n) => (
                contact.balance_stiffness_slope_n_per_m2(gap_m, normal_n),
                contact.balance_stiffness_by_ln_sigma_n_per_m(gap_m),
                normal_n,
            ),
            Stiffness::Amplitude(amplitude_m, normal_n) => (
                contact.stiffness_slope_n_per_m2(gap_m, amplitude_m[index]),
                contact.stiffness_by_ln_sigma_n_per_m(gap_m),
                normal_n[index],
            ),
        };
        let mut gap_slopes = k_c.slopes;
        gap_slopes[0] -= by_ln_sigma;
        gap_slopes /= by_gap;
        let gap_noise = k_c.noise / by_gap.abs();

        let ratio = contact.friction_ratio(gap_m, normal_n);
        let mut ratio_slopes = gap_slopes * (-ratio / sigma);
        ratio_slopes[0] += ratio * (1.0 + u);
        let mu_slopes = ratio_slopes * self.mu0 + SVector::from(self.mu0_slopes) * ratio;
        let mu_noise = (self.mu0 * ratio * gap_noise / sigma).hypot(ratio * self.mu0_std);
        (
            Dependent {
                value: gap_m,
                slopes: gap_slopes,
                noise: gap_noise,
            },
            Dependent {
                value: self.mu0 * ratio,
                slopes: mu_slopes,
                noise: mu_noise,
            },
        )
    }
}

pub(super) fn agreement(z_m: &[Complex64], mu: &[f64], series: &EstimatedSeries) -> Agreement {
    let n = z_m.len() as f64;
    let mean = z_m.iter().sum::<Complex64>() / n;
    let squares: f64 = z_m
        .iter()
        .zip(&series.z_m_model_n_s_per_m)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    let spread: f64 = z_m.iter().map(|z| (z - mean).norm_sqr()).sum();
    let apart = series
        .mu
        .iter()
        .zip(mu)
        .map(|(a, b)| a - b)
        .filter(|d| !d.is_nan());
    let (count, mu_squares) = apart.fold((0u32, 0.0), |(count, sum), d| (count + 1, sum + d * d));
    Agreement {
        r2_impedance: 1.0 - squares / spread,
        rms_impedance_n_s_per_m: (squares / n).sqrt(),
        rms_mu: (mu_squares / f64::from(count)).sqrt(),
    }
}

/// Central differences of refits; `refit` gives ln σ_t, Z_t and τ. Asperities know q0, E and ν only through q0 E/(1 − ν²).
pub(super) fn sensitivities(
    conditions: &FitConditions,
    refit: impl Fn(&FitConditions) -> Result<(f64, Complex64, f64), FitError>,
) -> Result<Sensitivities, FitError> {
    const STEP: f64 = 0.01;
    let central = |vary: fn(&mut AssumedConstants, f64)| {
        let at = |factor: f64| {
            let mut varied = *conditions;
            vary(&mut varied.assumed, factor);
            refit(&varied)
        };
        let (above, below) = (at(STEP.exp())?, at((-STEP).exp())?);
        let slope = |a: f64, b: f64| (a - b) / (2.0 * STEP);
        Ok::<_, FitError>(Sensitivity {
            ln_sigma_t: slope(above.0, below.0),
            ln_abs_z_t: slope(above.1.norm().ln(), below.1.norm().ln()),
            tau_s: slope(above.2, below.2),
        })
    };
    let q0 = central(|assumed, factor| assumed.q0_rad_per_m *= factor)?;
    let contact_area = central(|assumed, factor| assumed.contact_area_m2 *= factor)?;
    let nu_squared = conditions.assumed.poisson_ratio.powi(2);
    let per_nu = 2.0 * nu_squared / (1.0 - nu_squared);
    let poisson_ratio = Sensitivity {
        ln_sigma_t: q0.ln_sigma_t * per_nu,
        ln_abs_z_t: q0.ln_abs_z_t * per_nu,
        tau_s: q0.tau_s * per_nu,
    };
    Ok(Sensitivities {
        q0,
        young_modulus: q0,
        poisson_ratio,
        contact_area,
    })
}
