//! Streams of a trial, as a bench records them.

use super::plan::TrialPlan;
use super::stated::StatedConstants;
use crate::plant::SensorSample;
use crate::run_truth::{TruthConstants, TruthSample};

/// Readings of a sensor at their own times, s of the converter's clock.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensorReadings {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Values.
    pub values: Vec<f64>,
}

impl SensorReadings {
    pub(super) fn push(&mut self, time_s: f64, value: f64) {
        self.time_s.push(time_s);
        self.values.push(value);
    }
}

/// A stroke of the finger after the slider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Start of the slider, s.
    pub start_s: f64,
    /// End of the slider, s.
    pub end_s: f64,
    /// Whether the slider moved towards increasing position.
    pub rightwards: bool,
}

/// A finished trial. Times are seconds from the first sample, by the converter's clock.
#[derive(Debug, Clone)]
pub struct TrialRecording {
    /// Plan of the trial.
    pub plan: TrialPlan,
    /// Carrier of the drive, Hz.
    pub carrier_hz: f64,
    /// Read-back of the drive, sample values.
    pub drive: Vec<f32>,
    /// Pickup, sample values.
    pub pickup: Vec<f32>,
    /// Normal force by the sensor with its calibration, N.
    pub normal_n: SensorReadings,
    /// Lateral force by the sensor with its calibration, N, positive towards increasing position.
    pub lateral_n: SensorReadings,
    /// Position of the finger by the encoder, m.
    pub position: SensorReadings,
    /// Stretches without a finger on the plate, s.
    pub unloaded_s: Vec<(f64, f64)>,
    /// Strokes of the finger.
    pub strokes: Vec<Stroke>,
    /// Truth, a sample per millisecond.
    pub truth: Vec<TruthSample>,
    /// True constants.
    pub constants: TruthConstants,
    /// Constants that the bench states.
    pub stated: StatedConstants,
}

impl TrialRecording {
    pub(super) fn new(
        plan: &TrialPlan,
        constants: TruthConstants,
        stated: StatedConstants,
    ) -> Self {
        let frames = (plan.expected_s() * f64::from(plan.rate_hz)) as usize;
        Self {
            carrier_hz: plan.carrier_hz.unwrap_or(stated.resonance_hz),
            plan: plan.clone(),
            drive: Vec::with_capacity(frames),
            pickup: Vec::with_capacity(frames),
            normal_n: SensorReadings::default(),
            lateral_n: SensorReadings::default(),
            position: SensorReadings::default(),
            unloaded_s: Vec::new(),
            strokes: Vec::new(),
            truth: Vec::new(),
            constants,
            stated,
        }
    }

    pub(super) fn read_forces(&mut self, samples: &[SensorSample]) {
        let clock = self.constants.frames_per_s / f64::from(self.plan.rate_hz);
        for sample in samples {
            let time_s = sample.time_s * clock;
            let [normal_n, lateral_n] = self.stated.forces_n([sample.normal_n, sample.lateral_n]);
            self.normal_n.push(time_s, normal_n);
            self.lateral_n.push(time_s, lateral_n);
        }
    }

    /// Returns the time of a truth sample, s from the first sample by the converter's clock.
    #[must_use]
    pub fn clock_s(&self, truth: &TruthSample) -> f64 {
        truth.frame as f64 / f64::from(self.plan.rate_hz)
    }
}
