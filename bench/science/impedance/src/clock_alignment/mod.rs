//! Mapping of another device's clock to the host's, estimated from arrivals in bursts.

mod clock_state;
#[cfg(test)]
mod tests;

use std::collections::VecDeque;

pub use clock_state::{ClockState, MISPLACED_S, TOLERANCE};

/// Length of a bucket in the source's time, s; each bucket keeps only its promptest observation.
const BUCKET_S: f64 = 0.25;
/// Length of a bucket until the map is settled, s: the drift is then known within a second.
const EARLY_BUCKET_S: f64 = 0.025;
/// Age beyond which observations are dropped, s.
const HORIZON_S: f64 = 60.0;
/// Span of observations after which the map is settled, and from which on they change the drift, s.
const SETTLING_S: f64 = 5.0;
/// Number of buckets over which the residual is the median: 5 s.
const RECENT: usize = 20;
/// Approximate time in which a change of the estimate is applied, s, and the largest rate of doing so: the second one applies
/// while the map is off by more than [`MISPLACED_S`].
const SLEW_S: f64 = 1.0;
const FASTEST_SLEW: f64 = 1e-3;
const FASTEST_CORRECTION: f64 = 0.2;

/// Reasons why an observation is rejected.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ClockError {
    /// The source's clock did not advance.
    #[error("source time {source_s:.6} s does not follow {last_s:.6} s")]
    NotLater {
        /// Source time observed, s.
        source_s: f64,
        /// Source time of the previous observation, s.
        last_s: f64,
    },
    /// A time is NaN or infinite.
    #[error("{name} is {value}, not a time")]
    NotFinite {
        /// Name of the invalid time.
        name: &'static str,
        /// Value given, s.
        value: f64,
    },
}

/// Estimates offset and drift of a source's clock against the host's from (source time, arrival time) pairs.
///
/// Arrivals are late by a delay that varies (USB bursts, scheduling) but has a floor. The map is the closest line below all
/// observations of the last minute: an edge of the lower convex hull of the delays
/// (Moon, Skelly & Towsley, INFOCOM 1999). With delays δ_i at the source's times s_i it is the line a + b s ≤ δ_i that
/// minimises Σ (δ_i − a − b s_i) = n (δ̄ − a − b s̄), and so is highest at the mean time s̄: the hull's edge there. A
/// least-squares line would follow the bursts instead. The minimum delay cannot be observed and remains in the offset, as
/// does the time that the newest sample of every burst waits for it: up to one sampling period of the source, if its
/// samples are locked to the bursts.
///
/// Once [`settled`](Self::settled) the drift is fitted without bounds; until then it is limited to [`TOLERANCE`].
/// The settled map is continuous and monotone and never changes for times already passed: a new estimate is approached
/// at no more than 1 ms per second, or faster while [`residual_s`](Self::residual_s) exceeds [`MISPLACED_S`].
///
/// In ten minutes of 16 ms bursts with 0.5 ms mean jitter and drifts up to ±1 %, the error stays below 0.1 ms at 10 kHz; at
/// 1 kHz below 0.25 ms for half a minute, then below 0.1 ms (`bursts_and_drift_over_ten_minutes`). From the first second on it
/// is below the sum of 0.5 ms and the sampling period, from the fifth on below 0.25 ms
/// (`a_drift_is_followed_from_the_first_second_on`). Memory is bounded; an observation takes amortised constant time.
///
/// ```
/// use impedance::clock_alignment::LowerEnvelope;
///
/// // A sensor whose clock began 100 s before the host's, each sample 1 to 4 ms under way.
/// let mut clock = LowerEnvelope::new();
/// for k in 0..1000 {
///     let source_s = 100.0 + 0.01 * f64::from(k);
///     let delay_s = 1e-3 * f64::from(1 + k % 4);
///     clock.observe(source_s, source_s - 100.0 + delay_s)?;
/// }
/// assert!(clock.settled());
/// let host_s = clock.to_host_s(109.0).expect("observed");
/// assert!((host_s - 9.001).abs() < 1e-4);
/// # Ok::<(), impedance::clock_alignment::ClockError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct LowerEnvelope {
    /// The first observation, to which all others are relative, so that hours of uptime cost no digits.
    origin: Option<ClockPair>,
    last_source_s: f64,
    open: Option<Observation>,
    closed: VecDeque<Observation>,
    line: DelayLine,
    /// Slope of the last edge used for the line, unbounded, and span of the observations about it, s.
    edge: (f64, f64),
    settled: bool,
    /// Corners of the map, oldest first; it continues from the last one, which may be ahead, at `rate`.
    corners: VecDeque<ClockPair>,
    rate: f64,
    /// Distances of the map from the promptest arrivals of the latest buckets, s, and their median.
    recent_s: VecDeque<f64>,
    residual_s: Option<f64>,
}

#[derive(Clone, Copy, Debug)]
struct ClockPair {
    source_s: f64,
    host_s: f64,
}

/// Source time and delay, both relative to the origin.
#[derive(Clone, Copy, Debug)]
struct Observation {
    source_s: f64,
    delay_s: f64,
}

