//! Latest values of the devices, as screens show them.

use std::sync::Arc;

use impedance::clock_alignment::ClockState;
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
    /// Number of force samples a second that the sensor says it sends.
    pub force_stated_hz: Option<f64>,
    /// State of the force sensor's clock; `None` if it is on the sound card's clock.
    pub force_clock: Option<ClockState>,
    /// State of the encoder's clock; `None` if it has no separate clock.
    pub position_clock: Option<ClockState>,
    /// Number of encoder readings that missed a state.
    pub encoder_skipped: u64,
    /// Whether the participant's button is pressed; `None` if it is not wired.
    pub button_pressed: Option<bool>,
    /// Number of presses of the button so far.
    pub button_presses: u64,
    /// Time of the last press, ns.
    pub button_press_ns: Option<u64>,
}

/// Latest values that the devices' tasks publish.
#[derive(Debug, Default)]
pub struct DeviceReadings {
    /// Fill of the audio ring, 0 to 1.
    pub ring_fill: Slot<f64>,
    /// Greatest fill of the audio ring so far, 0 to 1.
    pub fullest_ring: Slot<f64>,
    /// Faults and rates of the slow inputs.
    pub field: Slot<FieldHealth>,
    /// Levels of the safety watch's lines.
    pub lines: Arc<Slot<LineLevels>>,
    /// State of the sound card's clock.
    pub card_clock: Slot<ClockState>,
    /// Scheduling of the sound card's callbacks.
    pub stream_threads: StreamThreads,
}

impl DeviceReadings {
    /// Returns the relative excess of the force sensor's clock rate over the sound card's, ppm; `None` until it is
    /// known.
    #[must_use]
    pub fn force_clock_ppm(&self) -> Option<f64> {
        let card = self.card_clock.get()?;
        self.field.get()?.force_clock?.fast_ppm_against(&card)
    }

    /// Returns the residual of the force sensor's arrivals against its clock, s; `None` until it is known.
    #[must_use]
    pub fn force_residual_s(&self) -> Option<f64> {
        self.field.get()?.force_clock?.residual_s
    }

    /// Returns whether a sensor's readings may be placed wrongly.
    #[must_use]
    pub fn clock_off(&self) -> bool {
        let card = self.card_clock.get().unwrap_or_default();
        let field = self.field.get().unwrap_or_default();
        let is_off = |clock: ClockState| clock.misplaces() || clock.excess_ppm(&card).is_some();
        let sensors = [field.force_clock, field.position_clock];
        card.misplaces() || sensors.into_iter().flatten().any(is_off)
    }
}
