//! Model fitted by `dynamic` and `trial`: the impedance of one instance with a gap that lags behind its equilibrium.
//!
//! For the measured amplitude |x̃_p| and normal force f_n of each sample, in the order of the code:
//!
//! ```text
//! S_f = S (f_n/f̄)^ν                                           contact area under the load
//! T d(a²)/dt = |x̃_p|² − a²,  then a times r                    amplitude at the film
//! F f_n = p_c S_f e^(−x_eq/σ_t) + (5/4) p0 S_f a²/x_eq²        equilibrium (Huloux 2021, Eqs. 13–17)
//! τ (x/10 µm)^p dx/dt = x_eq − x                               levitation lag
//! k_c = p_c S_f e^(−x/σ_t)/σ_t + 2 · (5/4) p0 S_f a²/x³        stiffness (Eq. 18); the forces need not balance
//! Z_c = (η − i) k_c/ω,  Z_f = Z_t Z_c/(Z_t + Z_c)              contact and finger (Eqs. 7, 9)
//! Z_m = Z_p + Δ + s Z_f/(1 + Y Z_f) + transient                s = L r² e^(iφ), Y = i y_r
//! ```
//!
//! Parameters are ln σ_t, Z_t, τ, Δ, ln S, ln q0, ln η, ν, T, p, ln r, φ and y_r; ln L and ln F are 0 except in the effect of
//! calibration errors. p_c = 0.375 q0 σ_t E/(1 − ν_P²) with Poisson's ratio ν_P. A finger where the mode shape is r times that
//! at the pickup is driven at r ṽ_p, and its force acts on the mode as r f̃_c: hence r². Other modes, of mobility Y at the
//! finger, slow the plate under it: from ṽ_f = ṽ_p − Y f̃_c and f̃_c = Z_f ṽ_f follow f̃_c/ṽ_p = Z_f/(1 + Y Z_f) and
//! ṽ_f/ṽ_p = 1/(1 + Y Z_f). `dynamic` has ν = T = p = ln r = φ = y_r = 0. Within an instance ln σ_t, Z_t, Z_p and φ may be
//! linear in time (`trend.rs`).

mod corrections;
mod gap;
mod impedance;

use num_complex::Complex64;

use super::conditions::FitConditions;
use super::fit_error::FitError;
use super::loads::Loads;
use super::series::InstanceSeries;
use super::transient::Transient;
use super::trend::Trend;
use contact::AssumedConstants;
use contact::CalibrationErrors;
use contact::Contact;
use contact::parameters::{LN_AREA, LN_LOSS_FACTOR, LN_Q0, LN_SIGMA_T, MS, PARAMETERS, TAU_MS};

pub(super) use gap::GAP_PARAMETERS;
use gap::GapSlopes;
use impedance::ForceSlopes;
pub(super) use impedance::finger_scale;

/// Instance with its lead-in, and buffers for the gap of the last parameters tried.
pub(super) struct LaggedModel<'a> {
    assumed: AssumedConstants,
    pub(super) calibration: CalibrationErrors,
    pub(super) carrier_rad_per_s: f64,
    pub(super) interval_s: f64,
    pub(super) z_p: Complex64,
    /// Time, with `lead` samples before the instance, s.
    pub(super) time_s: &'a [f64],
    /// Amplitude, m.
    pub(super) amplitude_m: &'a [f64],
    /// Normal force, N.
    pub(super) normal_n: &'a [f64],
    pub(super) lead: usize,
    /// Measured Z_m of the instance without the lead-in, N·s/m.
    pub(super) z_m: &'a [Complex64],
    pub(super) loads: Loads,
    pub(super) trend: Trend,
    /// Change of Z_m by the skin's inertia; zero until it is followed.
    pub(super) transient: Transient,
    /// Time of the middle of the instance, s.
    pub(super) middle_s: f64,
    /// Equilibrium of the gap, m.
    equilibrium: Vec<f64>,
    /// Lagged gap, m.
    pub(super) gap: Vec<f64>,
    gap_slopes: GapSlopes,
    /// Derivatives at each sample of the instance that [`response_to_force`](Self::response_to_force) needs.
    force_slopes: Vec<ForceSlopes>,
    area_exponent: f64,
}

impl<'a> LaggedModel<'a> {
    /// Makes the model of an instance. The gap is integrated from `lead_in_s` before it; the area is S at `reference_n`.
    pub(super) fn new(
        instance: &InstanceSeries<'a>,
        conditions: &FitConditions,
        lead_in_s: f64,
        reference_n: f64,
    ) -> Result<Self, FitError> {
        conditions.assumed.validated()?;
        let (samples, lead) = instance.with_lead_in(lead_in_s)?;
        let zeros = || vec![0.0; samples.time_s.len()];
        Ok(Self {
            assumed: conditions.assumed,
            calibration: conditions.calibration,
            carrier_rad_per_s: conditions.carrier_rad_per_s()?,
            interval_s: instance.interval_s(),
            z_p: conditions.z_p_corrected_n_s_per_m,
            time_s: samples.time_s,
            amplitude_m: samples.amplitude_m,
            normal_n: samples.normal_n,
            lead,
            z_m: &samples.z_m_corrected_n_s_per_m[lead..],
            loads: Loads::new(samples.amplitude_m, samples.normal_n, reference_n),
            trend: Trend::new(samples.time_s, lead),
            transient: Transient::new(
                &samples.amplitude_m[lead..],
                &samples.z_m_plain_n_s_per_m[lead..],
                instance.interval_s(),
            ),
            middle_s: 0.5 * (samples.time_s[lead] + samples.time_s[samples.time_s.len() - 1]),
            equilibrium: zeros(),
            gap: zeros(),
            gap_slopes: GapSlopes::new(samples.time_s.len()),
            force_slopes: vec![ForceSlopes::default(); samples.time_s.len() - lead],
            area_exponent: 0.0,
        })
    }

    /// Returns the parameters with the assumed skin and no plate offset.
    pub(super) fn assumed_parameters(&self, sigma_t_m: f64, tau_s: f64) -> [f64; PARAMETERS] {
        let mut parameters = [0.0; PARAMETERS];
        parameters[LN_SIGMA_T] = sigma_t_m.ln();
        parameters[TAU_MS] = tau_s / MS;
        parameters[LN_AREA] = self.assumed.contact_area_m2.ln();
        parameters[LN_Q0] = self.assumed.q0_rad_per_m.ln();
        parameters[LN_LOSS_FACTOR] = self.assumed.loss_factor.ln();
        parameters
    }

    /// Returns the contact that the parameters describe.
    pub(super) fn contact(&self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let skin = AssumedConstants {
            contact_area_m2: parameters[LN_AREA].exp(),
            q0_rad_per_m: parameters[LN_Q0].exp(),
            loss_factor: parameters[LN_LOSS_FACTOR].exp(),
            ..self.assumed
        };
        Contact::new(&skin, parameters[LN_SIGMA_T].exp()).ok()
    }

    /// Returns the contact at a sample.
    pub(super) fn contact_at(&self, contact: &Contact, sample: usize) -> Contact {
        self.loads
            .contact(&self.trend.contact(contact, sample), sample)
    }
}
