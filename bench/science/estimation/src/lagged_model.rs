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
//! Z_c = (η − i) k_c/ω,  Z_f = Z_t Z_c/(Z_t + Z_c)              contact and finger (Eqs. 6, 9)
//! Z_m = Z_p + Δ + s Z_f/(1 + Y Z_f) + transient                s = L r² e^(iφ), Y = i y_r
//! ```
//!
//! Parameters are ln σ_t, Z_t, τ, Δ, ln S, ln q0, ln η, ν, T, p, ln r, φ and y_r; ln L and ln F are 0 except in the effect of
//! calibration errors. p_c = 0.375 q0 σ_t E/(1 − ν_P²) with Poisson's ratio ν_P. A finger where the mode shape is r times that
//! at the pickup is driven at r ṽ_p, and its force acts on the mode as r f̃_c: hence r². Other modes, of mobility Y at the
//! finger, slow the plate under it: from ṽ_f = ṽ_p − Y f̃_c and f̃_c = Z_f ṽ_f follow f̃_c/ṽ_p = Z_f/(1 + Y Z_f) and
//! ṽ_f/ṽ_p = 1/(1 + Y Z_f). `dynamic` has ν = T = p = ln r = φ = y_r = 0. Within an instance ln σ_t, Z_t, Z_p and φ may be
//! linear in time (`trend.rs`).

use crate::first_order_lag::{GrowingLag, GrowthLaw};
use nalgebra::DMatrix;
use num_complex::Complex64;

use super::conditions::FitConditions;
use super::fit_error::FitError;
use super::least_squares::ImpedanceModel;
use super::loads::Loads;
use super::series::InstanceSeries;
use super::transient::{Row, Transient};
use super::trend::Trend;
use contact::AssumedConstants;
use contact::CalibrationErrors;
use contact::parameters::{
    AREA_EXPONENT, FILM_MEAN_MS, FILM_MOBILITY, FINGER_ANGLE, FINGER_SLOPES, IM_OFFSET, IM_Z_T,
    LAG_EXPONENT, LN_AREA, LN_FINGER, LN_FORCE, LN_LOSS_FACTOR, LN_Q0, LN_RATIO, LN_SIGMA_T, MS,
    PARAMETERS, RE_OFFSET, RE_Z_T, RESIDUAL_MOBILITY, TAU_MS,
};
use contact::{Contact, equilibrium_gaps};

/// Gap at which τ has its parameter value if it grows with the gap, m.
pub(super) const LAG_REFERENCE_GAP_M: f64 = 10e-6;

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
    equilibrium: Vec<f64>,
    pub(super) gap: Vec<f64>,
    gap_slopes: GapSlopes,
    /// ∂Z_m/∂gap of each sample of the instance, N·s/m².
    by_gap: Vec<Complex64>,
    /// ∂Z_m/∂ ln S at a fixed gap, N·s/m.
    by_ln_area: Vec<Complex64>,
    area_exponent: f64,
}

/// Parameters that the lagged gap depends on, those of its equilibrium first.
pub(super) const GAP_PARAMETERS: [usize; 10] = [
    LN_SIGMA_T,
    LN_AREA,
    LN_Q0,
    AREA_EXPONENT,
    FILM_MEAN_MS,
    LN_RATIO,
    FILM_MOBILITY,
    TAU_MS,
    LAG_EXPONENT,
    LN_FORCE,
];
/// Number of parameters that the equilibrium depends on.
const EQUILIBRIUM_COUNT: usize = 7;
/// Index of ln S in [`GAP_PARAMETERS`].
const AREA: usize = 1;

