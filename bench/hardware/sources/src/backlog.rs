//! Detection of a source that sends faster than the bench reads, so that its buffer is never empty.

/// Time without an empty buffer after which a source is rejected, s.
const LONGEST_S: f64 = 1.0;
/// Smallest number of reads within that time: a reader that was held up finds a long backlog, but not repeatedly.
const FEWEST_LOOKS: u32 = 100;

/// Distinguishes a source that is faster than its reader from a reader that was held up.
#[derive(Debug, Default)]
pub(crate) struct Backlog {
    /// Time of the first read that left data after the buffer was last empty, s.
    since_s: Option<f64>,
    looks: u32,
}

impl Backlog {
    /// Records whether the read at `now_s` emptied the buffer. Returns the time since it was last empty, s, if that is too
    /// long.
    pub(crate) fn take(&mut self, now_s: f64, emptied: bool) -> Option<f64> {
        if emptied {
            *self = Self::default();
            return None;
        }
        self.looks = self.looks.saturating_add(1);
        let for_s = now_s - *self.since_s.get_or_insert(now_s);
        (for_s >= LONGEST_S && self.looks >= FEWEST_LOOKS).then_some(for_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_that_was_held_up_gives_no_source_up() {
        let mut backlog = Backlog::default();
        // The reader is held up for a minute, then behind for half a second.
        assert_eq!(backlog.take(0.0, false), None);
        for look in 0..90 {
            assert_eq!(backlog.take(60.0 + 5e-3 * f64::from(look), false), None);
        }
        assert_eq!(backlog.take(60.5, true), None);
        let flood_s = (0..1000).find_map(|look| backlog.take(61.0 + 5e-3 * f64::from(look), false));
        assert!(
            flood_s.is_some_and(|for_s| (1.0..1.01).contains(&for_s)),
            "{flood_s:?}"
        );
    }
}
