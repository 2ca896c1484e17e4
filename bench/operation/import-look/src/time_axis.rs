//! Arrays that are times of samples.

use std::ops::RangeInclusive;

/// Times of samples, in units of the array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TimeAxis {
    /// Mean interval.
    pub interval: f64,
    /// Standard deviation of the intervals relative to their mean.
    pub jitter: f64,
}

/// Fewest values of an array of times.
const FEWEST: usize = 8;
/// Largest jitter of a clock; the counts of a steadily moving encoder vary more.
const MOST_JITTER: f64 = 0.5;

/// Returns the mean interval and the jitter of a stretch, if it increases as times do.
pub(crate) fn time_axis(values: &[f64]) -> Option<TimeAxis> {
    if values.len() < FEWEST || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let intervals = || values.windows(2).map(|pair| pair[1] - pair[0]);
    if intervals().any(|interval| interval <= 0.0) {
        return None;
    }
    let count = (values.len() - 1) as f64;
    let interval = (values[values.len() - 1] - values[0]) / count;
    let variance = intervals()
        .map(|step| (step - interval).powi(2))
        .sum::<f64>()
        / count;
    let jitter = variance.sqrt() / interval;
    (jitter < MOST_JITTER).then_some(TimeAxis { interval, jitter })
}

/// Unit of an array of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TimeUnit {
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
    /// Minutes, only where they are stated.
    Minutes,
    /// Numbers of samples.
    Samples,
}

impl TimeUnit {
    /// Units of times that state none.
    pub const ALL: [Self; 4] = [
        Self::Seconds,
        Self::Milliseconds,
        Self::Microseconds,
        Self::Nanoseconds,
    ];

    /// Returns the unit in seconds; `None` for numbers of samples.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::Seconds => Some(1.0),
            Self::Milliseconds => Some(1e-3),
            Self::Microseconds => Some(1e-6),
            Self::Nanoseconds => Some(1e-9),
            Self::Minutes => Some(60.0),
            Self::Samples => None,
        }
    }

    /// Returns the symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Seconds => "s",
            Self::Milliseconds => "ms",
            Self::Microseconds => "µs",
            Self::Nanoseconds => "ns",
            Self::Minutes => "min",
            Self::Samples => "samples",
        }
    }

    /// Returns the unit that a text states.
    pub fn parse(text: &str) -> Option<Self> {
        match text.trim().to_lowercase().as_str() {
            "s" | "sec" | "secs" | "second" | "seconds" => Some(Self::Seconds),
            "ms" | "msec" | "millisecond" | "milliseconds" => Some(Self::Milliseconds),
            "us" | "µs" | "μs" | "usec" | "microsecond" | "microseconds" => {
                Some(Self::Microseconds)
            }
            "ns" | "nsec" | "nanosecond" | "nanoseconds" => Some(Self::Nanoseconds),
            "min" | "mins" | "minute" | "minutes" => Some(Self::Minutes),
            _ => None,
        }
    }
}

/// Intervals and durations of recordings, s: 20 Hz to 2 MHz, 0.5 s to 2 h.
const INTERVALS_S: RangeInclusive<f64> = 5e-7..=0.05;
const DURATIONS_S: RangeInclusive<f64> = 0.5..=7200.0;

impl TimeAxis {
    /// Returns whether times in this unit are those of a recording.
    pub fn is_plausible(&self, unit: TimeUnit, length: u64) -> bool {
        let interval_s = self.interval * unit.seconds().unwrap_or(f64::NAN);
        INTERVALS_S.contains(&interval_s) && DURATIONS_S.contains(&(interval_s * length as f64))
    }

    /// Returns whether the values count up by one.
    pub fn is_count(&self) -> bool {
        (self.interval - 1.0).abs() < 1e-9 && self.jitter < 1e-9
    }

    /// Returns the most plausible unit of times without a stated one, and whether no other is plausible.
    pub fn likely_unit(&self, length: u64) -> (TimeUnit, bool) {
        if self.is_count() {
            return (TimeUnit::Samples, false);
        }
        let is_plausible = |unit: &TimeUnit| self.is_plausible(*unit, length);
        let mut plausible = TimeUnit::ALL.into_iter().filter(is_plausible);
        match (plausible.next(), plausible.next()) {
            (Some(unit), None) => (unit, true),
            (Some(unit), Some(_)) => (unit, false),
            (None, _) => (TimeUnit::Seconds, false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_an_interval_and_a_jitter() {
        let steady: Vec<f64> = (0..1_000).map(|n| 5.0 + 1e-4 * f64::from(n)).collect();
        let found = time_axis(&steady).unwrap();
        assert!(
            (found.interval - 1e-4).abs() < 1e-12 && found.jitter < 1e-6,
            "{found:?}"
        );
        assert_eq!(found.likely_unit(100_000), (TimeUnit::Seconds, true));
        let jittery: Vec<f64> = (0..1_000)
            .map(|n| f64::from(n) + 0.05 * f64::from(n * 37 % 11))
            .collect();
        let found = time_axis(&jittery).unwrap();
        assert!((0.1..0.5).contains(&found.jitter), "{found:?}");
    }

    #[test]
    fn the_unit_is_the_plausible_one() {
        let axis = |interval| TimeAxis {
            interval,
            jitter: 0.0,
        };
        assert_eq!(
            axis(0.1).likely_unit(100_000),
            (TimeUnit::Milliseconds, true)
        );
        assert_eq!(
            axis(5.0).likely_unit(2_000_000),
            (TimeUnit::Microseconds, true)
        );
        assert_eq!(axis(1.0).likely_unit(1_000).0, TimeUnit::Samples);
        assert_eq!(axis(0.005).likely_unit(40_000).0, TimeUnit::Seconds);
    }

    #[test]
    fn positions_and_repeated_times_are_no_times() {
        assert_eq!(
            time_axis(&[0.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
            None
        );
        let slide: Vec<f64> = (0..1_000).map(|n| (0.002 * f64::from(n)).sin()).collect();
        assert_eq!(time_axis(&slide), None);
        assert_eq!(time_axis(&[1.0]), None);
    }
}