/// Derivatives of the lagged gap by the parameters, m.
struct GapSlopes {
    equilibrium: [Vec<f64>; EQUILIBRIUM_COUNT],
    /// Slopes of the lagged gap, except by the force: a larger force is equivalent to a smaller area.
    gap: [Vec<f64>; GAP_PARAMETERS.len() - 1],
    /// Lag last applied to the gap.
    lag: GrowingLag,
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
            gap_slopes: GapSlopes {
                equilibrium: std::array::from_fn(|_| zeros()),
                gap: std::array::from_fn(|_| zeros()),
                lag: GrowingLag::new(samples.time_s.len()),
            },
            by_gap: vec![Complex64::ZERO; samples.time_s.len() - lead],
            by_ln_area: vec![Complex64::ZERO; samples.time_s.len() - lead],
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

    /// Computes the gap and its slopes; `None` where the model allows no such contact.
    pub(super) fn follow(&mut self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let contact = self.follow_gap(parameters)?;
        let (loads, trend) = (&self.loads, &self.trend);
        let force_factor = parameters[LN_FORCE].exp();
        let slopes = &mut self.gap_slopes;
        for (sample, (&gap, &normal_n)) in self.equilibrium.iter().zip(self.normal_n).enumerate() {
            let equilibrium_slopes = loads
                .contact(&trend.contact(&contact, sample), sample)
                .equilibrium_gap_slopes_m(gap, force_factor * normal_n);
            for (slope, parameter) in slopes.equilibrium.iter_mut().zip(GAP_PARAMETERS) {
                slope[sample] = equilibrium_slopes.by(parameter, &loads.slopes[sample]);
            }
        }
        // For p = 0 the lag is linear in its input, and ∂x/∂θ is the lag of ∂x_eq/∂θ; for p ≠ 0 it also carries ∂τ/∂x ∂x/∂θ
        // (`GrowingLag`).
        slopes.follow(&self.equilibrium, &self.gap, MS / self.interval_s);
        Some(contact)
    }

    /// Computes the gap without slopes.
    pub(super) fn follow_gap(&mut self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let contact = self.contact(parameters)?;
        self.loads.follow(
            parameters[AREA_EXPONENT],
            (parameters[LN_RATIO], parameters[FILM_MOBILITY]),
            parameters[FILM_MEAN_MS] * MS / self.interval_s,
            MS / self.interval_s,
        )?;
        let (loads, trend) = (&self.loads, &self.trend);
        let force_factor = parameters[LN_FORCE].exp();
        let samples = (0..self.gap.len()).map(|sample| {
            (
                loads.contact(&trend.contact(&contact, sample), sample),
                loads.amplitude_m[sample],
                force_factor * self.normal_n[sample],
            )
        });
        equilibrium_gaps(samples, &mut self.equilibrium).ok()?;
        let law = GrowthLaw {
            tau: parameters[TAU_MS] * MS / self.interval_s,
            exponent: parameters[LAG_EXPONENT],
            reference: LAG_REFERENCE_GAP_M,
        };
        self.gap_slopes
            .lag
            .follow(law, &self.equilibrium, &mut self.gap);
        self.gap.iter().all(|gap| *gap > 0.0).then_some(contact)
    }

    /// Returns the derivative of Z_m at each sample of the instance, real parts first, by the logarithm of the normal force at
    /// each sample, lead-in included, after [`evaluate`](ImpedanceModel::evaluate).
    pub(super) fn response_to_force(&self) -> DMatrix<f64> {
        let (samples, total) = (self.z_m.len(), self.gap.len());
        // x_eq depends on f_n/S_f alone, and S_f goes with f_n^ν: ∂x_eq/∂ ln f_n = (ν − 1) ∂x_eq/∂ ln S at the same sample. The
        // lag spreads it over the neighbours and all later samples. k_c at a fixed gap goes with S_f:
        // ∂Z_m(t)/∂ ln f_n(t′) = (∂Z_m/∂x)(t) ∂x(t)/∂ ln f_n(t′) + δ(t, t′) ν ∂Z_m/∂ ln S.
        let area_slope = self.area_exponent - 1.0;
        let mut response = DMatrix::zeros(2 * samples, total);
        let (mut impulse, mut gap) = (vec![0.0; total], vec![0.0; total]);
        for (sample, &by_ln_area) in self.gap_slopes.equilibrium[AREA].iter().enumerate() {
            impulse[sample] = area_slope * by_ln_area;
            self.gap_slopes.lag.slope_by_input(&impulse, &mut gap);
            impulse[sample] = 0.0;
            for (index, &by_gap) in self.by_gap.iter().enumerate() {
                let mut by_force = by_gap * gap[self.lead + index];
                if self.lead + index == sample {
                    by_force += self.by_ln_area[index] * self.area_exponent;
                }
                response[(index, sample)] = by_force.re;
                response[(samples + index, sample)] = by_force.im;
            }
        }
        response
    }

