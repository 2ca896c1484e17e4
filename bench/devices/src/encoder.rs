//! Position along the plate from counts of a quadrature encoder.

/// Counts quarter cycles of two signals in quadrature, one reading at a time.
///
/// A reading in which both signals changed has missed one state. Its direction is unknown: it counts two in the
/// direction of the last movement and is tallied in [`Quadrature::skipped`]. Three states between two readings look
/// like one backwards, so the lines must be polled faster than that.
///
/// ```
/// use devices::encoder::Quadrature;
///
/// let mut encoder = Quadrature::default();
/// let forward = [(false, false), (false, true), (true, true), (true, false), (false, false)];
/// let counts: Vec<i64> = forward.iter().map(|&(a, b)| encoder.read(a, b)).collect();
/// assert_eq!(counts, [0, 1, 2, 3, 4]);
/// assert_eq!(encoder.read(true, true), 6); // one state missed, taken to be forward
/// assert_eq!(encoder.skipped(), 1);
/// ```
#[derive(Debug, Default)]
pub struct Quadrature {
    phase: Option<u8>,
    count: i64,
    forward: bool,
    skipped: u64,
}

impl Quadrature {
    /// Counts one reading of both signals; returns the count so far.
    pub fn read(&mut self, a: bool, b: bool) -> i64 {
        // Gray code to position in the cycle.
        let phase = (u8::from(a) << 1 | u8::from(a ^ b)) & 3;
        let moved = self
            .phase
            .replace(phase)
            .map_or(0, |last| phase.wrapping_sub(last) & 3);
        match moved {
            1 => {
                self.forward = true;
                self.count += 1;
            }
            3 => {
                self.forward = false;
                self.count -= 1;
            }
            2 => {
                self.skipped += 1;
                self.count += if self.forward { 2 } else { -2 };
            }
            _ => {}
        }
        self.count
    }

    /// Returns the number of readings that had missed a state.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// Speed that no finger reaches, m/s: a plate of a tenth of a metre crossed in a tenth of a second. An assumption, some
/// ten times the speed of the published explorations.
pub const IMPOSSIBLE_M_PER_S: f64 = 1.0;

/// Largest sum of removed jumps up to which positions are believed, m: a thirtieth of the published crop of 60 mm.
pub const BELIEVED_M: f64 = 2e-3;

/// Removes jumps from positions. A finger cannot jump: either the count slipped or somebody threw the carriage, which
/// look alike. The sum of removed jumps is how far the position may be wrong; beyond [`BELIEVED_M`] the position is
/// unknown (`docs/decisions/0013-after-a-jump-of-the-encoder.md`).
#[derive(Debug, Default)]
pub struct JumpWatch {
    last: Option<(f64, f64)>,
    taken_out_m: f64,
}

/// A counted position after the check for jumps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watched {
    /// Position without jumps, m; NaN while it is unknown.
    pub position_m: f64,
    /// Whether it cannot have been reached since the last one.
    pub jumped: bool,
}

impl JumpWatch {
    /// Checks a position counted at `host_s`, host time in s.
    pub fn take(&mut self, host_s: f64, counted_m: f64) -> Watched {
        let step = self
            .last
            .replace((host_s, counted_m))
            .map(|(last_s, last_m)| (host_s - last_s, counted_m - last_m));
        let jump_m = step
            .filter(|(in_s, step_m)| step_m.abs() > IMPOSSIBLE_M_PER_S * in_s)
            .map(|(_, step_m)| step_m);
        self.taken_out_m += jump_m.unwrap_or(0.0);
        let believed = self.taken_out_m.abs() <= BELIEVED_M;
        Watched {
            position_m: if believed {
                counted_m - self.taken_out_m
            } else {
                f64::NAN
            },
            jumped: jump_m.is_some(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{JumpWatch, Quadrature};
    use proptest::prelude::*;

    fn levels(count: i64) -> (bool, bool) {
        // A leads B when moving forward: 00 → 10 would be the other sense.
        [(false, false), (false, true), (true, true), (true, false)][count.rem_euclid(4) as usize]
    }

    #[test]
    fn the_gray_code_is_followed_both_ways() {
        let mut encoder = Quadrature::default();
        let path = [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0, -1, -2];
        let read: Vec<_> = path
            .iter()
            .map(|&count| {
                let (a, b) = levels(count);
                encoder.read(a, b)
            })
            .collect();
        assert_eq!(read, path);
        assert_eq!(encoder.skipped(), 0);
    }

    /// Positions of counted ones, a millisecond apart, and which of them are jumps.
    fn watched(counted_m: &[f64]) -> (Vec<f64>, Vec<usize>) {
        let mut watch = JumpWatch::default();
        let times_s = (0..).map(|ms| f64::from(ms) * 1e-3);
        let watched: Vec<_> = times_s
            .zip(counted_m)
            .map(|(host_s, &counted_m)| watch.take(host_s, counted_m))
            .collect();
        let jumps = (0..watched.len()).filter(|&i| watched[i].jumped).collect();
        (watched.iter().map(|it| it.position_m).collect(), jumps)
    }

    fn agree(found_m: &[f64], expected_m: &[f64]) {
        assert_eq!(found_m.len(), expected_m.len());
        for (found, expected) in found_m.iter().zip(expected_m) {
            let both_unknown = found.is_nan() && expected.is_nan();
            assert!(
                both_unknown || (found - expected).abs() < 1e-12,
                "{found_m:?}"
            );
        }
    }

    /// Fault 20.
    #[test]
    fn a_jump_is_what_no_finger_does_and_is_taken_out() {
        let (positions_m, jumps) = watched(&[0.0500, 0.0509, 0.0520, 0.0521, 0.0522]);
        assert_eq!(jumps, [2]);
        agree(&positions_m, &[0.0500, 0.0509, 0.0509, 0.0510, 0.0511]);
        // Out and back is nothing.
        let (positions_m, jumps) = watched(&[0.05, 0.0, 0.05, 0.0501]);
        assert_eq!(jumps, [1, 2]);
        agree(&positions_m, &[0.05, f64::NAN, 0.05, 0.0501]);
    }

    #[test]
    fn after_a_jump_that_matters_the_position_is_not_known() {
        let jumps = [0.05, 0.0515, 0.0516, 0.0531, 0.0532, 0.0517, 0.0518];
        let (positions_m, jumps) = watched(&jumps);
        assert_eq!(jumps, [1, 3, 5]);
        let unknown = f64::NAN;
        // 1.5 mm, then 3 mm, then 1.5 mm again.
        agree(
            &positions_m,
            &[0.05, 0.05, 0.0501, unknown, unknown, 0.0502, 0.0503],
        );
    }

    #[test]
    fn a_reader_that_comes_late_sees_no_jump() {
        let mut watch = JumpWatch::default();
        watch.take(1.0, 0.02);
        let late = watch.take(1.1, 0.09);
        assert_eq!((late.jumped, late.position_m), (false, 0.09));
    }

    proptest! {
        #[test]
        fn steps_of_up_to_two_in_one_direction_lose_nothing(steps in prop::collection::vec(0i64..=2, 1..200), forward: bool) {
            let sign = if forward { 1 } else { -1 };
            let mut encoder = Quadrature::default();
            encoder.read(false, false);
            let mut truth = 0;
            // The sense of the first movement has to be seen once.
            for step in std::iter::once(1).chain(steps) {
                truth += sign * step;
                let (a, b) = levels(truth);
                prop_assert_eq!(encoder.read(a, b), truth);
            }
        }
    }
}
