//! Spans of a recording that are analysed.

use std::ops::Range;

use recording::Manifest;
use recording::manifest::joined_spans;

/// Time next to an interval in which the plate may be free, s: a finger comes or goes, and the drive is on.
const SURROUNDINGS_S: f64 = 2.0;

/// Spans of a recording that are analysed, in order, joined where they overlap.
#[derive(Debug)]
pub(super) struct Spans(Vec<(f64, f64)>);

impl Spans {
    /// Returns the recording's intervals.
    pub(super) fn new(manifest: &Manifest) -> Self {
        Self::with_margin(manifest, 0.0)
    }

    /// Returns the recording's intervals with their surroundings.
    pub(super) fn with_surroundings(manifest: &Manifest) -> Self {
        Self::with_margin(manifest, SURROUNDINGS_S)
    }

    fn with_margin(manifest: &Manifest, margin_s: f64) -> Self {
        let intervals = manifest.intervals.iter();
        Self(joined_spans(intervals.map(|interval| {
            (interval.start_s - margin_s, interval.end_s + margin_s)
        })))
    }

    /// Returns whether a time is in a span, or at most `margin_s` from it.
    pub(super) fn contain(&self, time_s: f64, margin_s: f64) -> bool {
        let index = self
            .0
            .partition_point(|(_, end_s)| end_s + margin_s < time_s);
        let span = self.0.get(index);
        span.is_some_and(|(start_s, _)| start_s - margin_s <= time_s)
    }

    /// Returns the spans in samples.
    pub(super) fn samples(&self, rate_hz: f64) -> Vec<Range<u64>> {
        let sample = |time_s: f64| (time_s * rate_hz) as u64;
        let spans = self.0.iter();
        spans
            .map(|&(start_s, end_s)| sample(start_s)..sample(end_s))
            .collect()
    }
}
