//! Time on a device's own clock.

/// Time by which a device's clock may disagree with the arrival of its readings, s. One that disagrees by more has
/// begun anew: the device was switched off or reset.
pub(crate) const RESTARTED_S: f64 = 1.0;

/// Count that a device's clock should show when bytes arrive, by what is known of it, and how far off it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedCount {
    /// The count.
    pub(crate) count: f64,
    /// Counts by which a reading may be ahead of it.
    pub(crate) ahead: f64,
    /// Counts by which a reading may be behind it: for as long as nobody has read, it may have waited.
    pub(crate) behind: f64,
}

/// Place of a reading by its count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// After those before, at this count since the device was first heard.
    Next(u64),
    /// At the last reading, or before it.
    Past,
    /// Of a clock that has begun anew, at this count of the same course.
    Restarted(u64),
}

/// A counter of 32 bits, extended to 64 across its wraps and its restarts.
///
/// A wrap is told from a restart by the arrival of the readings, an independent clock: without it a count that has gone
/// back by more than half the circle looks like one that went on.
#[derive(Debug, Default)]
pub(crate) struct DeviceCount {
    last: Option<u64>,
    /// Added to what the device counts, since its last restart.
    added: u32,
}

impl DeviceCount {
    /// Returns where a reading belongs that counts `wrapped`; without `expected` the nearest place to the last reading.
    pub(crate) fn place(&self, wrapped: u32, expected: Option<&ExpectedCount>) -> Place {
        let shifted = wrapped.wrapping_add(self.added);
        let Some(last) = self.last else {
            return Place::Next(u64::from(shifted));
        };
        // A count below 0 was before the first reading.
        let about = expected.map_or(last, |expected| expected.count.max(0.0).round() as u64);
        // As a signed difference a step back in time stays small instead of looking like a wrap.
        let step = shifted.wrapping_sub(about as u32).cast_signed();
        let near = about.saturating_add_signed(i64::from(step));
        if let Some(expected) = expected {
            let ahead = near as f64 - expected.count;
            if ahead > expected.ahead || -ahead > expected.behind {
                return Place::Restarted(about.max(last + 1));
            }
        }
        if near > last {
            Place::Next(near)
        } else {
            Place::Past
        }
    }

    /// Takes a reading at its place; returns its count in 64 bits, `None` of one that is past.
    pub(crate) fn take(&mut self, wrapped: u32, place: Place) -> Option<u64> {
        let count = match place {
            Place::Next(count) => count,
            Place::Past => return None,
            Place::Restarted(count) => {
                self.added = (count as u32).wrapping_sub(wrapped);
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

    /// A microsecond counter that is read `us` after the arrival that `expected` is of.
    fn expected(us: f64) -> ExpectedCount {
        ExpectedCount {
            count: us,
            ahead: 1e6 * RESTARTED_S,
            behind: 1e6 * RESTARTED_S,
        }
    }

    fn take(clock: &mut DeviceCount, wrapped: u32) -> Option<u64> {
        let place = clock.place(wrapped, None);
        clock.take(wrapped, place)
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
            // Silent for a while of any length, it goes on.
            for silent_us in [1e3, 3e6, 2_200e6, 40_000e6] {
                let now = up_us + silent_us;
                let place = clock.place(now as u64 as u32, Some(&expected(now + 2e3)));
                assert_eq!(place, Place::Next(now as u64), "{up_us} {silent_us}");
            }
            // It was reset: a second and a half later it counts from 0.
            let now = expected(up_us + 1.5e6);
            let place = clock.place(300, Some(&now));
            assert_eq!(place, Place::Restarted(now.count as u64), "{up_us}");
            let restarted = clock.take(300, place).unwrap();
            let next = clock.place(1300, Some(&expected(up_us + 1.501e6)));
            assert_eq!(next, Place::Next(restarted + 1000));
        }
    }
}
