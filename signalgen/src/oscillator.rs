//! Carrier oscillator: a sine with a phase that is continuous through every change of frequency.

use crate::{
    phase_accumulator::{PhaseAccumulator, PhaseStep},
    sine_table::SineTable,
};

/// Sine oscillator on an exact phase, which is 0 (a rising zero) at frame 0.
#[derive(Clone, Debug)]
pub struct CarrierOscillator {
    sample_rate_hz: u32,
    frequency_hz: f64,
    phase: PhaseAccumulator,
    step: PhaseStep,
}

impl CarrierOscillator {
    /// Creates a carrier of `frequency_hz`, rounded to the nearest nanohertz.
    #[must_use]
    pub fn new(frequency_hz: f64, sample_rate_hz: u32) -> Self {
        Self {
            sample_rate_hz,
            frequency_hz,
            phase: PhaseAccumulator::default(),
            step: PhaseStep::new(frequency_hz, sample_rate_hz),
        }
    }

    /// Changes the frequency from the next frame on; the phase is continuous.
    pub fn set_frequency(&mut self, frequency_hz: f64) {
        self.frequency_hz = frequency_hz;
        self.step = PhaseStep::new(frequency_hz, self.sample_rate_hz);
    }

    /// Returns the present frequency, Hz.
    #[must_use]
    pub fn frequency_hz(&self) -> f64 {
        self.frequency_hz
    }

    /// Returns the phase of the next frame.
    #[must_use]
    pub fn phase(&self) -> PhaseAccumulator {
        self.phase
    }

    /// Returns the carrier at this frame, −1 to 1.
    #[inline]
    #[must_use]
    pub fn value(&self, table: &SineTable) -> f64 {
        table.sin(self.phase.turns())
    }

    /// Advances by one frame at the constant frequency.
    #[inline]
    pub fn advance(&mut self) {
        self.phase.advance(self.step);
    }

    /// Keeps the present frequency, which ends a glide.
    pub fn hold(&mut self) {
        self.set_frequency(self.frequency_hz);
    }

    /// Advances by one frame over which the frequency averages `mean_hz`.
    #[inline]
    pub fn glide(&mut self, mean_hz: f64) {
        self.frequency_hz = mean_hz;
        self.phase
            .advance_by_cycles(mean_hz / f64::from(self.sample_rate_hz));
    }
}
