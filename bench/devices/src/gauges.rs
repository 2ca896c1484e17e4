//! Latest values of the devices, as screens show them.

use std::sync::Arc;

use safety::LineLevels;
use sources::LineFaults;
use tasks::Slot;

use crate::stream_threads::StreamThreads;

/// Faults and rates of the slow inputs, as screens show them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FieldHealth {
    /// Faults of the force sensor's line.
    pub force: LineFaults,
    /// Number of force samples so far.
    pub force_samples: u64,
    /// Drift of the host's clock against the sensor's, ppm; `None` until it is known.
    pub drift_ppm: Option<f64>,
    /// Number of encoder readings that had missed a state.
    pub encoder_skipped: u64,
    /// Whether the participant's button is pressed; `None` where none is wired.
    pub button_pressed: Option<bool>,
    /// Number of presses of the button so far.
    pub button_presses: u64,
    /// Time of the last press, ns.
    pub button_press_ns: Option<u64>,
}

/// Latest values that the devices' tasks publish.
#[derive(Debug, Default)]
pub struct Gauges {
    /// Fill of the audio ring, 0 to 1.
    pub ring_fill: Slot<f64>,
    /// Greatest fill of the audio ring so far, 0 to 1.
    pub fullest_ring: Slot<f64>,
    /// Faults and rates of the slow inputs.
    pub field: Slot<FieldHealth>,
    /// How the safety watch's lines are.
    pub lines: Arc<Slot<LineLevels>>,
    /// Scheduling of the sound card's callbacks.
    pub stream_threads: StreamThreads,
}