/// delay = offset + slope·source.
#[derive(Clone, Copy, Debug, Default)]
struct DelayLine {
    offset_s: f64,
    slope: f64,
}

impl DelayLine {
    fn delay_at(self, source_s: f64) -> f64 {
        self.offset_s + self.slope * source_s
    }
}

impl LowerEnvelope {
    /// Creates a map without observations.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Records that a sample taken at `source_s` of the source's clock arrived at `arrival_s` of the host's. One call per
    /// burst, with its newest sample, is enough; more do no harm. An arrival time may be too late but not too early: read the
    /// clock after the data, because an early time pulls the map down for a minute.
    ///
    /// # Errors
    /// When the source's time does not advance or a time is not finite; the observation is then ignored. A source that has been
    /// reset needs a new map.
    pub fn observe(&mut self, source_s: f64, arrival_s: f64) -> Result<(), ClockError> {
        for (name, value) in [("source_s", source_s), ("arrival_s", arrival_s)] {
            if !value.is_finite() {
                return Err(ClockError::NotFinite { name, value });
            }
        }
        let Some(origin) = self.origin else {
            self.origin = Some(ClockPair {
                source_s,
                host_s: arrival_s,
            });
            self.last_source_s = source_s;
            self.open = Some(Observation {
                source_s: 0.0,
                delay_s: 0.0,
            });
            self.follow(0.0);
            return Ok(());
        };
        if source_s <= self.last_source_s {
            return Err(ClockError::NotLater {
                source_s,
                last_s: self.last_source_s,
            });
        }
        self.last_source_s = source_s;

        let source = source_s - origin.source_s;
        let point = Observation {
            source_s: source,
            delay_s: (arrival_s - origin.host_s) - source,
        };
        match self.open {
            Some(open) if self.bucket(open) == self.bucket(point) => {
                if self.lateness(point) < self.lateness(open) {
                    self.open = Some(point);
                }
            }
            Some(open) => {
                self.judge(open);
                self.closed.push_back(open);
                // Keep the newest one however long the silence after it: with the drift known so far it still determines the
                // offset.
                while self.closed.len() > 1
                    && self
                        .closed
                        .front()
                        .is_some_and(|p| p.source_s < source - HORIZON_S)
                {
                    self.closed.pop_front();
                }
                self.open = Some(point);
                self.fit();
                self.follow(source);
            }
            None => self.open = Some(point),
        }
        Ok(())
    }

    /// Returns the host's time at `source_s` of the source's clock, s; `None` before the first observation.
    #[must_use]
    pub fn to_host_s(&self, source_s: f64) -> Option<f64> {
        let origin = self.origin?;
        Some(origin.host_s + self.map(source_s - origin.source_s))
    }

    /// Returns the source's time at `host_s` of the host's clock, s; `None` before the first observation.
    #[must_use]
    pub fn to_source_s(&self, host_s: f64) -> Option<f64> {
        let origin = self.origin?;
        let host = host_s - origin.host_s;
        let (from, rate) = self.segment(|corner| corner.host_s <= host);
        Some(origin.source_s + from.source_s + (host - from.host_s) / rate)
    }

    /// Returns the source's time expected at `host_s` of the host's clock, s, however far ahead; `None` before
    /// the first observation.
    #[must_use]
    pub fn expected_s(&self, host_s: f64) -> Option<f64> {
        let origin = self.origin?;
        let host = host_s - origin.host_s;
        Some(origin.source_s + (host - self.line.offset_s) / (1.0 + self.line.slope))
    }

    /// Returns the excess rate of the host's clock over the source's, parts per million.
    #[must_use]
    pub fn drift_ppm(&self) -> f64 {
        self.edge.0 * 1e6
    }

    /// Returns the state of the clock.
    #[must_use]
    pub fn state(&self) -> ClockState {
        ClockState {
            drift_ppm: self.drift_ppm(),
            span_s: self.edge.1,
            settled: self.settled,
            residual_s: self.residual_s(),
        }
    }

    /// Returns the median distance of the map from the promptest arrivals of the last 5 s, s; `None` until the map has
    /// been settled for that long.
    #[must_use]
    pub fn residual_s(&self) -> Option<f64> {
        self.residual_s
    }

    /// Whether the observations span 5 s. Before that the map may still jump.
    #[must_use]
    pub fn settled(&self) -> bool {
        self.settled
    }

    fn lateness(&self, point: Observation) -> f64 {
        point.delay_s - self.line.delay_at(point.source_s)
    }

    fn bucket(&self, point: Observation) -> i64 {
        let length_s = if self.settled {
            BUCKET_S
        } else {
            EARLY_BUCKET_S
        };
        (point.source_s / length_s).floor() as i64
    }

