use nalgebra::SVector;
use num_complex::Complex64;

use super::{Agreement, EstimatedSeries, FitConditions, FitError, Sensitivities, Sensitivity};
use crate::assumed::AssumedConstants;
use crate::contact::InversionCounts;
use crate::inversion::{Dependent, Inversion};

/// Which form of Eq. 18 leads from stiffness to gap.
#[derive(Clone, Copy)]
pub(super) enum GapLaw {
    /// In force balance at the sample's normal force: `paper`.
    Balance,
    /// From the sample's amplitude, whether or not the forces balance: `dynamic`.
    Amplitude,
}

/// μ0 with what it depends on.
#[derive(Clone, Copy)]
pub(super) struct FrictionAtRest<const N: usize> {
    pub(super) mu0: f64,
    /// ∂μ0/∂parameter.
    pub(super) slopes: [f64; N],
    /// What the measured friction's scatter adds.
    pub(super) std: f64,
}

/// The samples that a series is estimated from.
pub(super) struct Measured<'a> {
    pub(super) time_s: &'a [f64],
    pub(super) z_m: &'a [Complex64],
    /// Standard deviation of one component of each.
    pub(super) z_m_std: &'a [f64],
    pub(super) amplitude_m: &'a [f64],
    pub(super) normal_n: &'a [f64],
}

pub(super) fn estimate<const N: usize>(
    inversion: &Inversion<N>,
    law: GapLaw,
    friction: &FrictionAtRest<N>,
    measured: &Measured<'_>,
    z_m_model: Vec<Complex64>,
) -> EstimatedSeries {
    let n = measured.time_s.len();
    let empty = || Vec::with_capacity(n);
    let mut series = EstimatedSeries {
        time_s: measured.time_s.to_vec(),
        k_c_n_per_m: empty(),
        k_c_std_n_per_m: empty(),
        gap_m: empty(),
        gap_std_m: empty(),
        mu: empty(),
        mu_std: empty(),
        z_m_model_n_s_per_m: z_m_model,
        inversion: InversionCounts::default(),
    };
    for index in 0..n {
        let k_c = inversion.stiffness(measured.z_m[index], measured.z_m_std[index]);
        let normal_n = measured.normal_n[index];
        let gap = match law {
            GapLaw::Balance => inversion.balance_gap(&k_c, normal_n).map(|(gap, branch)| {
                series.inversion.count(branch);
                gap
            }),
            GapLaw::Amplitude => inversion.gap(&k_c, measured.amplitude_m[index]),
        };
        let gap = gap.unwrap_or_else(|_| {
            series.inversion.without_gap += 1;
            Dependent::unknown()
        });
        let ratio = inversion.friction_ratio(&gap, normal_n);
        let mu = Dependent {
            value: friction.mu0 * ratio.value,
            slopes: ratio.slopes * friction.mu0 + SVector::from(friction.slopes) * ratio.value,
            noise: (friction.mu0 * ratio.noise).hypot(ratio.value * friction.std),
        };
        for (quantity, values, stds) in [
            (k_c, &mut series.k_c_n_per_m, &mut series.k_c_std_n_per_m),
            (gap, &mut series.gap_m, &mut series.gap_std_m),
            (mu, &mut series.mu, &mut series.mu_std),
        ] {
            values.push(quantity.value);
            stds.push(inversion.std(&quantity));
        }
    }
    series
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
