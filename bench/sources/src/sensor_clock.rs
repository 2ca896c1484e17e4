//! A sensor's own clock on the host's.

use impedance::clock_alignment::LowerEnvelope;

/// The clock of a sensor that stamps its readings.
#[derive(Debug)]
pub(crate) struct SensorClock {
    map: LowerEnvelope,
    /// Shortest time from sampling to arrival, s.
    latency_s: f64,
}

impl SensorClock {
    pub(crate) fn new(latency_s: f64) -> Self {
        Self {
            map: LowerEnvelope::default(),
            latency_s,
        }
    }

    /// Notes that the newest reading of a burst, which has waited least, arrived at `arrival_s` on the host's clock.
    pub(crate) fn arrived(&mut self, device_s: f64, arrival_s: f64) {
        // The decoders let only advancing times pass.
        let _ = self.map.observe(device_s, arrival_s);
    }

    /// Returns when a reading was sampled, on the host's clock, s; `None` before the first arrival.
    pub(crate) fn host_s(&self, device_s: f64) -> Option<f64> {
        Some(self.map.to_host_s(device_s)? - self.latency_s)
    }

    /// Returns the drift of the host's clock against the sensor's, ppm; `None` until it is known.
    pub(crate) fn drift_ppm(&self) -> Option<f64> {
        self.map.settled().then(|| self.map.drift_ppm())
    }
}
