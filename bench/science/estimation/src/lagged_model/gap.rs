//! Gap that lags behind its equilibrium, and its derivatives.

use contact::first_order_lag::GrowthLaw;
use contact::parameters::{
    AREA_EXPONENT, CYCLE_AVERAGE, FILM_MEAN_MS, FILM_MOBILITY, IM_Z_T, LAG_EXPONENT, LN_FORCE,
    LN_RATIO, MS, PARAMETERS, RE_Z_T, RELATIVE_SHARE, TAU_MS, WIDTH_SQUARE,
};
use contact::{Contact, equilibrium_gaps};

use num_complex::Complex64;

use super::gap_slopes::GAP_PARAMETERS;
use super::law_choice::Laws;
use super::model::LaggedModel;
use crate::loads::{DoubtfulLoadLaw, LoadLaw};
use contact::mode_moments::ModeMoments;

/// Gap at which τ has its parameter value if it grows with the gap, m.
const LAG_REFERENCE_GAP_M: f64 = 10e-6;

impl LaggedModel<'_> {
    /// Computes the gap and its slopes; `None` where the model allows no such contact.
    pub(crate) fn follow(&mut self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let contact = self.follow_gap(parameters)?;
        let (loads, trend) = (&self.loads, &self.trend);
        let force_factor = parameters[LN_FORCE].exp();
        let slopes = &mut self.gap_slopes;
        for (sample, (&gap, &normal_n)) in self.equilibrium.iter().zip(self.normal_n).enumerate() {
            let equilibrium_slopes = loads
                .contact(&trend.contact(&contact, sample), sample)
                .equilibrium_gap_slopes_m(gap, force_factor * normal_n);
            slopes.set_equilibrium(sample, &equilibrium_slopes, &loads.slopes[sample]);
        }
        // For p = 0 the lag is linear in its input, and ∂x/∂θ is the lag of ∂x_eq/∂θ; for p ≠ 0 it also carries ∂τ/∂x ∂x/∂θ
        // (`GrowingLag`).
        slopes.follow(&self.equilibrium, &self.gap, MS / self.interval_s);
        Some(contact)
    }

    /// Computes the gap without slopes.
    pub(crate) fn follow_gap(&mut self, parameters: &[f64; PARAMETERS]) -> Option<Contact> {
        let contact = self.contact(parameters)?;
        self.loads.follow(&LoadLaw {
            area_exponent: parameters[AREA_EXPONENT],
            ln_ratio: parameters[LN_RATIO],
            film_mobility: parameters[FILM_MOBILITY],
            film_mean_intervals: parameters[FILM_MEAN_MS] * MS / self.interval_s,
            intervals_per_ms: MS / self.interval_s,
        })?;
        if self.laws == Laws::InDoubt {
            let moments = ModeMoments::new(parameters[WIDTH_SQUARE])?;
            self.loads.follow_doubtful(&DoubtfulLoadLaw {
                relative_share: parameters[RELATIVE_SHARE],
                cycle_average: parameters[CYCLE_AVERAGE],
                z_t: Complex64::new(parameters[RE_Z_T], parameters[IM_Z_T]),
                sigma_t_m: contact.sigma_t_m(),
                mean_square: (moments.means[1], moments.slopes[1]),
                trend: &self.trend,
                z_finger: &self.z_finger,
            });
        }
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

    /// Returns the derivatives of the gap at a sample by the parameters in [`GAP_PARAMETERS`], m.
    pub(crate) fn gap_slopes_m(&self, sample: usize) -> [f64; GAP_PARAMETERS.len()] {
        self.gap_slopes.slopes_m(sample)
    }

    /// Returns the logarithm of the ratio of the instance's mean gap to the gap at which τ has its parameter value.
    pub(crate) fn ln_mean_gap(&self) -> f64 {
        let instance_gap = &self.gap[self.lead..];
        (instance_gap.iter().sum::<f64>() / instance_gap.len() as f64 / LAG_REFERENCE_GAP_M).ln()
    }
}
