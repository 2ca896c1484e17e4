//! Time series of a recording: nearly all the memory that its analysis takes. Results need none of them once the findings have their
//! summaries; tables of samples and figures read those of one recording at a time from a [`SeriesSource`](crate::SeriesSource).

use contact::FittedFinger;
use estimation::EstimatedSeries;
use serde::{Deserialize, Serialize};

use crate::exploration_series::ExplorationSeries;
use crate::instance::PreparedInstance;
use crate::method::Method;
use contact::skin_motion::SkinMotion;

/// Time series of a recording.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct RecordingSeries {
    /// Series of [`explorations`](crate::findings::RecordingFindings::explorations), in their order.
    pub explorations: Vec<ExplorationSeries>,
    /// Series of [`instances`](crate::findings::RecordingFindings::instances), in their order.
    pub instances: Vec<SampledInstance>,
}

impl RecordingSeries {
    /// Returns the memory that the series take, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let explorations = self.explorations.iter();
        let frames: usize = explorations.map(|series| series.time_s.len()).sum();
        let instances = self.instances.iter();
        let samples: usize = instances
            .map(|instance| instance.samples.time_s().len())
            .sum();
        frames * EXPLORATION_BYTES + samples * INSTANCE_BYTES
    }
}

/// Memory of a sample of an exploration: eleven numbers, two impedances, the validity.
const EXPLORATION_BYTES: usize = 11 * 8 + 2 * 16 + 1;
/// Memory of a sample of an instance: eleven measured numbers, half as many again for the lead-in, and eighteen numbers by each method.
const INSTANCE_BYTES: usize = 11 * 8 * 3 / 2 + 3 * 18 * 8;

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
