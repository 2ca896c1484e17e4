//! Time series of a recording: nearly all the memory that its analysis takes. Results need none of them once the findings have their
//! summaries; tables of samples and figures read those of one recording at a time from a [`SeriesSource`](crate::SeriesSource).

use contact::FittedFinger;
use estimation::EstimatedSeries;
use serde::{Deserialize, Serialize};

use crate::exploration_series::ExplorationSeries;
use crate::instance::PreparedInstance;
use crate::method::Method;
use crate::motion::SkinMotion;

/// Time series of a recording.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct RecordingSeries {
    /// Series of [`explorations`](crate::findings::RecordingFindings::explorations), in their order.
    pub explorations: Vec<ExplorationSeries>,
    /// Series of [`instances`](crate::findings::RecordingFindings::instances), in their order.
    pub instances: Vec<SampledInstance>,
}

/// Samples of an instance, measured and estimated.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SampledInstance {
    /// Measured samples, as used by the fits.
    pub samples: PreparedInstance,
    /// Finger estimated by `dynamic`, for samples beyond the instance.
    pub finger: FittedFinger,
    /// Estimates by the published method.
    pub paper: EstimateSeries,
    /// Estimates by the dynamic method.
    pub dynamic: EstimateSeries,
    /// Estimates by the fit of the whole trial; `None` if that fit cannot be used.
    pub trial: Option<EstimateSeries>,
}

impl SampledInstance {
    /// Returns the estimates by a method; `None` without a fit by it.
    #[must_use]
    pub fn estimate(&self, method: Method) -> Option<&EstimateSeries> {
        match method {
            Method::Paper => Some(&self.paper),
            Method::Dynamic => Some(&self.dynamic),
            Method::Trial => self.trial.as_ref(),
        }
    }
}

/// Estimates of an instance by one method, sample by sample.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EstimateSeries {
    /// Stiffness, gap and friction.
    pub contact: EstimatedSeries,
    /// Forces on the skin and its motion.
    pub motion: SkinMotion,
    /// Mean force of the squeeze film (Huloux 2021, Eq. 14) at the estimated gap, N.
    pub film_force_n: Vec<f64>,
}
