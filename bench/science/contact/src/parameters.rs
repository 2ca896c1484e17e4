//! Parameters of a finger on a plate, in the order used by every fit, slope and covariance.

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Number of parameters.
pub const PARAMETERS: usize = 24;
/// ln σ_t, σ_t in m. It comes first, so that a fit of σ_t alone has it at the same index.
pub const LN_SIGMA_T: usize = 0;
/// Re Z_t, N·s/m.
pub const RE_Z_T: usize = 1;
/// Im Z_t, N·s/m.
pub const IM_Z_T: usize = 2;
/// τ, ms.
pub const TAU_MS: usize = 3;
/// Imaginary part of the offset added to Z_p, N·s/m: a shift of the resonance.
pub const IM_OFFSET: usize = 4;
/// ln S, S in m².
pub const LN_AREA: usize = 5;
/// ln q0, q0 in rad/m.
pub const LN_Q0: usize = 6;
/// ln η.
pub const LN_LOSS_FACTOR: usize = 7;
/// Real part of the offset added to Z_p, N·s/m: a change of the damping.
pub const RE_OFFSET: usize = 8;

/// Exponent ν of the area's growth with the normal force.
pub const AREA_EXPONENT: usize = 9;
/// Time over which the film averages the squared amplitude, ms.
pub const FILM_MEAN_MS: usize = 10;
/// Exponent of τ's growth with the gap.
pub const LAG_EXPONENT: usize = 11;

/// ln of the ratio of the amplitude under the finger to that at the pickup.
pub const LN_RATIO: usize = 12;

/// Angle by which another mode of the plate rotates the finger's part of Z_m, rad.
pub const FINGER_ANGLE: usize = 13;

/// Imaginary part of the mobility that other modes of the plate add to the finger's part of Z_m, m/(N·s).
pub const RESIDUAL_MOBILITY: usize = 14;

/// ln of the ratio of the measured to the true finger part of Z_m: an error of calibration, 0 in every estimate.
pub const LN_FINGER: usize = 15;

/// ln of the ratio of the true to the measured normal force: an error of calibration, 0 in every estimate.
pub const LN_FORCE: usize = 16;

/// Imaginary part of the residual mobility by which other modes move the film, m/(N·s): 0 in every estimate.
/// [`RESIDUAL_MOBILITY`] is its effect on the finger's part of Z_m.
pub const FILM_MOBILITY: usize = 17;

/// Loss factor of the film less that of the asperities: 0 in the published laws, as are the other five that follow.
pub const FILM_LOSS: usize = 18;

/// Share α of the film that answers at the carrier as trapped air ([`stiffness_parts_n_per_m`](crate::Contact)).
pub const TRAPPED_SHARE: usize = 19;

/// Share ρ of the skin's motion that the film follows: its amplitude is that of the plate less ρ times that of the skin.
pub const RELATIVE_SHARE: usize = 20;

/// Exponent ι of the time average of Eq. 15 under vibration: the asperities' force is multiplied by I0(|x̃|/σ_t)^ι.
pub const CYCLE_AVERAGE: usize = 21;

/// Change of the plate's reactance with the square of its amplitude, N·s/m per µm²: a resonance that falls.
pub const SOFTENING: usize = 22;

/// Square κ of the contact's width across the plate, in units of the mode's wavelength.
pub const WIDTH_SQUARE: usize = 23;

/// Unit of τ in the fits, s.
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

/// ∂ ln of the finger's part of Z_m/∂parameter: the ratio affects both force and velocity at the finger.
pub const FINGER_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[LN_RATIO] = Complex64::new(2.0, 0.0);
    slopes[FINGER_ANGLE] = Complex64::I;
    slopes[LN_FINGER] = Complex64::ONE;
    slopes
};

/// ∂ of the mobility added by other modes/∂parameter.
pub const RESIDUAL_SLOPES: [Complex64; PARAMETERS] = {
    let mut slopes = [Complex64::ZERO; PARAMETERS];
    slopes[RESIDUAL_MOBILITY] = Complex64::I;
    slopes
};

