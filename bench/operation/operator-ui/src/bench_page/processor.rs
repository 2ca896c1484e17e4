//! Processor time of this program.

/// Measures the processor time.
#[derive(Debug, Default)]
pub(crate) struct ProcessorMeter {
    /// Clock and processor time of the last reading, s.
    before: Option<(f64, f64)>,
}

impl ProcessorMeter {
    /// Returns the processor time per second of `now_s` since the last call, in cores; `None` at the first call, and on systems
    /// that do not report it.
    pub(crate) fn cores(&mut self, now_s: f64) -> Option<f64> {
        let used_s = used_s()?;
        let (at_s, before_s) = self.before.replace((now_s, used_s))?;
        (now_s > at_s).then(|| (used_s - before_s) / (now_s - at_s))
    }
}

#[cfg(unix)]
fn used_s() -> Option<f64> {
    use rustix::time::{ClockId, clock_gettime};

    let used = clock_gettime(ClockId::ProcessCPUTime);
    Some(used.tv_sec as f64 + used.tv_nsec as f64 * 1e-9)
}

#[cfg(not(unix))]
fn used_s() -> Option<f64> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time() {
        let mut meter = ProcessorMeter::default();
        assert_eq!(meter.cores(1.0), None);
        let work: f64 = (0..2_000_000).map(|i| f64::from(i).sqrt()).sum();
        assert!(work > 0.0);
        assert!(meter.cores(2.0) > Some(0.0));
        assert_eq!(meter.cores(2.0), None);
    }
}
