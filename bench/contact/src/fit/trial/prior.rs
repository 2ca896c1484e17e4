//! What is taken to be likely of a skin and a plate before a trial is seen.

use crate::uncertain::WITHIN_95;

/// A log-normal distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormal {
    /// Median, in the quantity's own unit.
    pub median: f64,
    /// Standard deviation of the natural logarithm.
    pub ln_std: f64,
}

impl LogNormal {
    /// Returns the distribution of which 95 % lies between two values.
    #[must_use]
    pub fn between(low: f64, high: f64) -> Self {
        Self {
            median: (low * high).sqrt(),
            ln_std: (high / low).ln() / (2.0 * WITHIN_95),
        }
    }
}

/// Priors of a trial's parameters. Wide: they keep a short trial sane and leave a whole one to its data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialPriors {
    /// Apparent contact area S, m². Default 95 % between 60 and 450 mm².
    pub contact_area_m2: LogNormal,
    /// q0 for the assumed E and ν, rad/m. Default 95 % between 0.5 and 5 × 10⁴.
    pub q0_rad_per_m: LogNormal,
    /// Loss factor η. Default 95 % between 0.1 and 0.6.
    pub loss_factor: LogNormal,
    /// Levitation lag τ, s. Default 95 % between 0.1 and 10 ms.
    pub tau_s: LogNormal,
    /// Standard deviation of the offset of the plate's reactance, N·s/m; its mean is 0. Default 3, thirty hertz of a plate of 8
    /// g.
    pub plate_reactance_std_n_s_per_m: f64,
    /// Standard deviation of the offset of its damping, N·s/m; its mean is 0. Default 0.5, seven per cent of the published
    /// plate's.
    pub plate_damping_std_n_s_per_m: f64,
}

impl Default for TrialPriors {
    fn default() -> Self {
        Self {
            contact_area_m2: LogNormal::between(60e-6, 450e-6),
            q0_rad_per_m: LogNormal::between(5e3, 5e4),
            loss_factor: LogNormal::between(0.1, 0.6),
            tau_s: LogNormal::between(1e-4, 1e-2),
            plate_reactance_std_n_s_per_m: 3.0,
            plate_damping_std_n_s_per_m: 0.5,
        }
    }
}
