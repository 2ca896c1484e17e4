//! Gap that lags behind its equilibrium, and its derivatives.

use crate::first_order_lag::{GrowingLag, GrowthLaw};
use contact::parameters::{
    AREA_EXPONENT, FILM_MEAN_MS, FILM_MOBILITY, LAG_EXPONENT, LN_AREA, LN_FORCE, LN_Q0, LN_RATIO,
    LN_SIGMA_T, MS, PARAMETERS, TAU_MS,
};
use contact::{Contact, equilibrium_gaps};

use super::LaggedModel;
use crate::loads::LoadLaw;

/// Gap at which τ has its parameter value if it grows with the gap, m.
const LAG_REFERENCE_GAP_M: f64 = 10e-6;

/// Parameters that the lagged gap depends on, those of its equilibrium first.
pub(crate) const GAP_PARAMETERS: [usize; 10] = [
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
pub(super) struct GapSlopes {
    equilibrium: [Vec<f64>; EQUILIBRIUM_COUNT],
    /// Slopes of the lagged gap, except by the force: a larger force is equivalent to a smaller area.
    gap: [Vec<f64>; GAP_PARAMETERS.len() - 1],
    /// Lag last applied to the gap.
    lag: GrowingLag,
}

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
            for (slope, parameter) in slopes.equilibrium.iter_mut().zip(GAP_PARAMETERS) {
                slope[sample] = equilibrium_slopes.by_parameter(parameter, &loads.slopes[sample]);
            }
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
        let gap_slopes = &self.gap_slopes.gap;
        std::array::from_fn(|index| {
            gap_slopes
                .get(index)
                .map_or(-gap_slopes[AREA][sample], |slopes| slopes[sample])
        })
    }

    /// Returns the logarithm of the ratio of the instance's mean gap to the gap at which τ has its parameter value.
    pub(crate) fn ln_mean_gap(&self) -> f64 {
        let instance_gap = &self.gap[self.lead..];
        (instance_gap.iter().sum::<f64>() / instance_gap.len() as f64 / LAG_REFERENCE_GAP_M).ln()
    }

    /// Writes the response of the lagged gap at all samples to the logarithm of the contact area at one of them, times `factor`,
    /// after [`follow`](Self::follow). `impulse` is a buffer of zeros.
    pub(super) fn respond_to_area(
        &self,
        sample: usize,
        factor: f64,
        impulse: &mut [f64],
        gap: &mut [f64],
    ) {
        impulse[sample] = factor * self.gap_slopes.equilibrium[AREA][sample];
        self.gap_slopes.lag.slope_by_input(impulse, gap);
        impulse[sample] = 0.0;
    }
}

impl GapSlopes {
    pub(super) fn new(samples: usize) -> Self {
        Self {
            equilibrium: std::array::from_fn(|_| vec![0.0; samples]),
            gap: std::array::from_fn(|_| vec![0.0; samples]),
            lag: GrowingLag::new(samples),
        }
    }

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
