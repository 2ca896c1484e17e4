//! Detection of a device that sends data without readings: the baud rate is wrong, or it is another device.

use safety::Nonsense;

/// Time after which data without readings are no longer the start of a stream, ns.
const NONSENSE_NS: u64 = 1_000_000_000;
/// Smallest number of bytes that counts as nonsense; a sensor may greet with a line.
const LEAST_BYTES: u64 = 256;
/// Pause after which bytes count as a new start, ns.
const PAUSE_NS: u64 = 250_000_000;

/// Distinguishes a source that sends nonsense from one that is silent or starting.
#[derive(Debug, Default)]
pub(crate) struct NonsenseWatch {
    /// Arrival of the first and the last byte without a reading, ns.
    bytes_ns: Option<(u64, u64)>,
    bytes: u64,
}

impl NonsenseWatch {
    /// Records the bytes that arrived at `now_ns` and the readings among them. Returns the bytes since the last reading, and
    /// whether they have lasted for a second.
    pub(crate) fn take(&mut self, now_ns: u64, bytes: u64, readings: u64) -> Nonsense {
        if readings > 0 {
            *self = Self::default();
        } else if bytes > 0 {
            let (first_ns, _) = self
                .bytes_ns
                .filter(|(_, last_ns)| now_ns.saturating_sub(*last_ns) < PAUSE_NS)
                .unwrap_or_else(|| {
                    self.bytes = 0;
                    (now_ns, now_ns)
                });
            self.bytes_ns = Some((first_ns, now_ns));
            self.bytes += bytes;
        }
        let is_long = |(first_ns, last_ns): (u64, u64)| last_ns - first_ns >= NONSENSE_NS;
        Nonsense {
            bytes: self.bytes,
            lasts: self.bytes >= LEAST_BYTES && self.bytes_ns.is_some_and(is_long),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Fault 21.
    #[test]
    fn a_second_of_bytes_without_a_reading_is_nonsense_until_there_is_one() {
        let mut watch = NonsenseWatch::default();
        let states: Vec<bool> = (0..3000)
            .map(|ms| watch.take((5 + ms) * MS, 3, 0).lasts)
            .collect();
        assert_eq!(states.iter().position(|&state| state), Some(1000));
        assert!(states[1000..].iter().all(|&state| state));
        // Silence does not end the state.
        assert!(watch.take(3500 * MS, 0, 0).lasts);
        assert_eq!(watch.take(4000 * MS, 20, 1), Nonsense::default());
        // The state recurs, as when the sensor is unplugged and another device is connected.
        let recurrence = (0..2000).filter(|ms| watch.take((4001 + ms) * MS, 3, 0).lasts);
        assert_eq!(recurrence.count(), 1000);
    }

    #[test]
    fn greetings_pauses_and_slow_starts_are_not() {
        let mut greeting = NonsenseWatch::default();
        assert_eq!(greeting.take(0, 200, 0).bytes, 200);
        // The first frames arrive in pieces.
        let nonsense = greeting.take(2000 * MS, 10, 0);
        assert_eq!((nonsense.bytes, nonsense.lasts), (10, false));
        assert_eq!(greeting.take(2001 * MS, 10, 1), Nonsense::default());

        let mut drops = NonsenseWatch::default();
        assert!(
            (0..10_000)
                .step_by(300)
                .all(|ms| !drops.take(ms * MS, 100, 0).lasts)
        );
        let mut silent = NonsenseWatch::default();
        assert!((0..10_000).all(|ms| silent.take(ms * MS, 0, 0) == Nonsense::default()));
        // Single bytes are too few.
        let mut slow = NonsenseWatch::default();
        assert!(
            (0..10_000)
                .step_by(200)
                .all(|ms| !slow.take(ms * MS, 1, 0).lasts)
        );
    }
}