    /// Records the distance of the map from the promptest arrival of a bucket.
    fn judge(&mut self, promptest: Observation) {
        if !self.settled {
            return;
        }
        if self.recent_s.len() == RECENT {
            self.recent_s.pop_front();
        }
        let arrived_s = promptest.source_s + promptest.delay_s;
        let residual_s = (arrived_s - self.map(promptest.source_s)).abs();
        self.recent_s.push_back(residual_s);
        if self.recent_s.len() == RECENT {
            let mut sorted: Vec<f64> = self.recent_s.iter().copied().collect();
            sorted.sort_by(f64::total_cmp);
            self.residual_s = sorted.get(RECENT / 2).copied();
        }
        // The delay has stepped, so no line is close to both the old and the new observations.
        while self.closed.len() > RECENT && self.state().misplaces() {
            self.closed.pop_front();
        }
    }

    /// Fits the closest line below the observations: the edge of the lower hull at their middle.
    fn fit(&mut self) {
        let mut hull: Vec<Observation> = vec![];
        for &c in &self.closed {
            // Monotone chain (Andrew 1979): b is dropped if it lies on or above the line from a to c.
            while let [.., a, b] = hull[..]
                && (b.delay_s - a.delay_s) * (c.source_s - a.source_s)
                    >= (c.delay_s - a.delay_s) * (b.source_s - a.source_s)
            {
                hull.pop();
            }
            hull.push(c);
        }
        let middle = self.closed.iter().map(|p| p.source_s).sum::<f64>() / self.closed.len() as f64;
        let was_settled = self.settled;
        let span_s = match hull[..] {
            [first, .., last] => last.source_s - first.source_s,
            _ => 0.0,
        };
        let edge = hull.windows(2).find(|edge| edge[1].source_s >= middle);
        // After a long silence the few new observations determine the offset, but not yet another drift.
        if let Some(&[a, b]) = edge.filter(|_| !self.settled || span_s >= SETTLING_S) {
            // host = source + δ and δ = a + b s: the host's clock runs 1 + b times as fast as the source's.
            let slope = (b.delay_s - a.delay_s) / (b.source_s - a.source_s);
            self.edge = (slope, span_s);
            self.settled |= span_s >= SETTLING_S;
            // A steeper line through few observations is an artefact, or that of a rejected clock.
            let steepest = if self.settled {
                f64::INFINITY
            } else {
                TOLERANCE
            };
            self.line.slope = slope.clamp(-steepest, steepest);
        }
        // With a fixed slope, the edge may not support the line: lower it until all observations lie above.
        let slope = self.line.slope;
        let offsets = hull.iter().map(|p| p.delay_s - slope * p.source_s);
        self.line.offset_s = offsets.fold(f64::INFINITY, f64::min);
        if self.settled && !was_settled {
            self.coarsen();
        }
    }

    /// Keeps the promptest observation of each bucket; the buckets used before the map settled are smaller.
    fn coarsen(&mut self) {
        let mut coarse: VecDeque<Observation> = VecDeque::new();
        for point in std::mem::take(&mut self.closed) {
            match coarse.back_mut() {
                Some(last) if self.bucket(*last) == self.bucket(point) => {
                    if self.lateness(point) < self.lateness(*last) {
                        *last = point;
                    }
                }
                _ => coarse.push_back(point),
            }
        }
        self.closed = coarse;
    }

    /// Bends the map towards the line, from `source_s` on.
    fn follow(&mut self, source_s: f64) {
        let target = source_s + self.line.delay_at(source_s);
        let rate = 1.0 + self.line.slope;
        if !self.settled || self.corners.is_empty() {
            self.corners.clear();
            self.corners.push_back(ClockPair {
                source_s,
                host_s: target,
            });
            self.rate = rate;
            return;
        }
        let host_s = self.map(source_s);
        while self
            .corners
            .back()
            .is_some_and(|corner| corner.source_s >= source_s)
        {
            self.corners.pop_back();
        }
        self.corners.push_back(ClockPair { source_s, host_s });
        let error_s = target - host_s;
        let fastest = if error_s.abs() > MISPLACED_S {
            FASTEST_CORRECTION
        } else {
            FASTEST_SLEW
        };
        let lasts_s = f64::max(SLEW_S, error_s.abs() / fastest);
        // Without further observations the map joins the line there.
        let joined_s = source_s + lasts_s;
        self.corners.push_back(ClockPair {
            source_s: joined_s,
            host_s: joined_s + self.line.delay_at(joined_s),
        });
        self.rate = rate;
        while self
            .corners
            .get(1)
            .is_some_and(|next| next.source_s < source_s - HORIZON_S)
        {
            self.corners.pop_front();
        }
    }

    fn map(&self, source_s: f64) -> f64 {
        let (from, rate) = self.segment(|corner| corner.source_s <= source_s);
        from.host_s + (source_s - from.source_s) * rate
    }

    /// Returns the corner and the rate after the last corner that has `passed`; the first segment extends back indefinitely.
    fn segment(&self, passed: impl Fn(&ClockPair) -> bool) -> (ClockPair, f64) {
        let index = self.corners.partition_point(passed).saturating_sub(1);
        let from = self.corners[index];
        let rate = self.corners.get(index + 1).map_or(self.rate, |end| {
            (end.host_s - from.host_s) / (end.source_s - from.source_s)
        });
        (from, rate)
    }
}
