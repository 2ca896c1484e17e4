//! Model fitted by `dynamic` and `trial`: the impedance of one instance with a gap that lags behind its equilibrium.

use first_order_lag::{GrowingLag, GrowthLaw};
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
pub(super) const OF_GAP: [usize; 10] = [
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
const OF_EQUILIBRIUM: usize = 7;
/// Index of ln S in [`OF_GAP`].
const AREA: usize = 1;

/// Derivatives of the lagged gap by the parameters, m.
struct GapSlopes {
    unlagged: [Vec<f64>; OF_EQUILIBRIUM],
    /// Slopes of the lagged gap, except by the force: a larger force is equivalent to a smaller area.
    lagged: [Vec<f64>; OF_GAP.len() - 1],
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
                unlagged: std::array::from_fn(|_| zeros()),
                lagged: std::array::from_fn(|_| zeros()),
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
        let heavier = parameters[LN_FORCE].exp();
        let slopes = &mut self.gap_slopes;
        for (at, (&gap, &normal_n)) in self.equilibrium.iter().zip(self.normal_n).enumerate() {
            let of_gap = loads
                .contact(&trend.contact(&contact, at), at)
                .equilibrium_gap_slopes_m(gap, heavier * normal_n);
            for (unlagged, parameter) in slopes.unlagged.iter_mut().zip(OF_GAP) {
                unlagged[at] = of_gap.by(parameter, &loads.slopes[at]);
            }
        }
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
        let heavier = parameters[LN_FORCE].exp();
        let each = (0..self.gap.len()).map(|at| {
            (
                loads.contact(&trend.contact(&contact, at), at),
                loads.amplitude_m[at],
                heavier * self.normal_n[at],
            )
        });
        equilibrium_gaps(each, &mut self.equilibrium).ok()?;
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
        let (samples, all) = (self.z_m.len(), self.gap.len());
        // A larger force is equivalent to a smaller area, apart from the growth of the area.
        let smaller = self.area_exponent - 1.0;
        let mut response = DMatrix::zeros(2 * samples, all);
        let (mut impulse, mut gap) = (vec![0.0; all], vec![0.0; all]);
        for (at, &by_ln_area) in self.gap_slopes.unlagged[AREA].iter().enumerate() {
            impulse[at] = smaller * by_ln_area;
            self.gap_slopes.lag.slope_by_input(&impulse, &mut gap);
            impulse[at] = 0.0;
            for (index, &by_gap) in self.by_gap.iter().enumerate() {
                let mut of = by_gap * gap[self.lead + index];
                if self.lead + index == at {
                    of += self.by_ln_area[index] * self.area_exponent;
                }
                response[(index, at)] = of.re;
                response[(samples + index, at)] = of.im;
            }
        }
        response
    }

    /// Computes the impedance due to the skin's inertia, taking the fitted reactance as that of a mass or a spring alone. With
    /// both, it may vary more steeply with frequency (Foster 1924), which the carrier does not show.
    pub(super) fn follow_transient(&mut self, parameters: &[f64; PARAMETERS]) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let (fitted, omega) = (Fitted::new(parameters), self.carrier_rad_per_s);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, omega);
        let rows: Vec<Row> = (self.lead..self.gap.len())
            .map(|at| {
                let k_c = self
                    .contact_at(&contact, at)
                    .stiffness_n_per_m(self.gap[at], self.loads.amplitude_m[at]);
                let seen = self.seen(&fitted, z_c_per_stiffness * k_c, at);
                Row {
                    on_contact: seen.z_t / seen.both,
                    on_skin: seen.z_c / seen.both,
                    contact_kg: k_c / omega.powi(2),
                    skin_kg: seen.z_t.im.abs() / omega,
                    seen: seen.part * seen.part * seen.finger_scale,
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
        let fitted = Fitted::new(parameters);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for at in 0..self.gap.len() {
            let k_c = self
                .contact_at(&contact, at)
                .stiffness_n_per_m(self.gap[at], self.loads.amplitude_m[at]);
            let seen = self.seen(&fitted, z_c_per_stiffness * k_c, at);
            self.loads.slopes[at].ln_film_by_mobility = 2.0 * seen.alone.im;
        }
        Some(())
    }

    /// Returns the measured Z_m minus the contribution of the skin's inertia, N·s/m.
    pub(super) fn z_m_at_rest(&self) -> Vec<Complex64> {
        let each = self.z_m.iter().zip(&self.transient.n_s_per_m);
        each.map(|(z_m, added)| z_m - added).collect()
    }

    /// Returns the contact at a sample.
    pub(super) fn contact_at(&self, contact: &Contact, at: usize) -> Contact {
        self.loads.contact(&self.trend.contact(contact, at), at)
    }

    /// Returns the derivatives of the gap at a sample by the parameters in [`OF_GAP`], m.
    pub(super) fn gap_slopes_m(&self, at: usize) -> [f64; OF_GAP.len()] {
        let lagged = &self.gap_slopes.lagged;
        std::array::from_fn(|index| lagged.get(index).map_or(-lagged[AREA][at], |of| of[at]))
    }

    /// Returns the logarithm of the ratio of the instance's mean gap to the gap at which τ has its parameter value.
    pub(super) fn ln_mean_gap(&self) -> f64 {
        let inside = &self.gap[self.lead..];
        (inside.iter().sum::<f64>() / inside.len() as f64 / LAG_REFERENCE_GAP_M).ln()
    }

    /// Returns the finger at a sample for a contact of impedance `z_c`.
    fn seen(&self, fitted: &Fitted, z_c: Complex64, at: usize) -> Seen {
        let z_t = self.trend.z_t(fitted.z_t, at);
        let both = z_t + z_c;
        let alone = z_t * z_c / both;
        Seen {
            z_p: self.trend.z_p(self.z_p + fitted.z_p_offset, at),
            z_t,
            z_c,
            both,
            alone,
            part: (1.0 + fitted.residual_mobility * alone).inv(),
            finger_scale: self.trend.finger_scale(fitted.finger_scale, at),
        }
    }

    /// Writes Z_m at each sample, like [`evaluate`](ImpedanceModel::evaluate) but without slopes.
    pub(super) fn impedances(
        &mut self,
        parameters: &[f64; PARAMETERS],
        z_m: &mut [Complex64],
    ) -> Option<()> {
        let contact = self.follow_gap(parameters)?;
        let fitted = Fitted::new(parameters);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for (index, z_m) in z_m.iter_mut().enumerate() {
            let at = self.lead + index;
            let k_c = self
                .contact_at(&contact, at)
                .stiffness_n_per_m(self.gap[at], self.loads.amplitude_m[at]);
            let seen = self.seen(&fitted, z_c_per_stiffness * k_c, at);
            *z_m = seen.z_p + seen.finger() + self.transient.n_s_per_m[index];
        }
        Some(())
    }

    /// Returns the best-fitting candidate with its best Z_t; `None` where the model allows none of the candidates.
    ///
    /// Given the gap, 1/(Z_m − Z_p) = 1/Z_t + 1/Z_c is linear in 1/Z_t; its estimate is the mean weighted like the impedance
    /// residuals. The plate is taken as unloaded.
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
            if z_t.is_finite() && best.is_none_or(|(least, _)| squares < least) {
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
            let weight = finger.norm_sqr().powi(2);
            if weight > 0.0 {
                let of_tissue = finger.inv() - z_c.inv();
                sum += weight * of_tissue;
                squares += weight * of_tissue.norm_sqr();
                weights += weight;
            }
        }
        (weights / sum, squares - sum.norm_sqr() / weights)
    }
}

