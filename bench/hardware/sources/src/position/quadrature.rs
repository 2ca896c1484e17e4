//! Counter for two signals in quadrature.

/// Counts quarter cycles of two signals in quadrature, one reading at a time.
///
/// If both signals changed since the previous reading, one state was missed. Its direction is unknown: it counts two in the
/// direction of the last movement and is added to [`Quadrature::skipped`]. Three states between two readings look like one
/// backwards, so the lines must be polled faster than that.
///
/// ```
/// use sources::position::Quadrature;
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
        let step = self
            .phase
            .replace(phase)
            .map_or(0, |last| phase.wrapping_sub(last) & 3);
        match step {
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

    /// Returns the number of readings with a missed state.
    pub fn skipped(&self) -> u64 {
        self.skipped
    }
}

#[cfg(test)]
mod tests {
    use super::Quadrature;
    use proptest::prelude::*;

    fn levels(count: i64) -> (bool, bool) {
        // A leads B when moving forward: 00 → 10 would be the opposite direction.
        [(false, false), (false, true), (true, true), (true, false)][count.rem_euclid(4) as usize]
    }

    #[test]
    fn the_gray_code_is_followed_both_ways() {
        let mut encoder = Quadrature::default();
        let path = [0, 1, 2, 3, 4, 5, 4, 3, 2, 1, 0, -1, -2];
        let counts: Vec<_> = path
            .iter()
            .map(|&count| {
                let (a, b) = levels(count);
                encoder.read(a, b)
            })
            .collect();
        assert_eq!(counts, path);
        assert_eq!(encoder.skipped(), 0);
    }

    proptest! {
        #[test]
        fn steps_of_up_to_two_in_one_direction_lose_nothing(steps in prop::collection::vec(0i64..=2, 1..200), forward: bool) {
            let sign = if forward { 1 } else { -1 };
            let mut encoder = Quadrature::default();
            encoder.read(false, false);
            let mut truth = 0;
            // The direction of the first movement must be seen once.
            for step in std::iter::once(1).chain(steps) {
                truth += sign * step;
                let (a, b) = levels(truth);
                prop_assert_eq!(encoder.read(a, b), truth);
            }
        }
    }
}
