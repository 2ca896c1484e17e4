//! Force source for the converter of a field box.

use std::sync::Arc;

use config::BoxForce as BoxForceTable;
use safety::Nonsense;

use super::link::Link;
use crate::correct::Corrector;
use crate::force_source::{ForceSource, Moment, SourceHealth, TimedForce};
use crate::loss::SourceGone;

/// Full-scale count of a 24-bit converter.
const FULL_SCALE: f64 = (1 << 23) as f64;

/// A force sensor on the box's converter.
pub(super) struct BoxForce {
    link: Arc<Link>,
    newtons_per_count: [f64; 2],
    /// Delay of the converter's own filter, s.
    latency_s: f64,
    corrector: Corrector,
    health: SourceHealth,
    nonsense: Nonsense,
}

impl BoxForce {
    pub(super) fn new(
        link: Arc<Link>,
        table: &BoxForceTable,
        latency_s: f64,
        corrector: Corrector,
    ) -> Self {
        Self {
            link,
            newtons_per_count: table
                .newtons_per_full_scale
                .map(|newtons| newtons / FULL_SCALE),
            latency_s,
            corrector,
            health: SourceHealth::default(),
            nonsense: Nonsense::default(),
        }
    }
}

impl ForceSource for BoxForce {
    fn poll(
        &mut self,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(TimedForce),
    ) -> Result<(), SourceGone> {
        let mut reader = self.link.read(now_s)?;
        for dated in reader.forces.take() {
            let report = dated.report;
            let raw_n = [0, 1]
                .map(|axis: usize| f64::from(report.counts[axis]) * self.newtons_per_count[axis]);
            take(self.corrector.force(
                Moment::Host(dated.host_s - self.latency_s),
                raw_n,
                [
                    report.levels.normal_saturated,
                    report.levels.lateral_saturated,
                ],
            ));
        }
        self.health = reader.health();
        self.nonsense = reader.nonsense((now_s() * 1e9) as u64);
        Ok(())
    }

    fn health(&self) -> SourceHealth {
        self.health
    }

    fn nonsense(&mut self, _now_ns: u64) -> Nonsense {
        self.nonsense
    }

    fn off_rate(&self, fast_ppm: f64, card_ppm: f64) -> SourceGone {
        SourceGone::Clock {
            source_name: "field box",
            fast_ppm,
            card_ppm,
        }
    }
}