impl ImpedanceModel<PARAMETERS> for LaggedModel<'_> {
    fn measured(&self) -> &[Complex64] {
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
        let fitted = Fitted::new(parameters);
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for index in 0..z_m.len() {
            let at = self.lead + index;
            let (gap, amplitude) = (self.gap[at], self.loads.amplitude_m[at]);
            let contact = self.contact_at(&contact, at);
            let by_gap = contact.stiffness_slope_n_per_m2(gap, amplitude);
            let at_gap = contact.stiffness_slopes_n_per_m(gap, amplitude);
            let k_c = contact.stiffness_n_per_m(gap, amplitude);
            let seen = self.seen(&fitted, z_c_per_stiffness * k_c, at);
            let by_alone = seen.part * seen.part * seen.finger_scale;
            let by_z_c = (seen.z_t / seen.both).powi(2) * by_alone;
            let by_stiffness = by_z_c * z_c_per_stiffness;
            let by_z_t = (seen.z_c / seen.both).powi(2) * by_alone;
            let finger = seen.finger();
            z_m[index] = seen.z_p + finger + self.transient.n_s_per_m[index];
            self.by_gap[index] = by_stiffness * by_gap;
            self.by_ln_area[index] = by_stiffness * at_gap.by_ln_area;
            let slope = &mut slopes[index];
            for (parameter, of_gap) in OF_GAP.into_iter().zip(self.gap_slopes_m(at)) {
                let stiffness = at_gap.by(parameter, &self.loads.slopes[at]) + by_gap * of_gap;
                slope[parameter] = by_stiffness * stiffness;
            }
            slope[LN_RATIO] += finger * FINGER_SLOPES[LN_RATIO];
            for parameter in [FINGER_ANGLE, LN_FINGER] {
                slope[parameter] = finger * FINGER_SLOPES[parameter];
            }
            slope[RESIDUAL_MOBILITY] = -Complex64::I * seen.alone * seen.alone * by_alone;
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
struct Fitted {
    z_t: Complex64,
    z_p_offset: Complex64,
    finger_scale: Complex64,
    residual_mobility: Complex64,
}

impl Fitted {
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
struct Seen {
    z_p: Complex64,
    z_t: Complex64,
    z_c: Complex64,
    both: Complex64,
    /// Z_t Z_c/(Z_t + Z_c).
    alone: Complex64,
    /// Factor that the other modes apply to `alone`.
    part: Complex64,
    finger_scale: Complex64,
}

impl Seen {
    fn finger(&self) -> Complex64 {
        self.alone * self.part * self.finger_scale
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
        let (of_equilibrium, of_lag) = self.lagged.split_at_mut(OF_EQUILIBRIUM);
        for (unlagged, lagged) in self.unlagged.iter().zip(of_equilibrium) {
            self.lag.slope_by_input(unlagged, lagged);
        }
        let [by_tau_ms, by_exponent] = of_lag else {
            unreachable!("the slopes by the lag's two parameters come last")
        };
        self.lag.slope_by_tau(by_tau_ms);
        by_tau_ms.iter_mut().for_each(|of| *of *= intervals_per_ms);
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
                let mut at = model.assumed_parameters(1.7e-6, 1.2e-3);
                (at[RE_Z_T], at[IM_Z_T], at[AREA_EXPONENT]) = (0.47, 3.16, exponent);
                let n = model.z_m.len();
                let mut z_m = vec![Complex64::ZERO; n];
                let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
                model.evaluate(&at, &mut z_m, &mut slopes).unwrap();
                (z_m, model.response_to_force())
            };
            for exponent in [0.0, 0.5] {
                let (_, response) = impedance(&force, exponent);
                for at in [10, 60, 100] {
                    let by = 1e-5;
                    let heavier = |sign: f64| {
                        let mut force = force.clone();
                        force[at] *= (sign * by).exp();
                        impedance(&force, exponent).0
                    };
                    let (above, below) = (heavier(1.0), heavier(-1.0));
                    for (index, (above, below)) in above.iter().zip(&below).enumerate() {
                        let slope = (above - below) / (2.0 * by);
                        let n = response.nrows() / 2;
                        let stated =
                            Complex64::new(response[(index, at)], response[(n + index, at)]);
                        assert!(
                            (slope - stated).norm() < 1e-5,
                            "{at} {index}: {slope} {stated}"
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
            let mut at = model.assumed_parameters(1.7e-6, 1.2e-3);
            (at[RE_Z_T], at[IM_Z_T], at[AREA_EXPONENT]) = (0.47, 3.16, 0.3);
            (at[FINGER_ANGLE], at[RESIDUAL_MOBILITY]) = (0.03, 0.02);
            let n = model.z_m.len();
            let mut with = vec![Complex64::ZERO; n];
            let mut slopes = vec![[Complex64::ZERO; PARAMETERS]; n];
            model.evaluate(&at, &mut with, &mut slopes).unwrap();
            let mut without = vec![Complex64::ZERO; n];
            model.impedances(&at, &mut without).unwrap();
            assert_eq!(with, without);
        });
    }

    #[test]
    fn slopes_are_derivatives() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02, 0.6).unwrap();
            for (tau_s, area_ratio) in [(-0.2e-3, 1.0), (0.05e-3, 0.6), (1.2e-3, 1.3)] {
                let mut at = model.assumed_parameters(1.7e-6, tau_s);
                at[RE_Z_T] = 0.47;
                at[IM_Z_T] = 3.16;
                at[IM_OFFSET] = -0.3;
                at[RE_OFFSET] = 0.2;
                at[LN_AREA] += f64::ln(area_ratio);
                assert_slopes_are_derivatives(&mut model, at);
                at[TAU_MS] = at[TAU_MS].max(0.3);
                at[AREA_EXPONENT] = 0.4;
                at[FILM_MEAN_MS] = 0.2;
                at[LAG_EXPONENT] = 0.3;
                at[LN_RATIO] = -0.04;
                at[RESIDUAL_MOBILITY] = 0.02;
                at[FINGER_ANGLE] = 0.03;
                (at[LN_FINGER], at[LN_FORCE]) = (0.02, -0.05);
                model.follow_other_modes(&at).unwrap();
                at[FILM_MOBILITY] = 0.01;
                assert_slopes_are_derivatives(&mut model, at);
            }
        });
    }
}