    /// Computes the impedance due to the skin's inertia, taking the fitted reactance as that of a mass or a spring alone. With
    /// both, it may vary more steeply with frequency (Foster 1924), which the carrier does not show.
    pub(super) fn follow_transient(&mut self, parameters: &[f64; PARAMETERS]) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let (finger_parameters, omega) =
            (FingerParameters::new(parameters), self.carrier_rad_per_s);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, omega);
        let rows: Vec<Row> = (self.lead..self.gap.len())
            .map(|sample| {
                let k_c = self
                    .contact_at(&contact, sample)
                    .stiffness_n_per_m(self.gap[sample], self.loads.amplitude_m[sample]);
                let z = self.sample_impedance(&finger_parameters, z_c_per_stiffness * k_c, sample);
                // A mass has m_t = Im Z_t/ω. For a spring, k_t/ω² = |Im Z_t|/ω takes its place, as k_c/ω² does for the contact.
                // ∂Z_m/∂Z_f = s/(1 + Y Z_f)² carries the finger's transient over to Z_m.
                Row {
                    contact_fraction: z.z_t / z.z_sum,
                    skin_fraction: z.z_c / z.z_sum,
                    contact_kg: k_c / omega.powi(2),
                    skin_kg: z.z_t.im.abs() / omega,
                    finger_factor: z.mobility_factor * z.mobility_factor * z.finger_scale,
                }
            })
            .collect();
        self.transient.follow(&rows);
        Some(())
    }

    /// Computes the film's motion by other modes, which the finger drives: with their residual mobility Y, its velocity is
    /// 1 − Y Z times that at the pickup.
    pub(super) fn follow_other_modes(&mut self, parameters: &[f64; PARAMETERS]) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let finger_parameters = FingerParameters::new(parameters);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for sample in 0..self.gap.len() {
            let k_c = self
                .contact_at(&contact, sample)
                .stiffness_n_per_m(self.gap[sample], self.loads.amplitude_m[sample]);
            let z = self.sample_impedance(&finger_parameters, z_c_per_stiffness * k_c, sample);
            // |1 − i y_f Z|² ≈ 1 + 2 y_f Im Z, so ∂ ln a²/∂y_f = 2 Im Z.
            self.loads.slopes[sample].ln_film_by_mobility = 2.0 * z.z_finger.im;
        }
        Some(())
    }

    /// Returns the measured Z_m minus the contribution of the skin's inertia, N·s/m.
    pub(super) fn z_m_without_inertia(&self) -> Vec<Complex64> {
        let samples = self.z_m.iter().zip(&self.transient.n_s_per_m);
        samples.map(|(z_m, inertia)| z_m - inertia).collect()
    }

    /// Returns the contact at a sample.
    pub(super) fn contact_at(&self, contact: &Contact, sample: usize) -> Contact {
        self.loads
            .contact(&self.trend.contact(contact, sample), sample)
    }

    /// Returns the derivatives of the gap at a sample by the parameters in [`GAP_PARAMETERS`], m.
    pub(super) fn gap_slopes_m(&self, sample: usize) -> [f64; GAP_PARAMETERS.len()] {
        let gap_slopes = &self.gap_slopes.gap;
        std::array::from_fn(|index| {
            gap_slopes
                .get(index)
                .map_or(-gap_slopes[AREA][sample], |slopes| slopes[sample])
        })
    }

    /// Returns the logarithm of the ratio of the instance's mean gap to the gap at which τ has its parameter value.
    pub(super) fn ln_mean_gap(&self) -> f64 {
        let instance_gap = &self.gap[self.lead..];
        (instance_gap.iter().sum::<f64>() / instance_gap.len() as f64 / LAG_REFERENCE_GAP_M).ln()
    }

    /// Returns the finger at a sample for a contact of impedance `z_c`.
    fn sample_impedance(
        &self,
        finger_parameters: &FingerParameters,
        z_c: Complex64,
        sample: usize,
    ) -> SampleImpedance {
        let z_t = self.trend.z_t(finger_parameters.z_t, sample);
        let z_sum = z_t + z_c;
        let z_finger = z_t * z_c / z_sum;
        SampleImpedance {
            z_p: self
                .trend
                .z_p(self.z_p + finger_parameters.z_p_offset, sample),
            z_t,
            z_c,
            z_sum,
            z_finger,
            mobility_factor: (1.0 + finger_parameters.residual_mobility * z_finger).inv(),
            finger_scale: self
                .trend
                .finger_scale(finger_parameters.finger_scale, sample),
        }
    }

    /// Writes Z_m at each sample, like [`evaluate`](ImpedanceModel::evaluate) but without slopes.
    pub(super) fn impedances(
        &mut self,
        parameters: &[f64; PARAMETERS],
        z_m: &mut [Complex64],
    ) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let finger_parameters = FingerParameters::new(parameters);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for (index, z_m) in z_m.iter_mut().enumerate() {
            let sample = self.lead + index;
            let k_c = self
                .contact_at(&contact, sample)
                .stiffness_n_per_m(self.gap[sample], self.loads.amplitude_m[sample]);
            let z = self.sample_impedance(&finger_parameters, z_c_per_stiffness * k_c, sample);
            *z_m = z.z_p + z.finger() + self.transient.n_s_per_m[index];
        }
        Some(())
    }

    /// Returns the best-fitting candidate with its best Z_t; `None` where the model allows none of the candidates.
    ///
    /// Given the gap, 1/(Z_m − Z_p) = 1/Z_t + 1/Z_c is linear in 1/Z_t; its estimate is the mean weighted like the impedance
    /// residuals. The plate is taken as unloaded, and s = 1, Y = 0.
    pub(super) fn best_start(
        &mut self,
        candidates: impl IntoIterator<Item = [f64; PARAMETERS]>,
    ) -> Option<[f64; PARAMETERS]> {
        let mut best: Option<(f64, [f64; PARAMETERS])> = None;
        for mut parameters in candidates {
            let Some(contact) = self.follow_gap(&parameters) else {
                continue;
            };
            let (z_t, squares) = self.tissue_given_gap(&contact, self.z_p);
            (parameters[RE_Z_T], parameters[IM_Z_T]) = (z_t.re, z_t.im);
            if z_t.is_finite() && best.is_none_or(|(min_squares, _)| squares < min_squares) {
                best = Some((squares, parameters));
            }
        }
        best.map(|(_, parameters)| parameters)
    }

    /// Returns the best Z_t for the gap computed by [`follow`](Self::follow), and the weighted sum of squared residuals.
    pub(super) fn tissue_given_gap(&self, contact: &Contact, z_p: Complex64) -> (Complex64, f64) {
        let (mut sum, mut squares, mut weights) = (Complex64::ZERO, 0.0, 0.0);
        let film = self.gap[self.lead..]
            .iter()
            .zip(&self.loads.amplitude_m[self.lead..]);
        for (index, (&z_m, (&gap, &amplitude))) in self.z_m.iter().zip(film).enumerate() {
            let contact = self.contact_at(contact, self.lead + index);
            let finger = z_m - z_p;
            let z_c = contact.impedance_n_s_per_m(
                contact.stiffness_n_per_m(gap, amplitude),
                self.carrier_rad_per_s,
            );
            // m = 1/(Z_m − Z_p) − 1/Z_c is one reading of 1/Z_t. An error δm is one of −(Z_m − Z_p)² δm in Z_m, so
            // Σ|Z_m − Ẑ_m|² ≈ Σ w |m − 1/Z_t|² with w = |Z_m − Z_p|⁴. Minimum: 1/Z_t = Σ w m/Σ w, and there
            // Σ w |m|² − |Σ w m|²/Σ w.
            let weight = finger.norm_sqr().powi(2);
            if weight > 0.0 {
                let tissue_mobility = finger.inv() - z_c.inv();
                sum += weight * tissue_mobility;
                squares += weight * tissue_mobility.norm_sqr();
                weights += weight;
            }
        }
        (weights / sum, squares - sum.norm_sqr() / weights)
    }
}

