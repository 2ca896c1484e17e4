//! Another device's clock on the host's, estimated from arrivals in bursts.

use std::collections::VecDeque;

/// Length of the buckets, in the source's time, of which each keeps only its promptest observation, s.
const BUCKET_S: f64 = 0.25;
/// How far back observations count, s.
const HORIZON_S: f64 = 60.0;
/// Span of observations after which the map is trusted, s.
const SETTLING_S: f64 = 5.0;
/// Crystals are within ±100 ppm; a steeper line is an artefact of few observations.
const STEEPEST: f64 = 500e-6;
/// A change of the estimate is worked off in about this time, at no more than this rate.
const SLEW_S: f64 = 1.0;
const FASTEST_SLEW: f64 = 1e-3;

/// Why an observation is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ClockError {
    /// The source's clock did not advance.
    #[error("source time {source_s} s does not follow {last_s} s")]
    NotLater {
        /// Source time observed, s.
        source_s: f64,
        /// Source time of the observation before, s.
        last_s: f64,
    },
    /// A time is NaN or infinite.
    #[error("{name} is {value}, not a time")]
    NotFinite {
        /// Which of the two times.
        name: &'static str,
        /// Value given, s.
        value: f64,
    },
}

/// Estimates offset and drift of a source's clock against the host's from (source time, arrival time) pairs.
///
/// Arrivals are late by a delay that varies (USB bursts, scheduling) but has a floor. The map is the line under all
/// observations of the last minute that lies nearest to them: an edge of the lower convex hull of the delays
/// (Moon, Skelly & Towsley, INFOCOM 1999). A least-squares line would follow the bursts instead. The least delay
/// cannot be observed and stays in the offset, and so does the time that the newest sample of every burst waits for it:
/// up to one sampling period of the source, when its samples are locked to the bursts.
///
/// Once [`settled`](Self::settled) the map is continuous and monotone and never changes for times already passed: a new
/// estimate is approached at no more than 1 ms a second. In ten minutes of 16 ms bursts, 0.5 ms mean jitter, ±100 ppm,
/// the error stays under 0.1 ms at 10 kHz; at 1 kHz under 0.25 ms for half a minute, then under 0.1 ms
/// (`bursts_and_drift_over_ten_minutes`). Memory is bounded, an observation takes amortised constant time.
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
    /// The first observation, from which all else counts, so that hours of uptime cost no digits.
    origin: Option<ClockPair>,
    last_source_s: f64,
    open: Option<Observation>,
    closed: VecDeque<Observation>,
    line: DelayLine,
    settled: bool,
    /// The map's corners, oldest first; it goes on from the last one at `rate`.
    corners: VecDeque<ClockPair>,
    rate: f64,
}

#[derive(Clone, Copy, Debug)]
struct ClockPair {
    source_s: f64,
    host_s: f64,
}

/// Source time and delay, both from the origin.
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
    fn at(self, source_s: f64) -> f64 {
        self.offset_s + self.slope * source_s
    }
}

