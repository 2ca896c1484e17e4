//! Latest values of the devices, as screens show them.

use std::sync::Arc;

use impedance::clock_alignment::{ClockState, TOLERANCE};
use safety::{LineLevels, Losses};
use sources::{LineFaults, clock_cause};
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
    /// Rate of the force sensor's clock over the host's if it surely differs by more than the alignment can follow.
    pub force_pace: Option<f64>,
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

/// Excess rates of the sensors' clocks over the sound card's, ppm; `None` where unknown, or where a sensor has no clock of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SensorClocks {
    /// Force sensor.
    pub force_ppm: Option<f64>,
    /// Encoder.
    pub position_ppm: Option<f64>,
}

/// Rate beyond which a clock is worth a word, ppm: a crystal is within 100 ppm.
const NOTABLE_PPM: f64 = 500.0;

/// Clock of a sensor that differs from the sound card's by more than a crystal's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotableClock {
    /// Name of the sensor.
    pub sensor: &'static str,
    /// Excess rate over the sound card's clock, ppm.
    pub fast_ppm: f64,
}

impl SensorClocks {
    /// Returns the clocks that differ from the card's by more than a crystal's.
    pub fn notable(&self) -> impl Iterator<Item = NotableClock> {
        let clocks = [
            ("force sensor", self.force_ppm),
            ("encoder", self.position_ppm),
        ];
        let known = clocks.into_iter().filter_map(|(sensor, ppm)| {
            Some(NotableClock {
                sensor,
                fast_ppm: ppm?,
            })
        });
        known.filter(|clock| clock.fast_ppm.abs() > NOTABLE_PPM)
    }
}

impl NotableClock {
    /// Returns whether the clock is beyond the tolerance, so that its readings get wrong times.
    #[must_use]
    pub fn is_beyond(&self) -> bool {
        self.fast_ppm.abs() > 1e6 * TOLERANCE
    }

    /// Returns the difference in words, with its cause.
    #[must_use]
    pub fn in_words(&self) -> String {
        let way = if self.fast_ppm < 0.0 { "slow" } else { "fast" };
        let ppm = self.fast_ppm.abs();
        if !self.is_beyond() {
            return format!(
                "its clock runs {ppm:.0} ppm {way}, as a ceramic resonator's; it is followed"
            );
        }
        let cause = clock_cause(1.0 + 1e-6 * self.fast_ppm);
        let cause = cause.unwrap_or("give it a crystal, or correct the time that it sends");
        format!("its clock runs {:.2} % {way}: {cause}", 1e-4 * ppm)
    }
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
    /// Lost devices.
    pub losses: Arc<Losses>,
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

    /// Returns the clocks of the sensors relative to the sound card's.
    #[must_use]
    pub fn sensor_clocks(&self) -> SensorClocks {
        let card = self.card_clock.get().unwrap_or_default();
        let field = self.field.get().unwrap_or_default();
        let fast_ppm = |clock: Option<ClockState>| clock?.fast_ppm_against(&card);
        let pace_ppm = field.force_pace.map(|pace| 1e6 * (pace - 1.0));
        SensorClocks {
            force_ppm: pace_ppm.or(fast_ppm(field.force_clock)),
            position_ppm: fast_ppm(field.position_clock),
        }
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
