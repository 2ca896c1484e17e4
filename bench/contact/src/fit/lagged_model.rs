//! The model that `dynamic` and `trial` fit: the impedance of one instance, whose gap follows its equilibrium with a lag.

use num_complex::Complex64;

use super::conditions::FitConditions;
use super::fit_error::FitError;
use super::lag::Lag;
use super::least_squares::ImpedanceModel;
use super::series::InstanceSeries;
use crate::assumed::AssumedConstants;
use crate::contact::Contact;
use crate::harmonic::observed;
use crate::parameters::{
    IM_OFFSET, IM_Z_T, LN_AREA, LN_LOSS_FACTOR, LN_Q0, LN_SIGMA_T, MS, PARAMETERS, RE_OFFSET,
    RE_Z_T, TAU_MS,
};

/// An instance with its lead-in and room for the gap that goes with the parameters tried last.
pub(super) struct LaggedModel<'a> {
    assumed: AssumedConstants,
    pub(super) carrier_rad_per_s: f64,
    pub(super) interval_s: f64,
    pub(super) z_p: Complex64,
    /// Amplitude, with `lead` samples before the instance, m.
    pub(super) amplitude_m: &'a [f64],
    /// Normal force, N.
    pub(super) normal_n: &'a [f64],
    pub(super) lead: usize,
    /// Measured Z_m of the instance alone, N·s/m.
    pub(super) z_m: &'a [Complex64],
    equilibrium: Vec<f64>,
    pub(super) gap: Vec<f64>,
    pub(super) gap_slopes: GapSlopes,
}

/// How the lagged gap depends on the parameters: by the logarithms of σ_t, S and q0, m, and by τ in sampling intervals.
#[derive(Default)]
pub(super) struct GapSlopes {
    pub(super) by_ln_sigma_t: Vec<f64>,
    pub(super) by_ln_area: Vec<f64>,
    pub(super) by_ln_q0: Vec<f64>,
    by_lag: Vec<f64>,
    unlagged: [Vec<f64>; 3],
}

impl<'a> LaggedModel<'a> {
    /// Makes the model of an instance whose gap is followed from `lead_in_s` before it.
    pub(super) fn new(
        instance: &InstanceSeries<'a>,
        conditions: &FitConditions,
        lead_in_s: f64,
    ) -> Result<Self, FitError> {
        conditions.assumed.validated()?;
        let (samples, lead) = instance.with_lead_in(lead_in_s)?;
        let zeros = || vec![0.0; samples.time_s.len()];
        Ok(Self {
            assumed: conditions.assumed,
            carrier_rad_per_s: conditions.carrier_rad_per_s()?,
            interval_s: instance.interval_s(),
            z_p: conditions.z_p_corrected_n_s_per_m,
            amplitude_m: samples.amplitude_m,
            normal_n: samples.normal_n,
            lead,
            z_m: &samples.z_m_corrected_n_s_per_m[lead..],
            equilibrium: zeros(),
            gap: zeros(),
            gap_slopes: GapSlopes {
                by_ln_sigma_t: zeros(),
                by_ln_area: zeros(),
                by_ln_q0: zeros(),
                by_lag: zeros(),
                unlagged: [zeros(), zeros(), zeros()],
            },
        })
    }

    /// Returns the parameters with the assumed skin and no offset of the plate.
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

    /// Follows the gap and its slopes; `None` where the model allows no such contact.
    pub(super) fn follow(&mut self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let contact = self.contact(parameters)?;
        contact
            .equilibrium_gaps_m(self.amplitude_m, self.normal_n, &mut self.equilibrium)
            .ok()?;
        let slopes = &mut self.gap_slopes;
        let [by_ln_sigma_t, by_ln_area, by_ln_q0] = &mut slopes.unlagged;
        for (i, (&gap, &normal_n)) in self.equilibrium.iter().zip(self.normal_n).enumerate() {
            let at = contact.equilibrium_gap_slopes_m(gap, normal_n);
            by_ln_sigma_t[i] = at.by_ln_sigma_t;
            by_ln_area[i] = at.by_ln_area;
            by_ln_q0[i] = at.by_ln_q0;
        }
        let lag = Lag::new(parameters[TAU_MS] * MS, self.interval_s);
        lag.apply(&self.equilibrium, &mut self.gap);
        lag.apply(by_ln_sigma_t, &mut slopes.by_ln_sigma_t);
        lag.apply(by_ln_area, &mut slopes.by_ln_area);
        lag.apply(by_ln_q0, &mut slopes.by_ln_q0);
        lag.slope(&self.equilibrium, &self.gap, &mut slopes.by_lag);
        self.gap.iter().all(|gap| *gap > 0.0).then_some(contact)
    }

    /// Returns ∂gap/∂τ at a sample, m/ms.
    pub(super) fn gap_by_tau_ms(&self, at: usize) -> f64 {
        self.gap_slopes.by_lag[at] * MS / self.interval_s
    }

