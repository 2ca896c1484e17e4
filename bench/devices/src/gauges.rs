//! Latest values of the devices, for screens.

use tasks::Slot;

use crate::force::LineFaults;

/// What the field's sources have suffered, for the screen.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FieldHealth {
    /// Of the force sensor's line.
    pub force: LineFaults,
    /// Force samples so far.
    pub force_samples: u64,
    /// Drift of the host's clock against the sensor's, ppm.
    pub drift_ppm: Option<f64>,
    /// Encoder readings that had missed a state.
    pub encoder_skipped: u64,
}

/// Gauges that the devices' tasks publish.
#[derive(Debug, Default)]
pub struct Gauges {
    /// Fill of the audio ring, 0 to 1.
    pub ring_fill: Slot<f64>,
    /// Faults and rates of the slow inputs.
    pub field: Slot<FieldHealth>,
}
