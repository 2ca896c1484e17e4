//! The parameters of a finger on a plate, in the order in which every fit, slope and covariance has them.

use num_complex::Complex64;

/// Number of parameters.
pub const PARAMETERS: usize = 18;
/// ln σ_t, σ_t in m. The first, so that a fit of σ_t alone has it in the same place.
pub const LN_SIGMA_T: usize = 0;
/// Re Z_t, N·s/m.
pub const RE_Z_T: usize = 1;
/// Im Z_t, N·s/m.
pub const IM_Z_T: usize = 2;
/// τ, ms.
pub const TAU_MS: usize = 3;
/// Im of what is added to Z_p, N·s/m: a resonance that has moved.
pub const IM_OFFSET: usize = 4;
/// ln S, S in m².
pub const LN_AREA: usize = 5;
/// ln q0, q0 in rad/m.
pub const LN_Q0: usize = 6;
/// ln η.
pub const LN_LOSS_FACTOR: usize = 7;
/// Re of what is added to Z_p, N·s/m: a damping that has changed.
pub const RE_OFFSET: usize = 8;

/// ν of an area that grows as the normal force to the power of ν.
pub const AREA_EXPONENT: usize = 9;
/// Time over which the film averages the squared amplitude, ms.
pub const FILM_MEAN_MS: usize = 10;
/// Exponent with which τ grows with the gap.
pub const LAG_EXPONENT: usize = 11;

/// ln of the amplitude under the finger over that at the pickup.
pub const LN_RATIO: usize = 12;

/// Angle by which the finger's part of Z_m is turned, rad: what another mode of the plate does to it.
pub const FINGER_ANGLE: usize = 13;

/// Imaginary part of what other modes of the plate add to the mobility of the finger's part of Z_m, m/(N·s).
pub const RESIDUAL_MOBILITY: usize = 14;

/// ln of the finger's part of Z_m as it is measured over what it is: an error of calibration, 0 in every estimate.
pub const LN_FINGER: usize = 15;

/// ln of the normal force over what is measured: likewise.
pub const LN_FORCE: usize = 16;

/// Imaginary part of the residual mobility by which other modes move the film, m/(N·s): 0 in every estimate.
/// [`RESIDUAL_MOBILITY`] is what the finger's part of Z_m shows of it.
pub const FILM_MOBILITY: usize = 17;

/// The fits' unit of τ, s.
pub const MS: f64 = 1e-3;

/// ∂Z_t/∂parameter.
pub const Z_T_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[RE_Z_T] = Complex64::ONE;
    slopes[IM_Z_T] = Complex64::I;
    slopes
};
/// ∂Z_p/∂parameter.
pub const Z_P_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[IM_OFFSET] = Complex64::I;
    slopes[RE_OFFSET] = Complex64::ONE;
    slopes
};

/// ∂ ln of the finger's part of Z_m/∂parameter: force and velocity at the finger are both seen through the ratio.
pub const FINGER_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[LN_RATIO] = Complex64::new(2.0, 0.0);
    slopes[FINGER_ANGLE] = Complex64::I;
    slopes[LN_FINGER] = Complex64::ONE;
    slopes
};

/// ∂ of what other modes add to the mobility/∂parameter.
pub const RESIDUAL_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[RESIDUAL_MOBILITY] = Complex64::I;
    slopes
};

/// How a quantity of the contact depends on what the contact is made of, at a given gap, amplitude and normal force.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactSlopes {
    /// By ln σ_t.
    pub by_ln_sigma_t: f64,
    /// By ln S.
    pub by_ln_area: f64,
    /// By ln q0.
    pub by_ln_q0: f64,
    /// By the logarithm of the squared amplitude that the film answers to.
    pub by_ln_film: f64,
    /// By the logarithm of the normal force.
    pub by_ln_force: f64,
}

/// How what acts on one sample depends on parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LoadSlopes {
    /// ∂ ln S/∂ν: ln of the normal force over that at which S holds.
    pub ln_area_by_exponent: f64,
    /// ∂ ln of the squared amplitude that the film answers to, by the time it averages over, 1/ms.
    pub ln_film_by_mean_ms: f64,
    /// ∂ ln of the squared amplitude that the film answers to, by the residual mobility of other modes, N·s/m.
    pub ln_film_by_mobility: f64,
}

impl ContactSlopes {
    /// Returns the slope by a parameter of the whole order, of which a fit of fewer has the first ones.
    pub fn by(&self, parameter: usize, load: &LoadSlopes) -> f64 {
        match parameter {
            LN_SIGMA_T => self.by_ln_sigma_t,
            LN_AREA => self.by_ln_area,
            LN_Q0 => self.by_ln_q0,
            AREA_EXPONENT => self.by_ln_area * load.ln_area_by_exponent,
            FILM_MEAN_MS => self.by_ln_film * load.ln_film_by_mean_ms,
            LN_RATIO => 2.0 * self.by_ln_film,
            FILM_MOBILITY => self.by_ln_film * load.ln_film_by_mobility,
            LN_FORCE => self.by_ln_force,
            _ => 0.0,
        }
    }
}
