//! The amplitude-modulation envelope, A(t) = A_mean · (1 + m · sin(2π f_m t + φ0)).

use crate::phase::{Phase, PhaseStep, SineTable};

/// Amplitude of the carrier over time, volts peak across the actuators.
#[derive(Clone, Copy, Debug)]
pub struct Envelope {
    mean_v: f64,
    depth_v: f64,
    phase: Phase,
    step: PhaseStep,
}

impl Envelope {
    /// Constant amplitude.
    #[must_use]
    pub fn constant(amplitude_v: f64, sample_rate_hz: u32) -> Self {
        Self {
            mean_v: amplitude_v,
            depth_v: 0.0,
            phase: Phase::default(),
            step: PhaseStep::new(0.0, sample_rate_hz),
        }
    }

    /// Sinusoidal modulation of `modulation_index` (0 to 1) about `mean_v`, the phase of the first
    /// frame being `start_phase_rad`.
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
            phase: Phase::from_rad(start_phase_rad),
            step: PhaseStep::new(modulation_hz, sample_rate_hz),
        }
    }

    /// Whether it has a modulation, be its index 0.
    #[must_use]
    pub fn is_modulated(&self) -> bool {
        !self.step.is_zero()
    }

    /// The same envelope with the modulation phase of `other`.
    #[must_use]
    pub fn in_phase_with(self, other: &Self) -> Self {
        Self {
            phase: other.phase,
            ..self
        }
    }

    /// Amplitude at this frame, V peak.
    #[inline]
    #[must_use]
    pub fn value_v(&self, table: &SineTable) -> f64 {
        self.mean_v + self.depth_v * table.sin(self.phase.turns())
    }

    /// Goes on by one frame.
    #[inline]
    pub fn advance(&mut self) {
        self.phase.advance(self.step);
    }
}