impl LowerEnvelope {
    /// Creates a map without observations.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Notes that what was sampled at `source_s` of the source's clock arrived at `arrival_s` of the host's. One call a
    /// burst, with its newest sample, is enough; more do no harm. An arrival may be stated late, never early: it is to
    /// be read off the clock after the data, because one that is too early pulls the map down for a minute.
    ///
    /// # Errors
    /// When the source's time does not advance or a time is not finite; nothing is noted then. A source that has been
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
            Some(open) if bucket(open) == bucket(point) => {
                if self.lateness(point) < self.lateness(open) {
                    self.open = Some(point);
                }
            }
            Some(open) => {
                self.closed.push_back(open);
                // The newest stays however long the silence after it: with the drift known so far it still tells the
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

    /// Returns how much faster the host's clock runs than the source's, parts per million.
    #[must_use]
    pub fn drift_ppm(&self) -> f64 {
        self.line.slope * 1e6
    }

    /// Whether the observations span 5 s; before that the map may still jump.
    #[must_use]
    pub fn settled(&self) -> bool {
        self.settled
    }

    fn lateness(&self, point: Observation) -> f64 {
        point.delay_s - self.line.at(point.source_s)
    }

    /// The edge of the lower hull above the middle of the observations: of all lines under them, the nearest.
    fn fit(&mut self) {
        let mut hull: Vec<Observation> = vec![];
        for &c in &self.closed {
            while let [.., a, b] = hull[..]
                && (b.delay_s - a.delay_s) * (c.source_s - a.source_s)
                    >= (c.delay_s - a.delay_s) * (b.source_s - a.source_s)
            {
                hull.pop();
            }
            hull.push(c);
        }
        let middle = self.closed.iter().map(|p| p.source_s).sum::<f64>() / self.closed.len() as f64;
        let edge = hull.windows(2).find(|edge| edge[1].source_s >= middle);
        if let Some(&[a, b]) = edge {
            let slope = (b.delay_s - a.delay_s) / (b.source_s - a.source_s);
            self.line.slope = slope.clamp(-STEEPEST, STEEPEST);
        }
        // With the slope clamped, or kept from before a long silence, the edge may not support the line: lower it until
        // all lie above.
        let slope = self.line.slope;
        let offsets = hull.iter().map(|p| p.delay_s - slope * p.source_s);
        self.line.offset_s = offsets.fold(f64::INFINITY, f64::min);
        if let [first, .., last] = hull[..] {
            self.settled |= last.source_s - first.source_s >= SETTLING_S;
        }
    }

    /// Turns the map towards the line, from `source_s` on.
    fn follow(&mut self, source_s: f64) {
        let target = source_s + self.line.at(source_s);
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
        self.corners.push_back(ClockPair { source_s, host_s });
        self.rate = rate + ((target - host_s) / SLEW_S).clamp(-FASTEST_SLEW, FASTEST_SLEW);
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

    /// The corner and the rate that hold after the last corner that has `passed`; the first segment goes back for ever.
    fn segment(&self, passed: impl Fn(&ClockPair) -> bool) -> (ClockPair, f64) {
        let index = self.corners.partition_point(passed).saturating_sub(1);
        let from = self.corners[index];
        let rate = self.corners.get(index + 1).map_or(self.rate, |to| {
            (to.host_s - from.host_s) / (to.source_s - from.source_s)
        });
        (from, rate)
    }
}

fn bucket(point: Observation) -> i64 {
    (point.source_s / BUCKET_S).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A sensor whose samples reach the host only when a burst is due, some time after.
    struct Link {
        period_s: f64,
        drift: f64,
        burst_s: f64,
        jitter_s: f64,
    }

    const OFFSET_S: f64 = 1234.5;
    const FLOOR_S: f64 = 0.002;

    impl Link {
        fn host_s(&self, source_s: f64) -> f64 {
            OFFSET_S + source_s * (1.0 + self.drift)
        }

        /// Calls `each` with every (source, arrival) in order of arrival.
        fn run(&self, duration_s: f64, seed: u64, mut each: impl FnMut(f64, f64)) {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let (mut burst, mut arrival) = (0i64, 0.0);
            for k in 0..(duration_s / self.period_s) as u64 {
                let source_s = k as f64 * self.period_s;
                let due = (self.host_s(source_s) / self.burst_s).ceil() as i64;
                if due > burst {
                    burst = due;
                    let late = -self.jitter_s * (1.0 - random.random::<f64>()).ln();
                    arrival = f64::max(arrival, due as f64 * self.burst_s + FLOOR_S + late);
                }
                each(source_s, arrival);
            }
        }
    }

    /// Fault 24.
    #[test]
    fn bursts_and_drift_over_ten_minutes() {
        // A sensor at 1 kHz whose bursts were locked to its samples would hide up to 1 ms of waiting for many seconds.
        for (seed, period_s, burst_s, drift) in [
            (1, 1e-4, 0.016, 100e-6),
            (2, 1e-4, 0.016, -100e-6),
            (3, 1e-4, 0.016, 0.0),
            (4, 1e-3, 0.016_13, 60e-6),
            (5, 1e-3, 0.016_13, -100e-6),
        ] {
            let link = Link {
                period_s,
                drift,
                burst_s,
                jitter_s: 5e-4,
            };
            let mut clock = LowerEnvelope::new();
            let (mut early, mut worst, mut last) = (0.0f64, 0.0f64, f64::NEG_INFINITY);
            let mut settled_at = f64::NAN;
            link.run(600.0, seed, |source_s, arrival_s| {
                clock.observe(source_s, arrival_s).unwrap();
                if !clock.settled() {
                    return;
                }
                if settled_at.is_nan() {
                    settled_at = source_s;
                }
                let host_s = clock.to_host_s(source_s).unwrap();
                assert!(host_s > last, "the map went back at {source_s} s");
                last = host_s;
                let error = (host_s - link.host_s(source_s) - FLOOR_S).abs();
                if source_s < 30.0 {
                    early = early.max(error);
                } else {
                    worst = worst.max(error);
                }
            });
            println!("{drift:+e}, {period_s} s: {early:e} s early, then {worst:e} s");
            assert!(settled_at < 6.0);
            assert!(worst < 1e-4, "drift {drift}: {worst} s");
            let limit = if period_s < 1e-3 { 1e-4 } else { 2.5e-4 };
            assert!(early < limit, "drift {drift}: {early} s early");
            assert_abs_diff_eq!(clock.drift_ppm(), drift * 1e6, epsilon = 2.0);
            assert!(clock.closed.len() < 250 && clock.corners.len() < 250);
        }
    }

    #[test]
    fn a_step_of_the_delay_is_forgotten_after_the_horizon() {
        let mut clock = LowerEnvelope::new();
        for k in 0..20_000u32 {
            let source_s = f64::from(k) * 0.01;
            let delay = if source_s < 60.0 { 0.001 } else { 0.004 };
            clock.observe(source_s, source_s + delay).unwrap();
        }
        assert_abs_diff_eq!(clock.to_host_s(199.0).unwrap(), 199.004, epsilon = 1e-6);
    }

    #[test]
    fn a_long_silence_keeps_offset_and_drift() {
        let mut clock = LowerEnvelope::new();
        let host_s = |source_s: f64| 7.0 + source_s * (1.0 + 50e-6);
        for k in (0..3000u32).chain(30_000..30_500) {
            let source_s = f64::from(k) * 0.01;
            clock.observe(source_s, host_s(source_s)).unwrap();
            assert_abs_diff_eq!(
                clock.to_host_s(source_s).unwrap(),
                host_s(source_s),
                epsilon = 3e-5
            );
        }
        assert_abs_diff_eq!(clock.drift_ppm(), 50.0, epsilon = 0.1);
    }

    #[test]
    fn impossible_observations_are_refused() {
        let mut clock = LowerEnvelope::new();
        assert_eq!(clock.to_host_s(0.0), None);
        assert_eq!(clock.to_source_s(0.0), None);
        clock.observe(1.0, 5.0).unwrap();
        assert_eq!(
            clock.observe(1.0, 5.1),
            Err(ClockError::NotLater {
                source_s: 1.0,
                last_s: 1.0
            })
        );
        assert!(matches!(
            clock.observe(f64::NAN, 5.1),
            Err(ClockError::NotFinite {
                name: "source_s",
                ..
            })
        ));
        assert_abs_diff_eq!(clock.to_host_s(1.0).unwrap(), 5.0);
    }

    proptest! {
        #[test]
        fn the_inverse_undoes_the_map(seed in 0u64..1000, drift in -1e-4f64..1e-4, at in -10.0f64..100.0) {
            let link = Link { period_s: 0.01, drift, burst_s: 0.016, jitter_s: 1e-3 };
            let mut clock = LowerEnvelope::new();
            link.run(80.0, seed, |source_s, arrival_s| clock.observe(source_s, arrival_s).unwrap());
            let host_s = clock.to_host_s(at).unwrap();
            prop_assert!((clock.to_source_s(host_s).unwrap() - at).abs() < 1e-9);
        }
    }
}
