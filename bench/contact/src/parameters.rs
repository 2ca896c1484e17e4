//! The parameters of a finger on a plate, in the order in which every fit, slope and covariance has them.

use num_complex::Complex64;

/// Number of parameters.
pub(crate) const PARAMETERS: usize = 9;
/// ln σ_t, σ_t in m. The first, so that a fit of σ_t alone has it in the same place.
pub(crate) const LN_SIGMA_T: usize = 0;
/// Re Z_t, N·s/m.
pub(crate) const RE_Z_T: usize = 1;
/// Im Z_t, N·s/m.
pub(crate) const IM_Z_T: usize = 2;
/// τ, ms.
pub(crate) const TAU_MS: usize = 3;
/// Im of what is added to Z_p, N·s/m: a resonance that has moved.
pub(crate) const IM_OFFSET: usize = 4;
/// ln S, S in m².
pub(crate) const LN_AREA: usize = 5;
/// ln q0, q0 in rad/m.
pub(crate) const LN_Q0: usize = 6;
/// ln η.
pub(crate) const LN_LOSS_FACTOR: usize = 7;
/// Re of what is added to Z_p, N·s/m: a damping that has changed.
pub(crate) const RE_OFFSET: usize = 8;

/// The fits' unit of τ, s.
pub(crate) const MS: f64 = 1e-3;

/// ∂Z_t/∂parameter.
pub(crate) const Z_T_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[RE_Z_T] = Complex64::ONE;
    slopes[IM_Z_T] = Complex64::I;
    slopes
};
/// ∂Z_p/∂parameter.
pub(crate) const Z_P_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[IM_OFFSET] = Complex64::I;
    slopes[RE_OFFSET] = Complex64::ONE;
    slopes
};

/// How a quantity of the contact depends on what the contact is made of, at a given gap, amplitude and normal force.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactSlopes {
    pub(crate) by_ln_sigma_t: f64,
    pub(crate) by_ln_area: f64,
    pub(crate) by_ln_q0: f64,
}

impl ContactSlopes {
    /// Returns the slope by a parameter of the whole order, of which a fit of fewer has the first ones.
    pub(crate) fn by(&self, parameter: usize) -> f64 {
        match parameter {
            LN_SIGMA_T => self.by_ln_sigma_t,
            LN_AREA => self.by_ln_area,
            LN_Q0 => self.by_ln_q0,
            _ => 0.0,
        }
    }
}
