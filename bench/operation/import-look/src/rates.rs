//! Rates of vectors, from what a file states: its own rate, scalars, arrays of times.

use crate::names::{self, RateWord};
use crate::portrait::{RateOrigin, StatedRate};
use crate::time_axis::TimeUnit;

/// A scalar that states a rate or an interval.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RateScalar {
    pub name: String,
    pub word: RateWord,
    pub hz: f64,
}

impl RateScalar {
    /// Returns the rate that a scalar states, if its name and its value are those of one.
    pub fn new(name: &str, value: f64) -> Option<Self> {
        let word = names::rate_word(name)?;
        let hz = match word {
            RateWord::Rate => value,
            RateWord::Interval => 1.0 / value,
        };
        (0.1..=1e8).contains(&hz).then(|| Self {
            name: name.to_owned(),
            word,
            hz,
        })
    }
}

/// An array of times, without its values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Times {
    pub name: String,
    pub length: u64,
    pub rate_hz: f64,
    pub unit: TimeUnit,
}

/// Rates that a file states.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rates {
    pub file_hz: Option<f64>,
    pub scalars: Vec<RateScalar>,
    pub times: Vec<Times>,
}

/// Difference of durations that are the same.
const SAME_DURATION: f64 = 0.02;

impl Rates {
    /// Returns the rate of a vector; `lengths` are those of all vectors that may be signals.
    pub fn rate(
        &self,
        name: &str,
        length: u64,
        own_hz: Option<f64>,
        lengths: &[u64],
    ) -> Option<StatedRate> {
        if let Some(hz) = own_hz.or(self.file_hz) {
            return Some(StatedRate {
                hz,
                origin: RateOrigin::File,
            });
        }
        if let Some(times) = self.times(name, length) {
            let origin = RateOrigin::Times(times.name.clone(), times.unit);
            return Some(StatedRate {
                hz: times.rate_hz,
                origin,
            });
        }
        self.scalar(name, length, lengths)
            .or_else(|| self.by_duration(length, lengths))
    }

    /// Returns the array of times of the vector's length, the one of its group first.
    fn times(&self, name: &str, length: u64) -> Option<&Times> {
        let same = self.times.iter().filter(|times| times.length == length);
        same.max_by_key(|times| common_prefix(&times.name, name))
    }

    /// Returns the scalar with the rate of the vector: of its group, or the one with which all vectors last as long.
    fn scalar(&self, name: &str, length: u64, lengths: &[u64]) -> Option<StatedRate> {
        let duration = self.duration_s(lengths)?;
        let is_fitting = |scalar: &&RateScalar| {
            (length as f64 / scalar.hz / duration - 1.0).abs() < SAME_DURATION
        };
        let best = self
            .scalars
            .iter()
            .filter(is_fitting)
            .max_by_key(|scalar| common_prefix(&scalar.name, name))?;
        let origin = RateOrigin::Scalar(best.name.clone(), best.word);
        Some(StatedRate {
            hz: best.hz,
            origin,
        })
    }

    /// Returns the rate with which the vector lasts as long as the others.
    fn by_duration(&self, length: u64, lengths: &[u64]) -> Option<StatedRate> {
        let duration = self.duration_s(lengths).or_else(|| {
            let times = self.times.iter().max_by_key(|times| times.length)?;
            Some(times.length as f64 / times.rate_hz)
        })?;
        let hz = length as f64 / duration;
        // Rates of instruments are round.
        let unit = 10_f64.powi(hz.log10().floor() as i32 - 1);
        let round = (hz / unit).round() * unit;
        let hz = if (hz / round - 1.0).abs() < SAME_DURATION {
            round
        } else {
            hz
        };
        (hz.is_finite() && length > 16).then_some(StatedRate {
            hz,
            origin: RateOrigin::Duration,
        })
    }

    /// Returns the duration that most vectors have with the stated rates; the longest vector has the highest rate.
    fn duration_s(&self, lengths: &[u64]) -> Option<f64> {
        let longest = *lengths.iter().max()?;
        let candidates = self.scalars.iter().map(|scalar| longest as f64 / scalar.hz);
        let support = |duration: f64| {
            let has_rate = |length: &&u64| {
                let hz = **length as f64 / duration;
                self.scalars
                    .iter()
                    .any(|scalar| (hz / scalar.hz - 1.0).abs() < SAME_DURATION)
            };
            lengths.iter().filter(has_rate).count()
        };
        // The highest rate of equal support is the first.
        let mut best: Option<(usize, f64)> = None;
        let mut sorted: Vec<f64> = candidates.collect();
        sorted.sort_by(f64::total_cmp);
        for duration in sorted {
            let count = support(duration);
            if best.is_none_or(|(most, _)| count > most) {
                best = Some((count, duration));
            }
        }
        best.map(|(_, duration)| duration)
    }
}

/// Returns the number of characters that two names share: at their start, as `S.force.` of `S.force.fs`, or of their words.
fn common_prefix(a: &str, b: &str) -> usize {
    let start = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
    let other = names::words(b);
    let shared: usize = names::words(a)
        .iter()
        .filter(|word| other.contains(word))
        .map(String::len)
        .sum();
    start + shared
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalars(list: &[(&str, f64)]) -> Rates {
        let scalars = list
            .iter()
            .filter_map(|(name, value)| RateScalar::new(name, *value))
            .collect();
        Rates {
            scalars,
            ..Rates::default()
        }
    }

    #[test]
    fn the_scalars_are_those_with_which_all_last_as_long() {
        let rates = scalars(&[("fs_force", 10e3), ("fs", 200e3), ("mass", 8e-3)]);
        let lengths = [1_000_000, 1_000_000, 50_000, 50_000];
        let audio = rates.rate("out", 1_000_000, None, &lengths).unwrap();
        assert_eq!(
            (audio.hz, audio.origin),
            (200e3, RateOrigin::Scalar("fs".to_owned(), RateWord::Rate))
        );
        let force = rates.rate("F", 50_000, None, &lengths).unwrap();
        assert_eq!(force.hz, 10e3);
    }

    #[test]
    fn an_interval_is_a_rate_and_a_duration_another() {
        let rates = scalars(&[("dt", 5e-6)]);
        let lengths = [1_000_000, 50_100];
        assert!((rates.rate("out", 1_000_000, None, &lengths).unwrap().hz - 200e3).abs() < 1e-6);
        let force = rates.rate("F", 50_100, None, &lengths).unwrap();
        assert_eq!((force.hz, force.origin), (10e3, RateOrigin::Duration));
        assert_eq!(scalars(&[]).rate("F", 50_000, None, &lengths), None);
    }

    #[test]
    fn times_precede_scalars_and_the_file_precedes_both() {
        let mut rates = scalars(&[("fs", 1e3)]);
        rates.times.push(Times {
            name: "t".to_owned(),
            length: 500,
            rate_hz: 100.0,
            unit: TimeUnit::Seconds,
        });
        assert_eq!(rates.rate("x", 500, None, &[500, 5_000]).unwrap().hz, 100.0);
        rates.file_hz = Some(48e3);
        assert_eq!(
            rates.rate("x", 500, None, &[500]).unwrap(),
            StatedRate {
                hz: 48e3,
                origin: RateOrigin::File
            }
        );
    }
}
