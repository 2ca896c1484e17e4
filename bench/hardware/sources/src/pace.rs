//! Rate of a device's clock that is far from its nominal one: another unit of its counts, or another processor clock.

use std::collections::VecDeque;

/// Length of a window on the host's clock, s.
const WINDOW_S: f64 = 0.15;
/// Number of consecutive windows that must agree.
const WINDOWS: usize = 4;
/// Largest ratio of the rates of agreeing windows.
const AGREEMENT: f64 = 1.2;
/// Rates of a device's clock within which its alignment judges it, in time.
const USUAL: [f64; 2] = [0.6, 1.6];

/// Advance of a device's 32-bit counter, summed over its wraps; steps back, as after a reset, count as none.
#[derive(Debug, Default)]
pub(crate) struct RawCount {
    last: Option<u32>,
    advanced: u64,
}

impl RawCount {
    /// Records the counter of a reading.
    pub(crate) fn take(&mut self, counter: u32) {
        let step = counter.wrapping_sub(self.last.unwrap_or(counter));
        self.last = Some(counter);
        if step.cast_signed() > 0 {
            self.advanced += u64::from(step);
        }
    }

    /// Returns the sum of its steps.
    pub(crate) fn advanced(&self) -> u64 {
        self.advanced
    }
}

/// Rate of a device's clock over the host's, in consecutive windows.
#[derive(Debug, Default)]
pub(crate) struct PaceMeter {
    /// Device and host time at the start of the open window, s.
    began_s: Option<(f64, f64)>,
    ratios: VecDeque<f64>,
}

impl PaceMeter {
    /// Records that a device had advanced by `device_s` when its latest reading arrived at `host_s`. Where a poll has not
    /// `emptied` the buffer, older readings are still in it, and arrivals say nothing about the clock.
    pub(crate) fn take(&mut self, device_s: f64, host_s: f64, emptied: bool) {
        if !emptied {
            *self = Self::default();
            return;
        }
        let (from_device_s, from_host_s) = *self.began_s.get_or_insert((device_s, host_s));
        if host_s - from_host_s < WINDOW_S {
            return;
        }
        self.began_s = Some((device_s, host_s));
        if self.ratios.len() == WINDOWS {
            self.ratios.pop_front();
        }
        self.ratios
            .push_back((device_s - from_device_s) / (host_s - from_host_s));
    }

    /// Returns the rate of the device's clock over the host's if it surely differs by more than the alignment can follow.
    pub(crate) fn pace(&self) -> Option<f64> {
        let slowest = self.ratios.iter().copied().fold(f64::INFINITY, f64::min);
        let fastest = self.ratios.iter().copied().fold(0.0, f64::max);
        let agree = self.ratios.len() == WINDOWS && slowest > 0.0 && fastest / slowest < AGREEMENT;
        let [least, most] = USUAL;
        (agree && (fastest < least || slowest > most)).then(|| {
            let sum: f64 = self.ratios.iter().sum();
            sum / WINDOWS as f64
        })
    }
}

/// Returns the probable cause of a clock that runs at `pace` times its nominal rate.
#[must_use]
pub fn clock_cause(pace: f64) -> Option<&'static str> {
    let causes = [
        (
            1e-3,
            "it sends milliseconds where microseconds are expected: millis() for micros()?",
        ),
        (1e-6, "it sends seconds where microseconds are expected"),
        (1e3, "it sends nanoseconds where microseconds are expected"),
        (0.5, "its program was built for twice its processor's clock"),
        (2.0, "its program was built for half its processor's clock"),
    ];
    let mut causes = causes.into_iter();
    let cause = causes.find(|(rate, _)| (pace / rate).ln().abs() < 0.15);
    cause.map(|(_, cause)| cause)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the pace after `seconds` of bursts of 16 ms from a clock with this rate.
    fn pace_of(rate: f64, seconds: f64) -> Option<f64> {
        let mut meter = PaceMeter::default();
        for burst in 1..(seconds / 0.016) as u32 {
            let host_s = 5.0 + 0.016 * f64::from(burst) + 1e-3 * f64::from(burst % 3);
            meter.take(rate * 0.016 * f64::from(burst), host_s, true);
        }
        meter.pace()
    }

    #[test]
    fn a_clock_in_another_unit_is_recognised_within_a_second() {
        for (rate, words) in [
            (1e-3, "millis()"),
            (1e3, "nanoseconds"),
            (2.0, "half its"),
            (0.5, "twice its"),
        ] {
            let pace = pace_of(rate, 0.8).unwrap();
            assert!((pace / rate - 1.0).abs() < 0.05, "{rate}: {pace}");
            assert!(
                clock_cause(pace).is_some_and(|cause| cause.contains(words)),
                "{rate}"
            );
        }
        assert_eq!(clock_cause(0.1), None);
        for rate in [1.0, 0.98, 1.05, 0.7] {
            assert_eq!(pace_of(rate, 3.0), None, "{rate}");
        }
        assert_eq!(pace_of(1e-3, 0.3), None, "too early");
    }

    #[test]
    fn queued_readings_and_silences_are_no_pace() {
        let mut meter = PaceMeter::default();
        for poll in 0..40 {
            let now_s = 0.016 * f64::from(poll);
            meter.take(60.0 * now_s, now_s, false);
            assert_eq!(meter.pace(), None);
        }
        let mut meter = PaceMeter::default();
        for at_s in [0.0, 0.1, 4.0, 4.1, 4.3, 9.0, 9.2, 9.4] {
            meter.take(at_s, at_s, true);
            assert_eq!(meter.pace(), None, "{at_s}");
        }
    }

    #[test]
    fn a_counter_that_wraps_advances_and_one_that_begins_anew_does_not() {
        let mut count = RawCount::default();
        for counter in [u32::MAX - 9, 10, 30] {
            count.take(counter);
        }
        assert_eq!(count.advanced(), 40);
        count.take(5);
        count.take(15);
        assert_eq!(count.advanced(), 50);
    }
}
