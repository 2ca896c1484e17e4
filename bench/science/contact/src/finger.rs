use nalgebra::SVector;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::contact::Contact;
use crate::error::{ModelError, not_negative, positive};
use crate::inversion::{Dependent, Inversion};
use crate::parameters::{
    ContactSlopes, FINGER_SLOPES, IM_Z_T, LN_SIGMA_T, LoadSlopes, MS, PARAMETERS, RE_Z_T,
    RESIDUAL_SLOPES, TAU_MS, Z_P_SLOPES, Z_T_SLOPES,
};
use crate::residual_noise::ResidualNoise;

/// A finger with known σ_t, Z_t and τ, as needed for samples beyond the fitted instance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FittedFinger {
    /// Inversion of a sample's impedance to stiffness, gap and friction.
    pub inversion: Inversion<PARAMETERS>,
    /// Levitation lag τ, s.
    pub tau_s: f64,
    /// Noise of one component of Z_m; its shape is 1/amplitude.
    pub z_m_noise: ResidualNoise,
}

/// Gap and derived quantities at one sample, with their derivatives.
#[derive(Clone, Copy)]
pub(crate) struct SampleReading {
    pub(crate) k_c: Dependent<PARAMETERS>,
    pub(crate) gap: Dependent<PARAMETERS>,
}

/// Self-sensed normal force at one sample.
#[derive(Clone, Copy)]
pub(crate) struct SensedForce {
    pub(crate) force: Dependent<PARAMETERS>,
    /// ∂f_c/∂x by the sample's own gap, N/m, which is one of several.
    pub(crate) by_own_gap: f64,
}

impl FittedFinger {
    /// Creates a finger from known parameters instead of a fit. The standard errors are unknown and returned as infinite.
    ///
    /// # Errors
    /// If τ is negative or the carrier frequency not positive.
    pub fn with_parameters(
        contact: Contact,
        z_t_n_s_per_m: Complex64,
        tau_s: f64,
        z_p_n_s_per_m: Complex64,
        carrier_hz: f64,
    ) -> Result<Self, ModelError> {
        Ok(Self {
            inversion: Inversion {
                contact,
                load: LoadSlopes::default(),
                carrier_rad_per_s: std::f64::consts::TAU
                    * positive("carrier frequency", "Hz", carrier_hz)?,
                z_p: z_p_n_s_per_m,
                z_t: z_t_n_s_per_m,
                z_t_slopes: Z_T_SLOPES,
                z_p_slopes: Z_P_SLOPES,
                finger_scale: Complex64::ONE,
                finger_slopes: FINGER_SLOPES,
                residual_mobility: Complex64::ZERO,
                residual_slopes: RESIDUAL_SLOPES,
                covariance: None,
            },
            tau_s: not_negative("tau", "s", tau_s)?,
            z_m_noise: ResidualNoise::default(),
        })
    }

    /// Returns the finger for readings of a pickup with a phase that lacks `turn_rad`: they are f̃/(e^(−iφ) ṽ_p), so that Z_p and
    /// the finger's part of Z_m are turned by it.
    #[must_use]
    pub fn turned(mut self, turn_rad: f64) -> Self {
        let turn = Complex64::cis(turn_rad);
        self.inversion.z_p *= turn;
        self.inversion.finger_scale *= turn;
        self
    }

    /// Returns the contact with the fitted σ_t.
    pub fn contact(&self) -> &Contact {
        &self.inversion.contact
    }

    /// Returns Z_t, N·s/m.
    pub fn z_t_n_s_per_m(&self) -> Complex64 {
        self.inversion.z_t
    }

    /// Returns Z_p of the unloaded plate, envelope-corrected and with the fitted offset, N·s/m.
    pub fn z_p_n_s_per_m(&self) -> Complex64 {
        self.inversion.z_p
    }

    /// Returns τ, s.
    pub fn tau_s(&self) -> f64 {
        self.tau_s
    }