impl ImpedanceModel<PARAMETERS> for LaggedModel<'_> {
    fn measurement(&self) -> &[Complex64] {
        self.z_m
    }

    /// White noise of force and velocity becomes noise of their ratio that grows as 1/|ṽ_p|.
    fn noise_shape(&self, index: usize) -> f64 {
        self.amplitude_m[self.lead + index].recip()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64; PARAMETERS],
        z_m: &mut [Complex64],
        slopes: &mut [[Complex64; PARAMETERS]],
    ) -> Option<()> {
        let contact = self.follow(parameters)?;
        self.area_exponent = parameters[AREA_EXPONENT];
        let loss_factor = parameters[LN_LOSS_FACTOR].exp();
        let finger_parameters = FingerParameters::new(parameters);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for index in 0..z_m.len() {
            let sample = self.lead + index;
            let (gap, amplitude) = (self.gap[sample], self.loads.amplitude_m[sample]);
            let contact = self.contact_at(&contact, sample);
            let by_gap = contact.stiffness_slope_n_per_m2(gap, amplitude);
            let fixed_gap_slopes = contact.stiffness_slopes_n_per_m(gap, amplitude);
            let k_c = contact.stiffness_n_per_m(gap, amplitude);
            let z = self.sample_impedance(&finger_parameters, z_c_per_stiffness * k_c, sample);
            // From 1/Z_f = 1/Z_t + 1/Z_c: ∂Z_f/∂Z_c = (Z_t/(Z_t + Z_c))², ∂Z_f/∂Z_t = (Z_c/(Z_t + Z_c))². With Y = i y_r,
            // d(s Z_f/(1 + Y Z_f)) = s (dZ_f − Z_f² dY)/(1 + Y Z_f)² + (s Z_f/(1 + Y Z_f)) d ln s.
            // A parameter of contact or load acts on k_c at a fixed gap and through the lagged gap:
            // dk_c/dθ = ∂k_c/∂θ + (∂k_c/∂x) ∂x/∂θ. Z_c = (η − i) k_c/ω gives ∂Z_c/∂k_c = (η − i)/ω, ∂Z_c/∂ ln η = η k_c/ω.
            let by_z_finger = z.mobility_factor * z.mobility_factor * z.finger_scale;
            let by_z_c = (z.z_t / z.z_sum).powi(2) * by_z_finger;
            let by_stiffness = by_z_c * z_c_per_stiffness;
            let by_z_t = (z.z_c / z.z_sum).powi(2) * by_z_finger;
            let finger = z.finger();
            z_m[index] = z.z_p + finger + self.transient.n_s_per_m[index];
            self.by_gap[index] = by_stiffness * by_gap;
            self.by_ln_area[index] = by_stiffness * fixed_gap_slopes.by_ln_area;
            let slope = &mut slopes[index];
            for (parameter, gap_slope) in GAP_PARAMETERS.into_iter().zip(self.gap_slopes_m(sample))
            {
                let stiffness_slope =
                    fixed_gap_slopes.by(parameter, &self.loads.slopes[sample]) + by_gap * gap_slope;
                slope[parameter] = by_stiffness * stiffness_slope;
            }
            slope[LN_RATIO] += finger * FINGER_SLOPES[LN_RATIO];
            for parameter in [FINGER_ANGLE, LN_FINGER] {
                slope[parameter] = finger * FINGER_SLOPES[parameter];
            }
            slope[RESIDUAL_MOBILITY] = -Complex64::I * z.z_finger * z.z_finger * by_z_finger;
            slope[RE_Z_T] = by_z_t;
            slope[IM_Z_T] = by_z_t * Complex64::I;
            slope[IM_OFFSET] = Complex64::I;
            slope[RE_OFFSET] = Complex64::ONE;
            slope[LN_LOSS_FACTOR] = by_z_c * (loss_factor * k_c / self.carrier_rad_per_s);
        }
        Some(())
    }
}

