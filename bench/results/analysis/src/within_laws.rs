//! Estimates of an instance by `trial` with the laws as published (Huloux 2021, Eqs. 14–19) taken as true.

use contact::uncertain::{LogUncertain, Uncertain};
use estimation::trial::SharedFit;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Estimates of an instance by the published laws; their errors include no doubt about these laws.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WithinLaws {
    /// σ_t, m; NaN if no skin has it.
    pub sigma_t_m: LogUncertain,
    /// Z_t, N·s/m.
    pub z_t_n_s_per_m: Complex64,
    /// Standard errors of the real and imaginary part of Z_t, N·s/m.
    pub z_t_std_n_s_per_m: Complex64,
    /// μ0.
    pub mu0: Uncertain,
    /// Shift of the resonance relative to the unloaded plate, Hz.
    pub resonance_shift_hz: Uncertain,
    /// Mean gap, m.
    pub mean_gap_m: f64,
}

/// Returns the fit by the published laws if these hold: if neither this fit nor that with the laws in doubt, `total`, has signs of
/// misfit, and both can be used.
pub(crate) fn holding<'a>(
    total: &SharedFit,
    within_laws: Option<&'a SharedFit>,
) -> Option<&'a SharedFit> {
    within_laws.filter(|fit| fit.holds() && total.holds())
}
