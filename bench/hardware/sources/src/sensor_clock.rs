//! Alignment of a sensor's clock with the host's.

use impedance::clock_alignment::{ClockState, LowerEnvelope};

use crate::device_time::{ExpectedCount, RESTARTED_S};

/// Clock of a sensor that timestamps its readings.
#[derive(Debug)]
pub(crate) struct SensorClock {
    map: LowerEnvelope,
    /// Counts of the sensor's clock per second.
    counts_per_s: f64,
    /// Shortest time from sampling to arrival, s.
    latency_s: f64,
    /// Time of the previous poll, s.
    previous_s: Option<f64>,
}

impl SensorClock {
    pub(crate) fn new(latency_s: f64, counts_per_s: f64) -> Self {
        Self {
            map: LowerEnvelope::default(),
            counts_per_s,
            latency_s,
            previous_s: None,
        }
    }

    /// Records a poll at `now_s` on the host's clock; returns the expected count of the readings that have arrived.
    pub(crate) fn look(&mut self, now_s: f64) -> Option<ExpectedCount> {
        let previous_s = self.previous_s.replace(now_s).unwrap_or(now_s);
        let unread_s = now_s - previous_s;
        Some(ExpectedCount {
            count: self.map.expected_s(now_s)? * self.counts_per_s,
            ahead: RESTARTED_S * self.counts_per_s,
            behind: (RESTARTED_S + unread_s) * self.counts_per_s,
        })
    }

    /// Discards the alignment after a restart of the sensor.
    pub(crate) fn restart(&mut self) {
        self.map = LowerEnvelope::default();
    }

    /// Records that the newest reading of a burst, which has waited least, arrived at `arrival_s` on the host's clock.
    pub(crate) fn arrived(&mut self, count: u64, arrival_s: f64) {
        let device_s = self.device_s(count);
        let observed = self.map.observe(device_s, arrival_s);
        // Counts increase by whole steps, and the host's clock is finite.
        debug_assert!(observed.is_ok(), "{observed:?}");
    }

    /// Returns the sampling time of a reading on the host's clock, s; `None` before the first arrival.
    pub(crate) fn host_s(&self, count: u64) -> Option<f64> {
        Some(self.map.to_host_s(self.device_s(count))? - self.latency_s)
    }

    /// Converts a count to seconds of the sensor's clock.
    pub(crate) fn device_s(&self, count: u64) -> f64 {
        count as f64 / self.counts_per_s
    }

    /// Returns the state of the alignment.
    pub(crate) fn state(&self) -> ClockState {
        self.map.state()
    }
}
