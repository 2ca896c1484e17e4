//! Inputs that do not change at all: muted, disconnected from their converter, or the converter itself has stopped.

/// Time for which a converter's noise cannot leave every bit of a gauge as it is, s.
const STUCK_S: f64 = 0.03;

/// Tells inputs that are stuck.
#[derive(Debug)]
pub(super) struct StuckWatch {
    longest: u32,
    /// Newest value of each input, and for how many samples it has stood.
    inputs: Vec<(f32, u32)>,
}

impl StuckWatch {
    pub(super) fn new(inputs: usize, rate_hz: f64) -> Self {
        Self {
            longest: (STUCK_S * rate_hz) as u32,
            inputs: vec![(f32::NAN, 0); inputs],
        }
    }

    /// Takes interleaved frames.
    pub(super) fn take(&mut self, frames: &[f32]) {
        for frame in frames.chunks_exact(self.inputs.len()) {
            for ((value, stands), &now) in self.inputs.iter_mut().zip(frame) {
                *stands = if now == *value {
                    stands.saturating_add(1)
                } else {
                    0
                };
                *value = now;
            }
        }
    }

    /// Returns whether any input is stuck.
    pub(super) fn is_stuck(&self) -> bool {
        self.inputs
            .iter()
            .any(|&(_, stands)| stands >= self.longest)
    }
}
