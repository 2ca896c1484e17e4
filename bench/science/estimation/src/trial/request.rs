//! Instances and options that a trial's fit takes.

use super::prior::TrialPriors;
use crate::series::InstanceSeries;

/// Options of a trial's fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialOptions {
    /// Time before each instance from which its gap is integrated, s. Default 20 ms, some ten τ.
    pub lead_in_s: f64,
    /// Priors of the parameters.
    pub priors: TrialPriors,
}

impl Default for TrialOptions {
    fn default() -> Self {
        Self {
            lead_in_s: 0.02,
            priors: TrialPriors::default(),
        }
    }
}

/// An instance and its position on the plate.
#[derive(Debug, Clone, Copy)]
pub struct PlacedInstance<'a> {
    /// The instance.
    pub series: InstanceSeries<'a>,
    /// Position of its middle along the plate, from the plate's centre, m.
    pub off_centre_m: f64,
}