    /// Given the gap of [`follow`](Self::follow), 1/(Z_m − Z_p) = 1/Z_t + 1/Z_c is linear in 1/Z_t: its mean, weighted as the
    /// impedance residual weighs it. The plate is taken as it was unloaded.
    pub(super) fn tissue_given_gap(&self, contact: &Contact) -> Complex64 {
        let (mut sum, mut weights) = (Complex64::ZERO, 0.0);
        let film = self.gap[self.lead..]
            .iter()
            .zip(&self.amplitude_m[self.lead..]);
        for (&z_m, (&gap, &amplitude)) in self.z_m.iter().zip(film) {
            let finger = z_m - self.z_p;
            let z_c = contact.impedance_n_s_per_m(
                contact.stiffness_n_per_m(gap, amplitude),
                self.carrier_rad_per_s,
            );
            let weight = finger.norm_sqr().powi(2);
            if weight > 0.0 {
                sum += weight * (finger.inv() - z_c.inv());
                weights += weight;
            }
        }
        weights / sum
    }

    /// Returns the parameters with the Z_t that fits best what else they say; `None` where the model allows no such contact.
    pub(super) fn with_best_tissue(
        &mut self,
        mut parameters: [f64; PARAMETERS],
    ) -> Option<[f64; PARAMETERS]> {
        let contact = self.follow(&parameters)?;
        let z_t = self.tissue_given_gap(&contact);
        parameters[RE_Z_T] = z_t.re;
        parameters[IM_Z_T] = z_t.im;
        z_t.is_finite().then_some(parameters)
    }
}

impl ImpedanceModel<PARAMETERS> for LaggedModel<'_> {
    fn measured(&self) -> &[Complex64] {
        self.z_m
    }

    /// White noise on force and velocity is noise on their ratio that grows as 1/|ṽ_p|.
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
        let z_t = Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]);
        let z_p = self.z_p + Complex64::new(parameters[RE_OFFSET], parameters[IM_OFFSET]);
        let loss_factor = parameters[LN_LOSS_FACTOR].exp();
        let z_c_per_stiffness = contact.impedance_n_s_per_m(1.0, self.carrier_rad_per_s);
        for index in 0..z_m.len() {
            let at = self.lead + index;
            let (gap, amplitude) = (self.gap[at], self.amplitude_m[at]);
            let k_c = contact.stiffness_n_per_m(gap, amplitude);
            let by_gap = contact.stiffness_slope_n_per_m2(gap, amplitude);
            let at_gap = contact.stiffness_slopes_n_per_m(gap, amplitude);
            let z_c = z_c_per_stiffness * k_c;
            let both = z_t + z_c;
            let by_z_c = (z_t / both).powi(2);
            let by_stiffness = by_z_c * z_c_per_stiffness;
            let by_z_t = (z_c / both).powi(2);
            z_m[index] = observed(z_p, z_t, z_c);
            let slope = &mut slopes[index];
            slope[LN_SIGMA_T] =
                by_stiffness * (at_gap.by_ln_sigma_t + by_gap * self.gap_slopes.by_ln_sigma_t[at]);
            slope[RE_Z_T] = by_z_t;
            slope[IM_Z_T] = by_z_t * Complex64::I;
            slope[TAU_MS] = by_stiffness * (by_gap * self.gap_by_tau_ms(at));
            slope[IM_OFFSET] = Complex64::I;
            slope[RE_OFFSET] = Complex64::ONE;
            slope[LN_AREA] =
                by_stiffness * (at_gap.by_ln_area + by_gap * self.gap_slopes.by_ln_area[at]);
            slope[LN_Q0] = by_stiffness * (at_gap.by_ln_q0 + by_gap * self.gap_slopes.by_ln_q0[at]);
            slope[LN_LOSS_FACTOR] = by_z_c * (loss_factor * k_c / self.carrier_rad_per_s);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::least_squares::tests::assert_slopes_are_derivatives;
    use crate::fit::series::tests::with_instance;

    #[test]
    fn slopes_are_derivatives() {
        with_instance(|instance| {
            let conditions = FitConditions::with_plate(Complex64::new(7.01, 0.1));
            let mut model = LaggedModel::new(instance, &conditions, 0.02).unwrap();
            for (tau_s, area_ratio) in [(-0.2e-3, 1.0), (0.05e-3, 0.6), (1.2e-3, 1.3)] {
                let mut at = model.assumed_parameters(1.7e-6, tau_s);
                at[RE_Z_T] = 0.47;
                at[IM_Z_T] = 3.16;
                at[IM_OFFSET] = -0.3;
                at[RE_OFFSET] = 0.2;
                at[LN_AREA] += f64::ln(area_ratio);
                assert_slopes_are_derivatives(&mut model, at);
            }
        });
    }
}
