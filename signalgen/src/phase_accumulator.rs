//! Exact phase: a 64-bit accumulator that neither drifts nor rounds.

use std::f64::consts::TAU;

/// Frequency steps per hertz: frequencies are whole numbers of nanohertz.
const STEPS_PER_HZ: f64 = 1e9;
const STEPS_PER_HZ_EXACT: u64 = 1_000_000_000;
/// One turn of the accumulator, 2⁶⁴.
pub(crate) const TURN: f64 = 18_446_744_073_709_551_616.0;

/// Phase as a fraction of a turn in units of 2⁻⁶⁴, with the exact remainder below that.
///
/// The remainder counts in units of 2⁻⁶⁴ / (rate · 10⁹), so that any number of advances by any [`PhaseStep`] of the same rate
/// has no rounding error.
///
/// ```
/// use signalgen::{PhaseAccumulator, PhaseStep};
///
/// // 6.1 Hz at 192 kHz returns to phase 0 after ten seconds: 61 turns in 1 920 000 frames.
/// let step = PhaseStep::new(6.1, 192_000);
/// let mut phase = PhaseAccumulator::default();
/// for _ in 0..1_920_000 {
///     phase.advance(step);
/// }
/// assert_eq!(phase, PhaseAccumulator::default());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PhaseAccumulator {
    turns: u64,
    remainder: u64,
}

impl PhaseAccumulator {
    /// Returns the phase of `rad` radians, any finite number of turns.
    #[must_use]
    pub fn from_rad(rad: f64) -> Self {
        let fraction = (rad / TAU).rem_euclid(1.0);
        // `rem_euclid` may round up to 1.0, which is phase 0 again: the cast through u128 wraps it.
        let turns = (fraction * TURN) as u128 as u64;
        Self {
            turns,
            remainder: 0,
        }
    }

    /// Returns the phase in units of 2⁻⁶⁴ of a turn.
    #[inline]
    #[must_use]
    pub fn turns(self) -> u64 {
        self.turns
    }

    /// Returns the phase in radians, `0 ≤ rad < 2π`.
    #[must_use]
    pub fn rad(self) -> f64 {
        // Dropping the bits that f64 cannot represent keeps the result below 2π.
        (self.turns >> 11) as f64 * (TAU / (1_u64 << 53) as f64)
    }

    /// Advances by one frame.
    #[inline]
    pub fn advance(&mut self, step: PhaseStep) {
        self.turns = self.turns.wrapping_add(step.turns);
        self.remainder += step.remainder;
        if self.remainder >= step.modulus {
            self.remainder -= step.modulus;
            self.turns = self.turns.wrapping_add(1);
        }
    }

    /// Advances by `cycles` turns (`0 ≤ cycles < 1`), to within 2⁻⁵³ of a turn: for frequencies that change with every frame.
    #[inline]
    pub fn advance_by_cycles(&mut self, cycles: f64) {
        self.turns = self.turns.wrapping_add((cycles * TURN) as u64);
    }
}

/// Phase advance per frame at a constant frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PhaseStep {
    turns: u64,
    remainder: u64,
    modulus: u64,
}

impl PhaseStep {
    /// Returns the advance per frame of `frequency_hz` at `sample_rate_hz`.
    ///
    /// The frequency is rounded to the nearest nanohertz; the advance is then exact. Aliases (frequencies at or above the rate)
    /// wrap, and negative frequencies do not advance: programs are checked against the rate beforehand.
    #[must_use]
    pub fn new(frequency_hz: f64, sample_rate_hz: u32) -> Self {
        let modulus = u64::from(sample_rate_hz.max(1)) * STEPS_PER_HZ_EXACT;
        let steps = (frequency_hz * STEPS_PER_HZ).round() as u64 % modulus;
        let dividend = u128::from(steps) << 64;
        Self {
            turns: (dividend / u128::from(modulus)) as u64,
            remainder: (dividend % u128::from(modulus)) as u64,
            modulus,
        }
    }

    /// Returns whether the phase does not advance.
    #[inline]
    #[must_use]
    pub fn is_zero(self) -> bool {
        self.turns == 0 && self.remainder == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 35 kHz at 192 kHz is 35 turns in 192 frames: the accumulator must return to exactly 0 each time, which a rounded
    /// increment (2⁶⁴ · 35/192 is not whole) does not.
    #[test]
    fn rational_frequency_closes_exactly() {
        let step = PhaseStep::new(35_000.0, 192_000);
        let mut phase = PhaseAccumulator::default();
        for period in 0..10_000 {
            for _ in 0..192 {
                phase.advance(step);
            }
            assert_eq!(phase, PhaseAccumulator::default(), "period {period}");
        }
    }

    #[test]
    fn decimal_frequency_closes_exactly() {
        // 6.1 Hz at 192 kHz: 61 turns in 1 920 000 frames.
        let step = PhaseStep::new(6.1, 192_000);
        let mut phase = PhaseAccumulator::default();
        for _ in 0..1_920_000 {
            phase.advance(step);
        }
        assert_eq!(phase, PhaseAccumulator::default());
    }

    #[test]
    fn phase_continues_exactly_through_frequency_changes() {
        let mut phase = PhaseAccumulator::default();
        for frequency_hz in [35_000.0, 1.0, 34_999.0] {
            for _ in 0..192_000 {
                phase.advance(PhaseStep::new(frequency_hz, 192_000));
            }
        }
        assert_eq!(phase, PhaseAccumulator::default());
    }

    #[test]
    fn radians_go_in_and_out() {
        for rad in [0.0, 1.0, 3.0, 6.2, -1.0, 100.0, -1e-30] {
            let back = PhaseAccumulator::from_rad(rad).rad();
            assert!((0.0..TAU).contains(&back), "{rad} gave {back}");
            let error = (back - rad + std::f64::consts::PI).rem_euclid(TAU);
            assert!((error - std::f64::consts::PI).abs() < 1e-13, "{rad}");
        }
    }
}
