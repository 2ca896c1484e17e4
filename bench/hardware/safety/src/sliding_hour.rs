//! Driving time within the last hour.

use std::collections::VecDeque;

/// Length of the window, ns.
const HOUR_NS: i64 = 3_600_000_000_000;

/// A span of time in which the plate was driven, on the bench's clock; a time before the clock's origin is negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrivenSpan {
    /// Start of the drive, ns.
    pub start_ns: i64,
    /// Latest moment of the drive, ns; not before `start_ns`.
    pub end_ns: i64,
}

/// Spans of driving within the last hour, and their total.
///
/// ```
/// use safety::{SlidingHour, DrivenSpan};
///
/// let minutes = |m: i64| m * 60_000_000_000;
/// let mut hour = SlidingHour::default();
/// hour.add(DrivenSpan { start_ns: 0, end_ns: minutes(5) });
/// assert_eq!(hour.used_ns(minutes(30)), minutes(5));
/// // Two minutes of it are over an hour ago.
/// assert_eq!(hour.used_ns(minutes(62)), minutes(3));
/// // With six minutes an hour, four are free again once three of the five have gone.
/// assert_eq!(hour.wait_ns(minutes(30), minutes(4), minutes(6)), minutes(33));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SlidingHour {
    /// Spans in order, separate from each other.
    spans: VecDeque<DrivenSpan>,
}

impl SlidingHour {
    /// Adds a span; time that several spans share counts once. A span that ends before it starts counts as empty.
    pub fn add(&mut self, span: DrivenSpan) {
        let mut merged = DrivenSpan {
            end_ns: span.end_ns.max(span.start_ns),
            ..span
        };
        let first = self
            .spans
            .partition_point(|known| known.end_ns < merged.start_ns);
        let end = self
            .spans
            .partition_point(|known| known.start_ns <= merged.end_ns);
        for known in self.spans.drain(first..end.max(first)) {
            merged.start_ns = merged.start_ns.min(known.start_ns);
            merged.end_ns = merged.end_ns.max(known.end_ns);
        }
        self.spans.insert(first, merged);
    }

    /// Drops the spans that ended over an hour before `now_ns`.
    pub fn forget(&mut self, now_ns: i64) {
        let since_ns = now_ns.saturating_sub(HOUR_NS);
        while self
            .spans
            .front()
            .is_some_and(|span| span.end_ns <= since_ns)
        {
            self.spans.pop_front();
        }
    }

    /// Returns the driving time of the hour before `now_ns`, ns. A span after `now_ns` counts in full.
    #[must_use]
    pub fn used_ns(&self, now_ns: i64) -> i64 {
        self.in_last_hour(now_ns)
            .map(|(_, length_ns)| length_ns)
            .sum()
    }

    /// Returns the time without driving, from `now_ns` on, until `need_ns` of `limit_ns` an hour are free, ns. A need
    /// of more than the limit is never free: the result is then the time until the whole limit is.
    #[must_use]
    pub fn wait_ns(&self, now_ns: i64, need_ns: i64, limit_ns: i64) -> i64 {
        let need_ns = need_ns.min(limit_ns);
        let mut excess_ns = self.used_ns(now_ns) + need_ns - limit_ns;
        let mut free_ns = now_ns;
        for (start_ns, length_ns) in self.in_last_hour(now_ns) {
            if excess_ns <= 0 {
                break;
            }
            free_ns = start_ns + length_ns.min(excess_ns) + HOUR_NS;
            excess_ns -= length_ns;
        }
        free_ns - now_ns
    }

    /// Returns start and length of each span's part within the hour before `now_ns`, ns.
    fn in_last_hour(&self, now_ns: i64) -> impl Iterator<Item = (i64, i64)> {
        let since_ns = now_ns.saturating_sub(HOUR_NS);
        self.spans.iter().filter_map(move |span| {
            let start_ns = span.start_ns.max(since_ns);
            let length_ns = span.end_ns - start_ns;
            (length_ns > 0).then_some((start_ns, length_ns))
        })
    }
}
