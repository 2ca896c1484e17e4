//! Raised-cosine ramps, which keep the drive free of steps.

use std::f64::consts::FRAC_PI_2;

use crate::sine_table::SineTable;

const HALF_TURN: u64 = 1 << 63;

/// A weight that rises from 0 to 1 over a number of frames as (1 − cos πk/N)/2.
///
/// It changes by at most π/(2N) from one frame to the next; see [`Ramp::steepest_per_frame`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ramp {
    elapsed_frames: u32,
    frames: u32,
    turns_per_frame: u64,
}

impl Ramp {
    /// Creates a ramp at its beginning, at least one frame long.
    #[must_use]
    pub fn new(frames: u32) -> Self {
        let frames = frames.max(1);
        Self {
            elapsed_frames: 0,
            frames,
            turns_per_frame: HALF_TURN / u64::from(frames),
        }
    }

    /// Returns the weight at this frame; exactly 1 once the ramp is over.
    #[inline]
    #[must_use]
    pub fn weight(&self, table: &SineTable) -> f64 {
        if self.is_over() {
            1.0
        } else {
            0.5 - 0.5 * table.cos(u64::from(self.elapsed_frames) * self.turns_per_frame)
        }
    }

    /// Advances by one frame.
    #[inline]
    pub fn advance(&mut self) {
        self.elapsed_frames = (self.elapsed_frames + 1).min(self.frames);
    }

    /// Returns whether the weight has reached 1.
    #[inline]
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.elapsed_frames == self.frames
    }

    /// Returns an upper bound of the weight's change from one frame to the next.
    #[must_use]
    pub fn steepest_per_frame(frames: u32) -> f64 {
        FRAC_PI_2 / f64::from(frames.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_is_the_raised_cosine_and_keeps_its_bound() {
        let table = SineTable::new();
        for frames in [1_u32, 2, 3, 384, 9_600, 1_920_000] {
            let mut ramp = Ramp::new(frames);
            let mut last = 0.0;
            let bound = Ramp::steepest_per_frame(frames) + 1e-11;
            for k in 0..=frames {
                let weight = ramp.weight(&table);
                let expected =
                    0.5 - 0.5 * (std::f64::consts::PI * f64::from(k) / f64::from(frames)).cos();
                assert!((weight - expected).abs() < 1e-11, "{k} of {frames}");
                assert!((weight - last).abs() <= bound, "{k} of {frames}");
                last = weight;
                ramp.advance();
            }
            assert!(ramp.is_over());
            assert_eq!(ramp.weight(&table), 1.0);
        }
    }
}
