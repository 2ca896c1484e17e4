//! Detection of constant inputs: muted, disconnected from the converter, or with a stopped converter.

/// Time after which a constant reading means a stuck input, s: noise of a working converter changes some bit sooner.
const STUCK_S: f64 = 0.03;

/// Detects stuck inputs.
#[derive(Debug)]
pub(super) struct StuckWatch {
    longest: u32,
    /// Newest value of each input, and number of samples for which it has not changed.
    inputs: Vec<(f32, u32)>,
}

impl StuckWatch {
    pub(super) fn new(inputs: usize, rate_hz: f64) -> Self {
        Self {
            longest: (STUCK_S * rate_hz) as u32,
            inputs: vec![(f32::NAN, 0); inputs],
        }
    }

    /// Processes interleaved frames.
    pub(super) fn take(&mut self, frames: &[f32]) {
        for frame in frames.chunks_exact(self.inputs.len()) {
            for ((value, repeats), &now) in self.inputs.iter_mut().zip(frame) {
                *repeats = if now == *value {
                    repeats.saturating_add(1)
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
            .any(|&(_, repeats)| repeats >= self.longest)
    }
}
