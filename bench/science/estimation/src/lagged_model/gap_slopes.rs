//! Derivatives of the lagged gap by the parameters.

use contact::first_order_lag::GrowingLag;
use contact::parameters::{
    AREA_EXPONENT, CYCLE_AVERAGE, ContactSlopes, FILM_MEAN_MS, FILM_MOBILITY, IM_Z_T, LAG_EXPONENT,
    LN_AREA, LN_FORCE, LN_Q0, LN_RATIO, LN_SIGMA_T, LoadSlopes, RE_Z_T, RELATIVE_SHARE, TAU_MS,
    WIDTH_SQUARE,
};

use super::law_choice::Laws;

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
/// Number of parameters that the equilibrium depends on with the laws as published.
const PUBLISHED_COUNT: usize = 7;
/// Number of those that it depends on with the laws in doubt alone.
const DOUBTFUL_COUNT: usize = 5;
/// Index of ln S in [`GAP_PARAMETERS`].
const AREA: usize = 1;

/// Derivatives of the lagged gap by the parameters, m.
pub(super) struct GapSlopes {
    published: LaggedSlopes<PUBLISHED_COUNT>,
    doubtful: LaggedSlopes<DOUBTFUL_COUNT>,
    by_tau_ms: Vec<f64>,
    by_lag_exponent: Vec<f64>,
    /// Lag last applied to the gap.
    pub(super) lag: GrowingLag,
    /// Laws in force; with the published ones the slopes by the others are 0.
    laws: Laws,
}

/// Derivatives of equilibrium and lagged gap by some parameters at each sample, m.
struct LaggedSlopes<const N: usize> {
    equilibrium: Vec<[f64; N]>,
    gap: Vec<[f64; N]>,
}

impl<const N: usize> LaggedSlopes<N> {
    fn new(samples: usize) -> Self {
        Self {
            equilibrium: vec![[0.0; N]; samples],
            gap: vec![[0.0; N]; samples],
        }
    }
}

impl GapSlopes {
    pub(super) fn new(samples: usize) -> Self {
        Self {
            published: LaggedSlopes::new(samples),
            doubtful: LaggedSlopes::new(samples),
            by_tau_ms: vec![0.0; samples],
            by_lag_exponent: vec![0.0; samples],
            lag: GrowingLag::new(samples),
            laws: Laws::Published,
        }
    }

    /// Changes the parameters that have slopes.
    pub(super) fn set_laws(&mut self, laws: Laws) {
        self.laws = laws;
        self.doubtful.gap.fill([0.0; DOUBTFUL_COUNT]);
    }

    /// Takes the slopes of the equilibrium at a sample.
    pub(super) fn set_equilibrium(
        &mut self,
        sample: usize,
        slopes: &ContactSlopes,
        load: &LoadSlopes,
    ) {
        let by_parameter = |index: usize| slopes.by_parameter(GAP_PARAMETERS[index], load);
        self.published.equilibrium[sample] = std::array::from_fn(by_parameter);
        if self.laws == Laws::InDoubt {
            self.doubtful.equilibrium[sample] =
                std::array::from_fn(|index| by_parameter(PUBLISHED_COUNT + index));
        }
    }

    /// Computes the slopes of the gap that lags behind its equilibrium.
    pub(super) fn follow(&mut self, equilibrium: &[f64], gap: &[f64], intervals_per_ms: f64) {
        self.lag.differentiate(equilibrium, gap);
        let published = &mut self.published;
        self.lag
            .slopes_by_input(&published.equilibrium, &mut published.gap);
        if self.laws == Laws::InDoubt {
            let doubtful = &mut self.doubtful;
            self.lag
                .slopes_by_input(&doubtful.equilibrium, &mut doubtful.gap);
        }
        self.lag.slope_by_tau(&mut self.by_tau_ms);
        self.by_tau_ms
            .iter_mut()
            .for_each(|slope| *slope *= intervals_per_ms);
        self.lag.slope_by_exponent(&mut self.by_lag_exponent);
    }

    /// Returns the derivatives of the gap at a sample by the parameters in [`GAP_PARAMETERS`], m.
    pub(super) fn slopes_m(&self, sample: usize) -> [f64; GAP_PARAMETERS.len()] {
        let published = &self.published.gap[sample];
        let mut slopes = [0.0; GAP_PARAMETERS.len()];
        let (by_equilibrium, by_lag) = slopes.split_at_mut(PUBLISHED_COUNT + DOUBTFUL_COUNT);
        by_equilibrium[..PUBLISHED_COUNT].copy_from_slice(published);
        by_equilibrium[PUBLISHED_COUNT..].copy_from_slice(&self.doubtful.gap[sample]);
        // A larger force is equivalent to a smaller area.
        let by_force = -published[AREA];
        by_lag.copy_from_slice(&[
            self.by_tau_ms[sample],
            self.by_lag_exponent[sample],
            by_force,
        ]);
        slopes
    }

    /// Writes the response of the lagged gap at all samples to the logarithm of the contact area at one of them, times `factor`,
    /// after [`follow`](Self::follow). `impulse` is a buffer of zeros.
    pub(super) fn respond_to_area(
        &self,
        sample: usize,
        factor: f64,
        impulse: &mut [[f64; 1]],
        gap: &mut [[f64; 1]],
    ) {
        impulse[sample] = [factor * self.published.equilibrium[sample][AREA]];
        self.lag.slopes_by_input(impulse, gap);
        impulse[sample] = [0.0];
    }
}
