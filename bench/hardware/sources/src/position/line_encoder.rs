//! An encoder with two signals that are polled as digital lines.

use safety::InputLine;

use super::position_source::{Counted, POSITION_HZ, PositionSource};
use super::quadrature::Quadrature;
use crate::loss::SourceGone;

const PERIOD_NS: u64 = (1e9 / POSITION_HZ) as u64;

/// A quadrature encoder on two lines of this computer. Each poll reads both lines.
pub struct LineEncoder {
    lines: [Box<dyn InputLine>; 2],
    quadrature: Quadrature,
    due_ns: u64,
}

impl LineEncoder {
    /// Creates an encoder from its signals A and B.
    #[must_use]
    pub fn new(lines: [Box<dyn InputLine>; 2]) -> Self {
        Self {
            lines,
            quadrature: Quadrature::default(),
            due_ns: 0,
        }
    }
}

impl PositionSource for LineEncoder {
    fn poll(
        &mut self,
        now_ns: u64,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(Counted),
    ) -> Result<(), SourceGone> {
        let [a, b] = &mut self.lines;
        let count = self.quadrature.read(a.is_high()?, b.is_high()?);
        if now_ns >= self.due_ns {
            self.due_ns = now_ns + PERIOD_NS;
            let host_s = now_s();
            take(Counted {
                host_s,
                source_s: host_s,
                count,
                missed: self.quadrature.skipped(),
                lost: false,
            });
        }
        Ok(())
    }
}
