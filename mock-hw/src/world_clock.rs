//! Simulated time and its pace.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Highest sample rate of the sound cards, Hz; periods are counted in its frames.
pub const BASE_RATE_HZ: u32 = 192_000;

/// Pace of the simulated world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorldPace {
    /// A thread of the apparatus keeps the simulation in step with the machine's monotonic clock.
    RealTime,
    /// Time advances only in `Apparatus::step`; the same seed and the same calls give bit-identical results.
    Stepped,
}

/// Delays of a real-time simulation against the machine's clock.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lateness {
    /// Number of steps that ended more than 5 ms after they were due.
    pub late_steps: u64,
    /// Greatest delay between a step's due time and its end, ns.
    pub worst_ns: u64,
}

/// Delay from which a step counts as late.
const LATENESS_LIMIT: Duration = Duration::from_millis(5);

/// Duration of one frame at 1 µHz, ns.
const FRAME: u128 = 1_000_000_000_000_000;

/// Simulated time, counted in periods so that no rounding errors accumulate.
#[derive(Debug)]
pub(crate) struct WorldClock {
    period_frames: u32,
    /// True value of [`BASE_RATE_HZ`], µHz, including the error of the sample clock.
    base_rate_uhz: u128,
    steps: AtomicU64,
    /// Machine time of simulated time 0; `None` if the simulation is stepped.
    epoch: Option<Instant>,
    late_steps: AtomicU64,
    worst_ns: AtomicU64,
}

impl WorldClock {
    /// Starts a clock with a sample clock that is fast by `clock_ppm`.
    pub(crate) fn new(pace: WorldPace, period_frames: u32, clock_ppm: f64) -> Self {
        let base_rate_hz = f64::from(BASE_RATE_HZ) * (1.0 + 1e-6 * clock_ppm);
        Self {
            period_frames,
            base_rate_uhz: (1e6 * base_rate_hz).round() as u128,
            steps: AtomicU64::new(0),
            epoch: (pace == WorldPace::RealTime).then(Instant::now),
            late_steps: AtomicU64::new(0),
            worst_ns: AtomicU64::new(0),
        }
    }

    /// Returns the pace of the simulation.
    pub(crate) fn pace(&self) -> WorldPace {
        match self.epoch {
            Some(_) => WorldPace::RealTime,
            None => WorldPace::Stepped,
        }
    }

    /// Returns the number of frames of a stream at `rate_hz` in one period.
    pub(crate) fn period_frames_at(&self, rate_hz: u32) -> usize {
        (u64::from(self.period_frames) * u64::from(rate_hz) / u64::from(BASE_RATE_HZ)) as usize
    }

    /// Returns the length of a period, s.
    pub(crate) fn period_s(&self) -> f64 {
        1e6 * f64::from(self.period_frames) / self.base_rate_uhz as f64
    }

    /// Returns the time up to which the world has been simulated, ns.
    pub(crate) fn simulated_ns(&self) -> u64 {
        self.ns_of(self.steps.load(Ordering::Acquire))
    }

    /// Returns the simulated time, ns: from the machine's clock in real time, otherwise the end of the last step.
    pub(crate) fn now_ns(&self) -> u64 {
        match self.epoch {
            Some(epoch) => epoch.elapsed().as_nanos() as u64,
            None => self.simulated_ns(),
        }
    }

    /// Returns the start of step number `step`, ns.
    pub(crate) fn ns_of(&self, step: u64) -> u64 {
        (u128::from(step) * u128::from(self.period_frames) * FRAME / self.base_rate_uhz) as u64
    }

    /// Returns the number of the step that covers `ns`.
    pub(crate) fn step_at(&self, ns: u64) -> u64 {
        (u128::from(ns) * self.base_rate_uhz / (u128::from(self.period_frames) * FRAME)) as u64
    }

    /// Marks one more period as simulated.
    pub(crate) fn advance(&self) {
        self.steps.fetch_add(1, Ordering::AcqRel);
        if let Some(epoch) = self.epoch {
            let lateness = epoch
                .elapsed()
                .saturating_sub(Duration::from_nanos(self.simulated_ns()));
            self.worst_ns
                .fetch_max(lateness.as_nanos() as u64, Ordering::Relaxed);
            if lateness > LATENESS_LIMIT {
                self.late_steps.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    /// Returns the time that a real-time simulation may sleep before its next period is complete.
    pub(crate) fn until_due(&self) -> Duration {
        let due_time = Duration::from_nanos(self.ns_of(self.steps.load(Ordering::Acquire) + 1));
        match self.epoch {
            Some(epoch) => due_time.saturating_sub(epoch.elapsed()),
            None => Duration::ZERO,
        }
    }

    /// Returns the delays against real time.
    pub(crate) fn lateness(&self) -> Lateness {
        Lateness {
            late_steps: self.late_steps.load(Ordering::Relaxed),
            worst_ns: self.worst_ns.load(Ordering::Relaxed),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stepped_clock_counts_whole_periods_without_drift() {
        let clock = WorldClock::new(WorldPace::Stepped, 64, 0.0);
        for _ in 0..3_000 {
            clock.advance();
        }
        assert_eq!(clock.now_ns(), 1_000_000_000);
        assert_eq!(clock.period_frames_at(96_000), 32);
        assert_eq!(clock.period_frames_at(48_000), 16);
    }

    #[test]
    fn a_fast_sample_clock_has_shorter_periods() {
        let clock = WorldClock::new(WorldPace::Stepped, 64, 100.0);
        assert_eq!(clock.ns_of(30_003), 10_000_000_000);
        assert!((clock.period_s() * 3_000.3 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn step_number_and_time_agree() {
        let clock = WorldClock::new(WorldPace::Stepped, 64, 0.0);
        for step in [0, 1, 2, 3, 2_999, 3_000, 1_800_000] {
            // The start of a step is rounded down to whole nanoseconds, so the next nanosecond is inside it.
            assert_eq!(clock.step_at(clock.ns_of(step) + 1), step);
        }
    }
}
