//! The live panels of an exercise.

use devices::DeviceReadings;
use live::live_meter::LiveMeter;
use recording::pipeline::{Account, Batch};
use tui::Event;

/// Converts acquired batches to events for the dashboard.
pub(crate) struct Panels {
    meter: LiveMeter,
    account: Account,
    rate_hz: u32,
}

impl Panels {
    /// Creates the panels of a bench that samples at `rate_hz`.
    pub fn new(rate_hz: u32) -> Self {
        Self {
            meter: LiveMeter::default(),
            account: Account::default(),
            rate_hz,
        }
    }

    /// Takes an acquired batch.
    pub fn take(&mut self, batch: &Batch) {
        self.account = batch.account;
        self.meter.take(batch);
    }

    /// Returns the events to show at `now_ns`.
    pub fn events(&mut self, now_ns: u64, gauges: &DeviceReadings) -> impl Iterator<Item = Event> {
        let live = self.meter.live(None).map(Event::Live);
        let health = &mut self.meter.health;
        let health = health.read(now_ns, &self.account, gauges, self.rate_hz);
        live.into_iter().chain(health.map(Event::Health))
    }
}