/// Parameters that act on the impedance of a sample, apart from those of its contact.
struct FingerParameters {
    z_t: Complex64,
    z_p_offset: Complex64,
    finger_scale: Complex64,
    residual_mobility: Complex64,
}

impl FingerParameters {
    fn new(parameters: &[f64; PARAMETERS]) -> Self {
        Self {
            z_t: Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]),
            z_p_offset: Complex64::new(parameters[RE_OFFSET], parameters[IM_OFFSET]),
            finger_scale: finger_scale(parameters),
            residual_mobility: Complex64::I * parameters[RESIDUAL_MOBILITY],
        }
    }
}

/// Finger at a sample: Eqs. 9 to 11 and the effect of other modes of the plate.
struct SampleImpedance {
    z_p: Complex64,
    z_t: Complex64,
    z_c: Complex64,
    z_sum: Complex64,
    /// Z_t Z_c/(Z_t + Z_c).
    z_finger: Complex64,
    /// Factor that the other modes apply to `z_finger`.
    mobility_factor: Complex64,
    finger_scale: Complex64,
}

impl SampleImpedance {
    fn finger(&self) -> Complex64 {
        self.z_finger * self.mobility_factor * self.finger_scale
    }
}

/// Returns the ratio of the measured to the true finger part of Z_m.
pub(super) fn finger_scale(parameters: &[f64; PARAMETERS]) -> Complex64 {
    let ln_scale = 2.0 * parameters[LN_RATIO] + parameters[LN_FINGER];
    Complex64::from_polar(ln_scale.exp(), parameters[FINGER_ANGLE])
}

