//! Time on a device's clock.

/// Largest difference between a device's clock and the arrival of its readings, s. A larger difference means that the device
/// was switched off or reset.
pub(crate) const RESTARTED_S: f64 = 1.0;

/// Expected count of a device's clock when bytes arrive, with its tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedCount {
    /// Expected count.
    pub(crate) count: f64,
    /// Tolerance for a reading ahead of the expected count, counts.
    pub(crate) ahead: f64,
    /// Tolerance for a reading behind the expected count, counts: it may have waited since the previous read.
    pub(crate) behind: f64,
}

/// Position of a reading in the sequence by its count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// After the earlier readings, at this count since the device's first reading.
    Next(u64),
    /// At or before the last reading.
    Past,
    /// From a restarted clock, at this count of the continued sequence.
    Restarted(u64),
}

/// A 32-bit counter, extended to 64 bits across wraps and restarts.
///
/// A wrap is distinguished from a restart by the arrival time of the readings, an independent clock: without it, a count that
/// went back by more than half the range would look like one that advanced.
#[derive(Debug, Default)]
pub(crate) struct DeviceCount {
    last: Option<u64>,
    /// Offset added to the device's count since its last restart.
    added: u32,
}

impl DeviceCount {
    /// Returns the place of a reading with the count `counter`; without `expected`, the place nearest to the last reading.
    pub(crate) fn place(&self, counter: u32, expected: Option<&ExpectedCount>) -> Place {
        let count = counter.wrapping_add(self.added);
        let Some(last) = self.last else {
            return Place::Next(u64::from(count));
        };
        // A count below 0 was before the first reading.
        let nearest = expected.map_or(last, |expected| expected.count.max(0.0).round() as u64);
        // As a signed difference, a step back in time stays small instead of looking like a wrap.
        let step = count.wrapping_sub(nearest as u32).cast_signed();
        let near = nearest.saturating_add_signed(i64::from(step));
        if let Some(expected) = expected {
            let ahead = near as f64 - expected.count;
            if ahead > expected.ahead || -ahead > expected.behind {
                return Place::Restarted(nearest.max(last + 1));
            }
        }
        if near > last {
            Place::Next(near)
        } else {
            Place::Past
        }
    }

    /// Records a reading at its place; returns its 64-bit count, or `None` for a past reading.
    pub(crate) fn take(&mut self, counter: u32, place: Place) -> Option<u64> {
        let count = match place {
            Place::Next(count) => count,
            Place::Past => return None,
            Place::Restarted(count) => {
                self.added = (count as u32).wrapping_sub(counter);
                count
            }
        };
        self.last = Some(count);
        Some(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns an expected count of `us` µs, with the tolerance for a restart.
    fn expected(us: f64) -> ExpectedCount {
        ExpectedCount {
            count: us,
            ahead: 1e6 * RESTARTED_S,
            behind: 1e6 * RESTARTED_S,
        }
    }

    fn take(clock: &mut DeviceCount, counter: u32) -> Option<u64> {
        let place = clock.place(counter, None);
        clock.take(counter, place)
    }

    /// Fault 22.
    #[test]
    fn device_time_goes_on_past_the_wrap() {
        let mut clock = DeviceCount::default();
        let first = u64::from(u32::MAX - 49);
        assert_eq!(take(&mut clock, u32::MAX - 49), Some(first));
        assert_eq!(take(&mut clock, 50), Some(first + 100));
        assert_eq!(clock.place(40, None), Place::Past);
        assert_eq!(take(&mut clock, 150), Some(first + 200));
    }

    /// Fault 48.
    #[test]
    fn a_clock_that_begins_anew_is_told_from_one_that_wraps_and_from_one_that_was_silent() {
        for up_us in [5e6, 601e6, 2_150e6, 4_290e6, 9_000e6] {
            let mut clock = DeviceCount {
                last: Some(up_us as u64),
                added: 0,
            };
            // Silence of any length is not a restart.
            for silent_us in [1e3, 3e6, 2_200e6, 40_000e6] {
                let now = up_us + silent_us;
                let place = clock.place(now as u64 as u32, Some(&expected(now + 2e3)));
                assert_eq!(place, Place::Next(now as u64), "{up_us} {silent_us}");
            }
            // After a reset, it counts from 0 a second and a half later.
            let now = expected(up_us + 1.5e6);
            let place = clock.place(300, Some(&now));
            assert_eq!(place, Place::Restarted(now.count as u64), "{up_us}");
            let restarted = clock.take(300, place).unwrap();
            let next = clock.place(1300, Some(&expected(up_us + 1.501e6)));
            assert_eq!(next, Place::Next(restarted + 1000));
        }
    }
}
