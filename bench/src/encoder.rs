//! Position along the plate from a quadrature encoder.

/// Counts quarter cycles of two signals in quadrature, one reading at a time.
///
/// A reading in which both signals changed has missed one state: whether it was forward or back cannot be seen, so it
/// counts two in the direction of the last movement, and is tallied in [`Quadrature::skipped`]. Three states between two
/// readings look like one backwards: the poller must be faster than that.
#[derive(Debug, Default)]
pub struct Quadrature {
    phase: Option<u8>,
    count: i64,
    forward: bool,
    skipped: u64,
}

impl Quadrature {
    /// Takes one reading of both signals; returns the count.
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

    /// Readings so far that had missed a state.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }
}

/// No finger crosses a plate of a tenth of a metre in less than a tenth of a second, m/s: an assumption, some ten times the speed
/// of the published explorations.
pub const IMPOSSIBLE_M_PER_S: f64 = 1.0;

/// Watches positions for jumps.
#[derive(Debug, Default)]
pub struct JumpWatch {
    last: Option<(f64, f64)>,
}

impl JumpWatch {
    /// Takes a position read at `host_s`; true when it cannot have been reached since the last one.
    pub fn take(&mut self, host_s: f64, position_m: f64) -> bool {
        let Some((last_s, last_m)) = self.last.replace((host_s, position_m)) else {
            return false;
        };
        (position_m - last_m).abs() > IMPOSSIBLE_M_PER_S * (host_s - last_s)
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

    #[test]
    fn a_jump_is_what_no_finger_does() {
        let mut watch = JumpWatch::default();
        assert!(!watch.take(1.0, 0.05), "nothing to compare with");
        assert!(!watch.take(1.001, 0.0509));
        assert!(watch.take(1.002, 0.0520));
        assert!(!watch.take(1.003, 0.0520), "it stands where it jumped to");
        assert!(watch.take(1.004, 0.0509));
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