impl GapSlopes {
    /// Computes the slopes of the gap that lags behind its equilibrium.
    fn follow(&mut self, equilibrium: &[f64], gap: &[f64], intervals_per_ms: f64) {
        self.lag.differentiate(equilibrium, gap);
        let (equilibrium_slopes, lag_slopes) = self.gap.split_at_mut(EQUILIBRIUM_COUNT);
        for (equilibrium_slope, gap_slope) in self.equilibrium.iter().zip(equilibrium_slopes) {
            self.lag.slope_by_input(equilibrium_slope, gap_slope);
        }
        let [by_tau_ms, by_exponent] = lag_slopes else {
            unreachable!("the slopes by the lag's two parameters come last")
        };
        self.lag.slope_by_tau(by_tau_ms);
        by_tau_ms
            .iter_mut()
            .for_each(|slope| *slope *= intervals_per_ms);
        self.lag.slope_by_exponent(by_exponent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::tests::assert_slopes_are_derivatives;
    use crate::series::tests::with_instance;

    /// Compares with the impedance under a force that is larger at one sample.
    #[test]
    fn the_response_to_the_force_is_the_derivative() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let (samples, _) = instance.with_lead_in(0.02).unwrap();
            let force = samples.normal_n.to_vec();
            let impedance = |normal_n: &[f64], exponent: f64| {
                let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
                model.normal_n = normal_n;
                model.loads = Loads::new(samples.amplitude_m, normal_n, 0.6);
                let mut parameters = model.assumed_parameters(1.7e-6, 1.2e-3);
                (
                    parameters[RE_Z_T],
                    parameters[IM_Z_T],
                    parameters[AREA_EXPONENT],
                ) = (0.47, 3.16, exponent);
                let n = model.z_m.len();
                let mut z_m = vec![Complex64::ZERO; n];
                let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
                model.evaluate(&parameters, &mut z_m, &mut slopes).unwrap();
                (z_m, model.response_to_force())
            };
            for exponent in [0.0, 0.5] {
                let (_, response) = impedance(&force, exponent);
                for sample in [10, 60, 100] {
                    let step = 1e-5;
                    let impedance_with = |sign: f64| {
                        let mut force = force.clone();
                        force[sample] *= (sign * step).exp();
                        impedance(&force, exponent).0
                    };
                    let (above, below) = (impedance_with(1.0), impedance_with(-1.0));
                    for (index, (above, below)) in above.iter().zip(&below).enumerate() {
                        let slope = (above - below) / (2.0 * step);
                        let n = response.nrows() / 2;
                        let expected = Complex64::new(
                            response[(index, sample)],
                            response[(n + index, sample)],
                        );
                        assert!(
                            (slope - expected).norm() < 1e-5,
                            "{sample} {index}: {slope} {expected}"
                        );
                    }
                }
            }
        });
    }

    #[test]
    fn the_impedance_is_the_same_without_slopes() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
            let mut parameters = model.assumed_parameters(1.7e-6, 1.2e-3);
            (
                parameters[RE_Z_T],
                parameters[IM_Z_T],
                parameters[AREA_EXPONENT],
            ) = (0.47, 3.16, 0.3);
            (parameters[FINGER_ANGLE], parameters[RESIDUAL_MOBILITY]) = (0.03, 0.02);
            let n = model.z_m.len();
            let mut z_m = vec![Complex64::ZERO; n];
            let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
            model.evaluate(&parameters, &mut z_m, &mut slopes).unwrap();
            let mut z_m_without_slopes = vec![Complex64::ZERO; n];
            model
                .impedances(&parameters, &mut z_m_without_slopes)
                .unwrap();
            assert_eq!(z_m, z_m_without_slopes);
        });
    }

    #[test]
    fn slopes_are_derivatives() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
            for (tau_s, area_ratio) in [(-0.2e-3, 1.0), (0.05e-3, 0.6), (1.2e-3, 1.3)] {
                let mut parameters = model.assumed_parameters(1.7e-6, tau_s);
                parameters[RE_Z_T] = 0.47;
                parameters[IM_Z_T] = 3.16;
                parameters[IM_OFFSET] = -0.3;
                parameters[RE_OFFSET] = 0.2;
                parameters[LN_AREA] += f64::ln(area_ratio);
                assert_slopes_are_derivatives(&mut model, parameters);
                parameters[TAU_MS] = parameters[TAU_MS].max(0.3);
                parameters[AREA_EXPONENT] = 0.4;
                parameters[FILM_MEAN_MS] = 0.2;
                parameters[LAG_EXPONENT] = 0.3;
                parameters[LN_RATIO] = -0.04;
                parameters[RESIDUAL_MOBILITY] = 0.02;
                parameters[FINGER_ANGLE] = 0.03;
                (parameters[LN_FINGER], parameters[LN_FORCE]) = (0.02, -0.05);
                model.follow_other_modes(&parameters).unwrap();
                parameters[FILM_MOBILITY] = 0.01;
                assert_slopes_are_derivatives(&mut model, parameters);
            }
        });
    }
}
