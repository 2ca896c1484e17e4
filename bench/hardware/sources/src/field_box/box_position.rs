//! Position source for the encoder of a field box.

use std::sync::Arc;

use super::link::Link;
use crate::force_source::SourceHealth;
use crate::loss::SourceGone;
use crate::position::{Counted, POSITION_HZ, PositionSource};

/// Largest share of a period by which a report may be early, since its rate need not be a multiple of the positions' rate.
const EARLY: f64 = 0.1;

/// An encoder counted by the box.
pub(super) struct BoxPosition {
    link: Arc<Link>,
    last: Option<i32>,
    restarts: u64,
    /// Whether the position is unknown after a restart.
    lost: bool,
    health: SourceHealth,
    count: i64,
    due_s: f64,
}

impl BoxPosition {
    pub(super) fn new(link: Arc<Link>) -> Self {
        Self {
            link,
            last: None,
            restarts: 0,
            lost: false,
            health: SourceHealth::default(),
            count: 0,
            due_s: f64::NEG_INFINITY,
        }
    }
}

impl PositionSource for BoxPosition {
    fn poll(
        &mut self,
        _now_ns: u64,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(Counted),
    ) -> Result<(), SourceGone> {
        let mut reader = self.link.read(now_s)?;
        for dated in reader.positions.take() {
            let counted = dated.report.position;
            // The box has restarted its count, and the carriage may have moved meanwhile.
            let lost = dated.restarts > std::mem::replace(&mut self.restarts, dated.restarts);
            self.last = self.last.filter(|_| !lost);
            let step = counted.wrapping_sub(self.last.replace(counted).unwrap_or(counted));
            self.count += i64::from(step);
            self.lost |= lost;
            if dated.source_s >= self.due_s {
                self.due_s = dated.source_s + (1.0 - EARLY) / POSITION_HZ;
                take(Counted {
                    host_s: dated.host_s,
                    source_s: dated.source_s,
                    count: self.count,
                    // A hardware counter misses no states.
                    missed: 0,
                    lost: self.lost,
                });
            }
        }
        self.health = reader.health();
        Ok(())
    }

    fn health(&self) -> SourceHealth {
        self.health
    }
}
