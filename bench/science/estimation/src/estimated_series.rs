//! Stiffness, gap and friction of an instance from its measured impedance.

use nalgebra::{SVector, Vector2};
use num_complex::Complex64;

use super::friction_law::FrictionLaw;
use super::lagged_model::SampleLaws;
use super::loads::Loads;
use super::trend::Trend;
use contact::InversionCounts;
use contact::inversion::{Dependent, Inversion};
use serde::{Deserialize, Serialize};

/// Stiffness, gap and friction over one instance, from the measured impedance. Standard errors follow by the delta method
/// from the parameter covariance and each sample's impedance noise, estimated from the residuals. NaN where a sample has
/// no gap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EstimatedSeries {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Contact stiffness k_c by Eq. 12, N/m.
    pub k_c_n_per_m: Vec<f64>,
    /// Standard error of `k_c_n_per_m`, N/m.
    pub k_c_std_n_per_m: Vec<f64>,
    /// Levitation gap ⟨x_t⟩ by Eq. 18, m.
    pub gap_m: Vec<f64>,
    /// Standard error of `gap_m`, m.
    pub gap_std_m: Vec<f64>,
    /// Friction μ by Eq. 19 with the instance's μ0, and with the trial's floor and the change of μ0 where those were fitted.
    pub mu: Vec<f64>,
    /// Standard error of `mu`.
    pub mu_std: Vec<f64>,
    /// Impedance of the fitted model, N·s/m.
    pub z_m_model_n_s_per_m: Vec<Complex64>,
    /// Counts of the samples with a gap that is not unique or does not exist.
    pub inversion: InversionCounts,
}

/// Form of Eq. 18 that relates stiffness to gap.
#[derive(Clone, Copy)]
pub(super) enum GapLaw {
    /// Force balance at the sample's normal force, for `paper`.
    Balance,
    /// The sample's amplitude, whether or not the forces balance, for `dynamic`.
    Amplitude,
}

/// Samples from which a series is estimated.
pub(super) struct MeasuredSamples<'a> {
    pub(super) time_s: &'a [f64],
    pub(super) z_m: &'a [Complex64],
    /// Standard deviation of one component of each impedance.
    pub(super) z_m_std: &'a [f64],
    pub(super) amplitude_m: &'a [f64],
    pub(super) normal_n: &'a [f64],
    /// Load and trend of each sample; `None` for the published method, where the contact is the same for all samples.
    pub(super) load_trend: Option<LoadTrend<'a>>,
}

/// Load and trend of each sample.
#[derive(Clone, Copy)]
pub(super) struct LoadTrend<'a> {
    pub(super) loads: &'a Loads,
    pub(super) trend: &'a Trend,
    /// Index of the first sample in loads and trend.
    pub(super) first: usize,
    /// Effect of the laws in doubt on each sample; `None` with the laws as published.
    pub(super) laws: Option<&'a [SampleLaws]>,
}

impl MeasuredSamples<'_> {
    /// Returns the inversion of a sample, and the amplitude that acts on its film.
    fn inversion<const N: usize>(
        &self,
        inversion: &Inversion<N>,
        index: usize,
    ) -> (Inversion<N>, f64) {
        match self.load_trend {
            None => (*inversion, self.amplitude_m[index]),
            Some(LoadTrend {
                loads,
                trend,
                first,
                laws,
            }) => {
                let sample = first + index;
                let mut inversion = trend.inversion(inversion, sample);
                if let Some(laws) = laws {
                    inversion = laws[index].inversion(&inversion);
                }
                (
                    loads.inversion(&inversion, sample),
                    loads.amplitude_m[sample],
                )
            }
        }
    }
}

pub(super) fn estimate<const N: usize>(
    inversion: &Inversion<N>,
    law: GapLaw,
    friction: &FrictionLaw<N>,
    measurement: &MeasuredSamples<'_>,
    z_m_model: Vec<Complex64>,
) -> EstimatedSeries {
    let n = measurement.time_s.len();
    let empty = || Vec::with_capacity(n);
    let mut series = EstimatedSeries {
        time_s: measurement.time_s.to_vec(),
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
        let (inversion, amplitude_m) = measurement.inversion(inversion, index);
        let k_c = inversion.stiffness(measurement.z_m[index], measurement.z_m_std[index]);
        let normal_n = measurement.normal_n[index];
        let gap = match law {
            GapLaw::Balance => inversion.balance_gap(&k_c, normal_n).map(|(gap, branch)| {
                series.inversion.count(branch);
                gap
            }),
            GapLaw::Amplitude => inversion.gap(&k_c, amplitude_m),
        };
        let gap = gap.unwrap_or_else(|_| {
            series.inversion.without_gap += 1;
            Dependent::unknown()
        });
        let ratio = inversion.friction_ratio(&gap, normal_n);
        let course = friction.course.ratio_at(measurement.time_s[index]);
        let relative_mu = course * friction.relative_mu(ratio.value);
        // μ = c μ0 (φ + (1 − φ) m), with m the ratio of Eq. 19 and c the change of μ0 within the instance:
        // dμ = c μ0 (1 − φ) dm + c (φ + (1 − φ) m) dμ0 + c μ0 (1 − m) dφ.
        let by_ratio = course * friction.mu0 * (1.0 - friction.floor);
        let by_law = Vector2::new(relative_mu, course * friction.mu0 * (1.0 - ratio.value));
        let scatter = by_law.dot(&(friction.scatter * by_law)).sqrt();
        let mu = Dependent {
            value: friction.mu0 * relative_mu,
            slopes: ratio.slopes * by_ratio
                + SVector::from(friction.slopes) * by_law[0]
                + SVector::from(friction.floor_slopes) * by_law[1],
            noise: (by_ratio * ratio.noise).hypot(scatter),
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
