//! A source that is never read to its end: it sends faster than the bench reads.

/// Time for which something is always left before a source is given up, s.
const LONGEST_S: f64 = 1.0;
/// Fewest looks within that time: a program that was held up finds much waiting, but not again and again.
const FEWEST_LOOKS: u32 = 100;

/// Tells a source that is faster than its reader from one that had to wait.
#[derive(Debug, Default)]
pub(crate) struct Backlog {
    /// When something was left for the first time since the source was read to its end, s.
    since_s: Option<f64>,
    looks: u32,
}

impl Backlog {
    /// Takes whether a look at `now_s` read the source to its end. Returns for how long something has always been left, s,
    /// once that is too long.
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
        // Held up for a minute, then behind for half a second.
        assert_eq!(backlog.take(0.0, false), None);
        for look in 0..90 {
            assert_eq!(backlog.take(60.0 + 5e-3 * f64::from(look), false), None);
        }
        assert_eq!(backlog.take(60.5, true), None);
        let gone = (0..1000).find_map(|look| backlog.take(61.0 + 5e-3 * f64::from(look), false));
        assert!(
            gone.is_some_and(|for_s| (1.0..1.01).contains(&for_s)),
            "{gone:?}"
        );
    }
}
