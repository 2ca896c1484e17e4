//! Agreement of a fit with the measurement.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::estimated_series::EstimatedSeries;

/// Differences of fitted and measured values over an instance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// 1 − Σ|Z_m − Ẑ_m|²/Σ|Z_m − mean Z_m|², complex.
    pub r2_impedance: f64,
    /// RMS of |Z_m − Ẑ_m|, N·s/m.
    pub rms_impedance_n_s_per_m: f64,
    /// RMS of estimated − measured μ over the samples that have a gap; the estimate is passed through the lag if one was
    /// fitted.
    pub rms_mu: f64,
}

/// Compares a series with the measurement; `estimated_mu` is its friction as the sensor would read it.
pub(super) fn agreement(
    z_m: &[Complex64],
    mu: &[f64],
    series: &EstimatedSeries,
    estimated_mu: &[f64],
) -> Agreement {
    let n = z_m.len() as f64;
    let mean = z_m.iter().sum::<Complex64>() / n;
    let squares: f64 = z_m
        .iter()
        .zip(&series.z_m_model_n_s_per_m)
        .map(|(a, b)| (a - b).norm_sqr())
        .sum();
    let spread: f64 = z_m.iter().map(|z| (z - mean).norm_sqr()).sum();
    let differences = estimated_mu
        .iter()
        .zip(mu)
        .map(|(a, b)| a - b)
        .filter(|difference| !difference.is_nan());
    let (count, mu_squares) = differences.fold((0u32, 0.0), |(count, sum), difference| {
        (count + 1, sum + difference * difference)
    });
    Agreement {
        r2_impedance: 1.0 - squares / spread,
        rms_impedance_n_s_per_m: (squares / n).sqrt(),
        rms_mu: (mu_squares / f64::from(count)).sqrt(),
    }
}
