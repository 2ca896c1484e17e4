//! Derivatives of the lagged gap by the parameters.

use contact::first_order_lag::GrowingLag;
use contact::parameters::{
    AREA_EXPONENT, CYCLE_AVERAGE, FILM_MEAN_MS, FILM_MOBILITY, IM_Z_T, LAG_EXPONENT, LN_AREA,
    LN_FORCE, LN_Q0, LN_RATIO, LN_SIGMA_T, RE_Z_T, RELATIVE_SHARE, TAU_MS, WIDTH_SQUARE,
};

use super::laws::Laws;

/// Parameters that the lagged gap depends on, those of its equilibrium first, of which those of the laws in doubt come last.
pub(crate) const GAP_PARAMETERS: [usize; 15] = [
    LN_SIGMA_T,
    LN_AREA,
    LN_Q0,
    AREA_EXPONENT,
    FILM_MEAN_MS,
    LN_RATIO,
    FILM_MOBILITY,
    WIDTH_SQUARE,
    RELATIVE_SHARE,
    CYCLE_AVERAGE,
    RE_Z_T,
    IM_Z_T,
    TAU_MS,
    LAG_EXPONENT,
    LN_FORCE,
];
/// Number of parameters that the equilibrium depends on.
const EQUILIBRIUM_COUNT: usize = 12;
/// Number of those that it depends on with the laws as published.
const PUBLISHED_COUNT: usize = 7;
/// Index of ln S in [`GAP_PARAMETERS`].
const AREA: usize = 1;

/// Derivatives of the lagged gap by the parameters, m.
pub(super) struct GapSlopes {
    pub(super) equilibrium: [Vec<f64>; EQUILIBRIUM_COUNT],
    /// Slopes of the lagged gap, except by the force: a larger force is equivalent to a smaller area.
    gap: [Vec<f64>; GAP_PARAMETERS.len() - 1],
    /// Lag last applied to the gap.
    pub(super) lag: GrowingLag,
    /// Number of parameters of the equilibrium with slopes; the slopes by the others are 0.
    pub(super) equilibrium_count: usize,
}

impl GapSlopes {
    pub(super) fn new(samples: usize) -> Self {
        Self {
            equilibrium: std::array::from_fn(|_| vec![0.0; samples]),
            gap: std::array::from_fn(|_| vec![0.0; samples]),
            lag: GrowingLag::new(samples),
            equilibrium_count: PUBLISHED_COUNT,
        }
    }

    /// Changes the parameters that have slopes.
    pub(super) fn set_laws(&mut self, laws: Laws) {
        self.equilibrium_count = match laws {
            Laws::Published => PUBLISHED_COUNT,
            Laws::InDoubt => EQUILIBRIUM_COUNT,
        };
        for slopes in &mut self.gap[PUBLISHED_COUNT..EQUILIBRIUM_COUNT] {
            slopes.fill(0.0);
        }
    }

    /// Computes the slopes of the gap that lags behind its equilibrium.
    pub(super) fn follow(&mut self, equilibrium: &[f64], gap: &[f64], intervals_per_ms: f64) {
        self.lag.differentiate(equilibrium, gap);
        let (equilibrium_slopes, lag_slopes) = self.gap.split_at_mut(EQUILIBRIUM_COUNT);
        let equilibrium = self.equilibrium[..self.equilibrium_count].iter();
        for (equilibrium_slope, gap_slope) in equilibrium.zip(equilibrium_slopes) {
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

    /// Returns the derivatives of the gap at a sample by the parameters in [`GAP_PARAMETERS`], m.
    pub(super) fn slopes_m(&self, sample: usize) -> [f64; GAP_PARAMETERS.len()] {
        std::array::from_fn(|index| {
            self.gap
                .get(index)
                .map_or(-self.gap[AREA][sample], |slopes| slopes[sample])
        })
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
        impulse[sample] = factor * self.equilibrium[AREA][sample];
        self.lag.slope_by_input(impulse, gap);
        impulse[sample] = 0.0;
    }
}
