//! A port that speaks, and nothing of it is a reading: the baud is wrong, or another device is on it.

/// Time after which nonsense is no start of a stream any more, ns.
const NONSENSE_NS: u64 = 1_000_000_000;
/// Fewest bytes that can be called nonsense; a sensor may greet with a line.
const LEAST_BYTES: u64 = 256;
/// Pause after which bytes are another start, ns.
const PAUSE_NS: u64 = 250_000_000;

/// Tells a port that sends nonsense from one that is silent or about to begin.
#[derive(Debug, Default)]
pub struct NonsenseWatch {
    /// When the first byte without a reading came, and the last, ns.
    heard_ns: Option<(u64, u64)>,
    bytes: u64,
    reported: bool,
}

impl NonsenseWatch {
    /// Takes the bytes and the readings among them that came at `now_ns`. Returns the bytes without a reading, once they
    /// have come for a second.
    pub fn take(&mut self, now_ns: u64, bytes: u64, readings: u64) -> Option<u64> {
        if readings > 0 {
            *self = Self::default();
            return None;
        }
        if bytes == 0 {
            return None;
        }
        let (first_ns, _) = self
            .heard_ns
            .filter(|(_, last_ns)| now_ns.saturating_sub(*last_ns) < PAUSE_NS)
            .unwrap_or_else(|| {
                self.bytes = 0;
                (now_ns, now_ns)
            });
        self.heard_ns = Some((first_ns, now_ns));
        self.bytes += bytes;
        let lasts = now_ns.saturating_sub(first_ns) >= NONSENSE_NS && self.bytes >= LEAST_BYTES;
        (lasts && !std::mem::replace(&mut self.reported, true)).then_some(self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Fault 21.
    #[test]
    fn a_second_of_bytes_without_a_reading_is_nonsense_once() {
        let mut watch = NonsenseWatch::default();
        let found: Vec<(u64, u64)> = (0..3000)
            .filter_map(|ms| Some((ms, watch.take(5 * MS + ms * MS, 3, 0)?)))
            .collect();
        assert_eq!(found, [(1000, 3003)]);
        // Readings, and nonsense again: as when the sensor is unplugged for another device.
        assert_eq!(watch.take(4000 * MS, 20, 1), None);
        let again = (0..2000).filter_map(|ms| watch.take((4001 + ms) * MS, 3, 0));
        assert_eq!(again.count(), 1);
    }

    #[test]
    fn greetings_pauses_and_slow_starts_are_not() {
        let mut greeting = NonsenseWatch::default();
        assert_eq!(greeting.take(0, 200, 0), None);
        // The first frames, in pieces.
        assert_eq!(greeting.take(2000 * MS, 10, 0), None);
        assert_eq!(greeting.take(2001 * MS, 10, 1), None);

        let mut drops = NonsenseWatch::default();
        for ms in (0..10_000).step_by(300) {
            assert_eq!(drops.take(ms * MS, 100, 0), None, "{ms} ms");
        }
        let mut silent = NonsenseWatch::default();
        for ms in 0..10_000 {
            assert_eq!(silent.take(ms * MS, 0, 0), None);
        }
        // Single bytes are too few.
        let mut slow = NonsenseWatch::default();
        for ms in (0..10_000).step_by(200) {
            assert_eq!(slow.take(ms * MS, 1, 0), None);
        }
    }
}
