//! Amplitude-modulation envelope, A(t) = A_mean · (1 + m · sin(2π f_m t + φ0)).

use crate::{
    phase_accumulator::{PhaseAccumulator, PhaseStep},
    sine_table::SineTable,
};

/// Amplitude of the carrier over time, volts peak across the actuators.
#[derive(Clone, Copy, Debug)]
pub struct AmplitudeEnvelope {
    mean_v: f64,
    depth_v: f64,
    phase: PhaseAccumulator,
    step: PhaseStep,
}

impl AmplitudeEnvelope {
    /// Creates an envelope of constant amplitude, V peak.
    #[must_use]
    pub fn constant(amplitude_v: f64, sample_rate_hz: u32) -> Self {
        Self {
            mean_v: amplitude_v,
            depth_v: 0.0,
            phase: PhaseAccumulator::default(),
            step: PhaseStep::new(0.0, sample_rate_hz),
        }
    }

    /// Creates an envelope with sinusoidal modulation of `modulation_index` (0 to 1) about `mean_v` (V peak), with phase
    /// `start_phase_rad` at the first frame.
    #[must_use]
    pub fn modulated(
        mean_v: f64,
        modulation_hz: f64,
        modulation_index: f64,
        start_phase_rad: f64,
        sample_rate_hz: u32,
    ) -> Self {
        Self {
            mean_v,
            depth_v: mean_v * modulation_index,
            phase: PhaseAccumulator::from_rad(start_phase_rad),
            step: PhaseStep::new(modulation_hz, sample_rate_hz),
        }
    }

    /// Returns whether the envelope has a modulation frequency, even at index 0.
    #[inline]
    #[must_use]
    pub fn is_modulated(&self) -> bool {
        !self.step.is_zero()
    }

    /// Returns this envelope with the modulation phase of `reference`.
    #[must_use]
    pub fn in_phase_with(self, reference: &Self) -> Self {
        Self {
            phase: reference.phase,
            ..self
        }
    }

    /// Returns the amplitude at this frame, V peak.
    #[inline]
    #[must_use]
    pub fn value_v(&self, table: &SineTable) -> f64 {
        self.mean_v + self.depth_v * table.sin(self.phase.turns())
    }

    /// Advances by one frame.
    #[inline]
    pub fn advance(&mut self) {
        self.phase.advance(self.step);
    }
}