    /// Returns the covariance of (σ_t in m, Re Z_t, Im Z_t in N·s/m, τ in s); `None` if a combination of them is not
    /// identified.
    pub fn covariance(&self) -> Option<[[f64; 4]; 4]> {
        let units = [
            (LN_SIGMA_T, self.contact().sigma_t_m()),
            (RE_Z_T, 1.0),
            (IM_Z_T, 1.0),
            (TAU_MS, MS),
        ];
        self.inversion
            .covariance
            .map(|c| units.map(|(i, unit_i)| units.map(|(j, unit_j)| c[(i, j)] * unit_i * unit_j)))
    }

    pub(crate) fn read(
        &self,
        z_m: Complex64,
        amplitude_m: f64,
    ) -> Result<SampleReading, ModelError> {
        let k_c = self
            .inversion
            .stiffness(z_m, self.z_m_noise.std(amplitude_m.recip()));
        let gap = self.inversion.gap(&k_c, amplitude_m)?;
        Ok(SampleReading { k_c, gap })
    }

    /// Returns f_c = p_c S e^(−x_eq/σ_t) + (5/4) p0 S |x̃_p|²/x_eq² with x_eq = x + τ dx/dt, where the slope is Σ weight ·
    /// gap/interval over the samples of `history`. `now` is the index of the current sample.
    pub(crate) fn normal_force(
        &self,
        history: &[Dependent<PARAMETERS>],
        slope_weights: &[f64],
        interval_s: f64,
        now: usize,
        amplitude_m: f64,
    ) -> SensedForce {
        // x_eq = x + τ dx/dt = Σ_j s_j x_j with s_j = δ_j,now + (τ/Δt) w_j, and the weights w_j give dx/dt = Σ w_j x_j/Δt. The
        // noise of the gaps is independent: σ²(x_eq) = Σ s_j² σ_j².
        let lag = self.tau_s / interval_s;
        let (mut gap_m, mut slopes, mut variance, mut steps_m) = (0.0, SVector::zeros(), 0.0, 0.0);
        for (index, (gap, weight)) in history.iter().zip(slope_weights).enumerate() {
            let share = lag * weight + if index == now { 1.0 } else { 0.0 };
            gap_m += share * gap.value;
            slopes += gap.slopes * share;
            variance += (share * gap.noise).powi(2);
            steps_m += weight * gap.value;
        }
        // ∂x_eq/∂τ = dx/dt.
        slopes[TAU_MS] += steps_m / interval_s * MS;
        let contact = self.contact();
        let sigma = contact.sigma_t_m();
        let (asperity_n, squeeze_n) = (
            contact.asperity_force_n(gap_m),
            contact.squeeze_force_n(gap_m, amplitude_m),
        );
        // f_c(x_eq) = f_r + f_s: ∂f_c/∂x = −f_r/σ_t − 2 f_s/x; at a given gap ∂f_r/∂ln σ_t = f_r (1 + x/σ_t), as p_c ∝ σ_t.
        let gap_slope = -asperity_n / sigma - 2.0 * squeeze_n / gap_m;
        let contact_slopes = ContactSlopes {
            by_ln_sigma_t: asperity_n * (1.0 + gap_m / sigma),
            by_ln_area: asperity_n + squeeze_n,
            by_ln_q0: asperity_n,
            by_ln_film: squeeze_n,
            by_ln_force: 0.0,
            by_trapped_share: 0.0,
        };
        SensedForce {
            force: Dependent {
                value: asperity_n + squeeze_n,
                slopes: slopes * gap_slope
                    + SVector::from_fn(|i, _| {
                        contact_slopes.by_parameter(i, &LoadSlopes::default())
                    }),
                noise: gap_slope.abs() * variance.sqrt(),
            },
            by_own_gap: gap_slope * (1.0 + lag * slope_weights[now]),
        }
    }
}