/// Derivatives of a quantity of the contact by the contact's constants, at a given gap, amplitude and normal force.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactSlopes {
    /// Derivative by ln σ_t.
    pub by_ln_sigma_t: f64,
    /// Derivative by ln S.
    pub by_ln_area: f64,
    /// Derivative by ln q0.
    pub by_ln_q0: f64,
    /// Derivative by the logarithm of the film's effective squared amplitude.
    pub by_ln_film: f64,
    /// Derivative by the logarithm of the normal force.
    pub by_ln_force: f64,
    /// Derivative by the share of trapped air.
    pub by_trapped_share: f64,
}

/// Derivatives of the load on one sample by parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct LoadSlopes {
    /// ∂ ln S/∂ν: ln of the ratio of the normal force to that at which the area is S.
    pub ln_area_by_exponent: f64,
    /// ∂ ln of the film's effective squared amplitude, by its averaging time, 1/ms.
    pub ln_film_by_mean_ms: f64,
    /// ∂ ln of the film's effective squared amplitude, by the residual mobility of other modes, N·s/m.
    pub ln_film_by_mobility: f64,
    /// ∂ ln of the film's effective squared amplitude, by the share of the skin's motion.
    pub ln_film_by_relative_share: f64,
    /// ∂ ln of the film's effective squared amplitude, by the real and the imaginary part of Z_t, m/(N·s).
    pub ln_film_by_z_t: [f64; 2],
    /// ∂ ln of the film's effective squared amplitude, by the square of the contact's width.
    pub ln_film_by_width_square: f64,
    /// ∂ ln of the asperities' force at a gap, by the logarithm of the film's effective squared amplitude.
    pub ln_asperity_by_ln_film: f64,
    /// ∂ ln of the asperities' force at a gap, by the exponent of the cycle's average.
    pub ln_asperity_by_cycle_average: f64,
}

impl LoadSlopes {
    /// Returns ∂ ln of the film's effective squared amplitude by a parameter of the full order.
    fn ln_film(&self, parameter: usize) -> f64 {
        match parameter {
            FILM_MEAN_MS => self.ln_film_by_mean_ms,
            LN_RATIO => 2.0,
            FILM_MOBILITY => self.ln_film_by_mobility,
            RELATIVE_SHARE => self.ln_film_by_relative_share,
            RE_Z_T => self.ln_film_by_z_t[0],
            IM_Z_T => self.ln_film_by_z_t[1],
            WIDTH_SQUARE => self.ln_film_by_width_square,
            _ => 0.0,
        }
    }

    /// Returns ∂ ln of the asperities' force at a gap by a parameter of the full order, through the cycle's average.
    fn ln_asperity(&self, parameter: usize) -> f64 {
        // I0(|x̃|/σ_t)^ι depends on σ_t as on the reciprocal of the amplitude: ∂/∂ ln σ_t = −2 ∂/∂ ln |x̃|².
        match parameter {
            LN_SIGMA_T => -2.0 * self.ln_asperity_by_ln_film,
            CYCLE_AVERAGE => self.ln_asperity_by_cycle_average,
            _ => self.ln_asperity_by_ln_film * self.ln_film(parameter),
        }
    }
}

impl ContactSlopes {
    /// Returns the slope by a parameter of the full order; a fit of fewer parameters has the first ones.
    pub fn by_parameter(&self, parameter: usize, load: &LoadSlopes) -> f64 {
        let direct = match parameter {
            LN_SIGMA_T => self.by_ln_sigma_t,
            LN_AREA => self.by_ln_area,
            LN_Q0 => self.by_ln_q0,
            AREA_EXPONENT => self.by_ln_area * load.ln_area_by_exponent,
            LN_FORCE => self.by_ln_force,
            TRAPPED_SHARE => self.by_trapped_share,
            _ => self.by_ln_film * load.ln_film(parameter),
        };
        // A larger asperity force at every gap is that of a larger q0.
        direct + self.by_ln_q0 * load.ln_asperity(parameter)
    }
}
