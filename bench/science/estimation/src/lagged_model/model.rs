//! Model of one instance: its samples, and buffers for the gap of the last parameters tried.

use num_complex::Complex64;

use super::force_slopes::ForceSlopes;
use super::gap_slopes::GapSlopes;
use super::law_choice::Laws;
use crate::conditions::{CONTACT_WIDTH_M, FitConditions, ModeAcross};
use crate::fit_error::FitError;
use crate::loads::Loads;
use crate::series::InstanceSeries;
use crate::transient::Transient;
use crate::trend::Trend;
use contact::AssumedConstants;
use contact::CalibrationErrors;
use contact::Contact;
use contact::mode_moments::ModeMoments;
use contact::parameters::{
    LN_AREA, LN_LOSS_FACTOR, LN_Q0, LN_SIGMA_T, MS, PARAMETERS, TAU_MS, TRAPPED_SHARE, WIDTH_SQUARE,
};
use contact::uncertain::Uncertain;

/// Instance with its lead-in, and buffers for the gap of the last parameters tried.
pub(crate) struct LaggedModel<'a> {
    assumed: AssumedConstants,
    pub(crate) calibration: CalibrationErrors,
    pub(crate) carrier_rad_per_s: f64,
    pub(crate) interval_s: f64,
    pub(crate) z_p: Complex64,
    /// Time, with `lead` samples before the instance, s.
    pub(crate) time_s: &'a [f64],
    /// Amplitude, m.
    pub(crate) amplitude_m: &'a [f64],
    /// Normal force, N.
    pub(crate) normal_n: &'a [f64],
    pub(crate) lead: usize,
    /// Measured Z_m of the instance without the lead-in, N·s/m.
    pub(crate) z_m: &'a [Complex64],
    /// Laws that the model follows.
    pub(crate) laws: Laws,
    /// Plate's mode across its width; `None` if the wavelength is not known.
    pub(crate) mode_across: Option<ModeAcross>,
    /// Finger's part of Z_m at an earlier minimum, N·s/m; 0 until it is followed.
    pub(super) z_finger: Vec<Complex64>,
    pub(crate) loads: Loads,
    pub(crate) trend: Trend,
    /// Change of Z_m by the skin's inertia; zero until it is followed.
    pub(crate) transient: Transient,
    /// Time of the middle of the instance, s.
    pub(crate) middle_s: f64,
    /// Equilibrium of the gap, m.
    pub(super) equilibrium: Vec<f64>,
    /// Lagged gap, m.
    pub(crate) gap: Vec<f64>,
    pub(super) gap_slopes: GapSlopes,
    /// Derivatives at each sample of the instance that [`response_to_force`](Self::response_to_force) needs.
    pub(super) force_slopes: Vec<ForceSlopes>,
    pub(super) area_exponent: f64,
}

impl<'a> LaggedModel<'a> {
    /// Makes the model of an instance. The gap is integrated from `lead_in_s` before it; the area is S at `reference_n`.
    pub(crate) fn new(
        instance: &InstanceSeries<'a>,
        conditions: &FitConditions,
        lead_in_s: f64,
        reference_n: f64,
    ) -> Result<Self, FitError> {
        conditions.assumed.validated()?;
        conditions
            .mode_across
            .map_or(Ok(()), |mode| mode.validate())?;
        let (samples, lead) = instance.with_lead_in(lead_in_s)?;
        let zeros = || vec![0.0; samples.time_s.len()];
        Ok(Self {
            assumed: conditions.assumed,
            calibration: conditions.total_errors(),
            carrier_rad_per_s: conditions.carrier_rad_per_s()?,
            interval_s: instance.interval_s(),
            z_p: conditions.z_p_corrected_n_s_per_m,
            time_s: samples.time_s,
            amplitude_m: samples.amplitude_m,
            normal_n: samples.normal_n,
            lead,
            z_m: &samples.z_m_corrected_n_s_per_m[lead..],
            laws: Laws::Published,
            mode_across: conditions.mode_across,
            z_finger: vec![Complex64::ZERO; samples.time_s.len()],
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
    pub(crate) fn assumed_parameters(&self, sigma_t_m: f64, tau_s: f64) -> [f64; PARAMETERS] {
        let mut parameters = [0.0; PARAMETERS];
        parameters[LN_SIGMA_T] = sigma_t_m.ln();
        parameters[TAU_MS] = tau_s / MS;
        parameters[LN_AREA] = self.assumed.contact_area_m2.ln();
        parameters[LN_Q0] = self.assumed.q0_rad_per_m.ln();
        parameters[LN_LOSS_FACTOR] = self.assumed.loss_factor.ln();
        let width_m = Uncertain {
            value: CONTACT_WIDTH_M,
            std: 0.0,
        };
        parameters[WIDTH_SQUARE] = self
            .mode_across
            .map_or(0.0, |mode| mode.width_square(width_m).value);
        parameters
    }

    /// Returns the contact that the parameters describe.
    pub(crate) fn contact(&self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let skin = AssumedConstants {
            contact_area_m2: parameters[LN_AREA].exp(),
            q0_rad_per_m: parameters[LN_Q0].exp(),
            loss_factor: parameters[LN_LOSS_FACTOR].exp(),
            ..self.assumed
        };
        let contact = Contact::new(&skin, parameters[LN_SIGMA_T].exp()).ok()?;
        match self.laws {
            Laws::Published => Some(contact),
            Laws::InDoubt => {
                let [_, mean_square, ..] = ModeMoments::new(parameters[WIDTH_SQUARE])?.means;
                Some(contact.with_film(mean_square, parameters[TRAPPED_SHARE]))
            }
        }
    }

    /// Returns the contact at a sample.
    pub(crate) fn contact_at(&self, contact: &Contact, sample: usize) -> Contact {
        self.loads
            .contact(&self.trend.contact(contact, sample), sample)
    }
}
