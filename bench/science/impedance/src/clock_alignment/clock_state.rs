//! State of a source's clock, and its tolerance.

/// Largest relative difference between a source's clock and its reference clock. A crystal is within 100 ppm,
/// a ceramic resonator within 0.5 %. The map follows any drift; the caller rejects one beyond this.
pub const TOLERANCE: f64 = 0.01;
/// Residual beyond which times on the map are flagged, s.
pub const MISPLACED_S: f64 = 2e-3;

/// Time by which a clock must exceed its tolerance to be reported, s: more than the variation of arrivals.
const BEYOND_S: f64 = 0.05;
/// The same while the span is shorter than [`FIRST_S`], s: the first arrivals on a busy computer come late and in bursts.
const BEYOND_AT_FIRST_S: f64 = 0.25;
/// Span of observations beyond which the first arrivals no longer matter, s.
const FIRST_S: f64 = 30.0;

/// Shortest span on either clock from which a clock is judged, s. Data that were queued before the first reading arrive all
/// at once, and look like a clock that runs many times too fast. The map follows the clock meanwhile.
const JUDGED_FROM_S: f64 = 10.0;

/// Shortest span from which the reference clock is known, s.
const SETTLED_S: f64 = 2.0;

/// State of a source's clock relative to the host's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClockState {
    /// Excess rate of the host's clock over the source's, parts per million.
    pub drift_ppm: f64,
    /// Span of the observations that determine the drift, s.
    pub span_s: f64,
    /// Whether the map is settled.
    pub settled: bool,
    /// Median distance of the map from the promptest arrivals of the last 5 s, s; `None` until it is known.
    pub residual_s: Option<f64>,
}

impl ClockState {
    /// Returns the excess rate of the clock over the host's, parts per million; `None` until the map is settled.
    #[must_use]
    pub fn fast_ppm(&self) -> Option<f64> {
        let host = Self {
            settled: true,
            ..Self::default()
        };
        self.fast_ppm_against(&host)
    }

    /// Returns the excess rate of the clock over that of `reference`, parts per million; `None` until both maps are
    /// settled.
    #[must_use]
    pub fn fast_ppm_against(&self, reference: &Self) -> Option<f64> {
        (self.settled && reference.settled).then(|| 1e6 * self.fast_by(reference))
    }

    /// Returns the excess rate of the clock over that of `reference`, parts per million, if it surely exceeds [`TOLERANCE`] in
    /// either direction: after 10 s, if it has gained or lost 250 ms more than allowed; after 30 s, 50 ms more.
    #[must_use]
    pub fn beyond(&self, reference: &Self) -> Option<f64> {
        let fast = self.fast_by(reference);
        let span_s = self.shortest_span_s().min(reference.shortest_span_s());
        let limit_s = if span_s < FIRST_S {
            BEYOND_AT_FIRST_S
        } else {
            BEYOND_S
        };
        let long_enough = self.shortest_span_s() >= JUDGED_FROM_S && span_s >= SETTLED_S;
        let is_certain = long_enough && (fast.abs() - TOLERANCE) * span_s > limit_s;
        is_certain.then_some(1e6 * fast)
    }

    /// Returns the span of the observations on the source's clock or on the host's, whichever is shorter, s.
    fn shortest_span_s(&self) -> f64 {
        self.span_s * (1.0 + 1e-6 * self.drift_ppm).min(1.0)
    }

    fn fast_by(&self, reference: &Self) -> f64 {
        // The host's clock runs 1 + d times as fast as this one and 1 + d_r times as fast as the reference.
        (1.0 + 1e-6 * reference.drift_ppm) / (1.0 + 1e-6 * self.drift_ppm) - 1.0
    }

    /// Returns whether times on the map may be wrong by more than [`MISPLACED_S`].
    #[must_use]
    pub fn misplaces(&self) -> bool {
        self.residual_s
            .is_some_and(|residual_s| residual_s > MISPLACED_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_at_the_start_is_no_clock_beyond_its_tolerance() {
        let clock_at = |drift_ppm, span_s| ClockState {
            drift_ppm,
            span_s,
            settled: true,
            residual_s: None,
        };
        let (card, late) = (clock_at(80.0, 60.0), clock_at(8e6, 0.02));
        assert_eq!(clock_at(0.0, 60.0).beyond(&late), None);
        // Forty seconds of queued readings, read in 0.6 s.
        assert_eq!(clock_at(-985e3, 40.0).beyond(&card), None);
        assert_eq!(clock_at(-3e4, 11.0).beyond(&card), None, "0.23 s");
        assert!(clock_at(-4e4, 11.0).beyond(&card).is_some());
        assert!(clock_at(-15e3, 31.0).beyond(&card).is_some());
    }
}
