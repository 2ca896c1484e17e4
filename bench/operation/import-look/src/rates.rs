//! Rates of vectors, as a file states them: its own rate, scalars, arrays of times.

use crate::name_parts;
use crate::names::{self, RateWord};
use crate::portrait::{RateOrigin, StatedRate, StreamStart, TimesOrigin};
use crate::siblings;
use crate::time_units::TimesUnit;
use crate::units;

/// A scalar that states a rate or an interval.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RateScalar {
    pub name: String,
    pub word: RateWord,
    pub hz: f64,
    /// Part of its name beside the word, as `x` of `fsx`; empty without one.
    stream: String,
    /// Length of the array that it is an attribute of.
    own_length: Option<u64>,
}

impl RateScalar {
    /// Returns the rate that a scalar states, if its name and its value are those of one; `vectors` are the names and
    /// lengths of all arrays.
    pub fn new(name: &str, value: f64, vectors: &[(&str, u64)]) -> Option<Self> {
        let (word, stream) = match names::rate_word(name) {
            Some(word) => (word, names::beside_rate_word(name)),
            None => vectors
                .iter()
                .find_map(|(vector, _)| joined_stream(name, vector))?,
        };
        let vector = vectors
            .iter()
            .find(|(vector, _)| name.contains('@') && container(name) == array_of(vector));
        let hz = match word {
            RateWord::Rate => value,
            RateWord::Interval => 1.0 / value,
        };
        (0.1..=1e8).contains(&hz).then(|| Self {
            name: name.to_owned(),
            word,
            hz,
            stream,
            own_length: vector.map(|(_, length)| *length),
        })
    }
}

/// Returns the meaning of a name as `fsx` or `xfs`, the word of a rate next to the name of a vector, and that name.
fn joined_stream(name: &str, vector: &str) -> Option<(RateWord, String)> {
    let joined: String = name_parts::words(&name_parts::leaf(name)).concat();
    let streams = stream_words(vector);
    [
        ("fs", RateWord::Rate),
        ("sr", RateWord::Rate),
        ("dt", RateWord::Interval),
    ]
    .into_iter()
    .find_map(|(part, word)| {
        let rest = joined
            .strip_prefix(part)
            .or_else(|| joined.strip_suffix(part))?;
        streams
            .iter()
            .any(|stream| stream == rest)
            .then(|| (word, rest.to_owned()))
    })
}

/// Returns the words by which a scalar may name a vector: its name without the unit, and its groups.
fn stream_words(vector: &str) -> Vec<String> {
    let stem = name_parts::words(&units::without_unit(&name_parts::leaf(vector))).concat();
    let mut words: Vec<String> = std::iter::once(stem).collect();
    words.extend(
        container(vector)
            .split(['/', '.', '@'])
            .map(|group| name_parts::words(group).concat()),
    );
    words.retain(|word| !word.is_empty());
    words
}

/// Returns the array of a vector, in the form of a group.
fn array_of(vector: &str) -> String {
    let array = vector.trim_start_matches('/').split('[').next();
    array.unwrap_or_default().replace('.', "/")
}

/// Returns the group of a name: of `S.force.fs`, `/force/Fn` and `/force@fs` that is `force` in its group.
fn container(name: &str) -> String {
    let name = name.trim_start_matches('/');
    let name = name.split_once('[').map_or(name, |(stem, _)| stem);
    match name.rfind(['/', '.', '@']) {
        Some(end) => name[..end].replace('.', "/"),
        None => String::new(),
    }
}

/// An array of times, without its values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Times {
    pub name: String,
    pub length: u64,
    /// Factor that attributes state.
    pub factor: f64,
    pub rate_hz: f64,
    pub unit: TimesUnit,
    pub start: StreamStart,
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
/// Ratio of durations of streams that were started and stopped apart.
const LIKE_DURATION: f64 = 1.6;

impl Rates {
    /// Returns the rates that are not of another recording in the file than a vector.
    pub fn within_recording(&self, vector: &str) -> Self {
        let mut rates = self.clone();
        rates
            .scalars
            .retain(|scalar| !siblings::are_apart(vector, &scalar.name));
        rates
            .times
            .retain(|times| !siblings::are_apart(vector, &times.name));
        rates
    }

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
            let origin = RateOrigin::Times(TimesOrigin {
                name: times.name.clone(),
                factor: times.factor,
                unit: times.unit.clone(),
                start: times.start,
            });
            return Some(StatedRate {
                hz: times.rate_hz,
                origin,
            });
        }
        self.named(name, length, lengths)
            .or_else(|| self.scalar(name, length, lengths))
            .or_else(|| self.by_duration(length, lengths))
    }

    /// Returns the unit of an array of times.
    pub fn times_unit(&self, name: &str) -> Option<TimesUnit> {
        let times = self.times.iter().find(|times| times.name == name)?;
        Some(times.unit.clone())
    }

    /// Returns the array of times of the vector's length, the one of its group first.
    fn times(&self, name: &str, length: u64) -> Option<&Times> {
        let fitting = self.times.iter().filter(|times| times.length == length);
        fitting.max_by_key(|times| common_prefix(&times.name, name))
    }

    /// Returns the only scalar in the vector's group, or the one that names the vector, if it lasts about as long as
    /// the others.
    fn named(&self, name: &str, length: u64, lengths: &[u64]) -> Option<StatedRate> {
        let duration = self.duration_s(lengths);
        let is_like = |scalar: &&RateScalar| {
            duration.is_none_or(|duration| {
                let ratio = length as f64 / scalar.hz / duration;
                (1.0 / LIKE_DURATION..=LIKE_DURATION).contains(&ratio)
            })
        };
        let streams = stream_words(name);
        let by_name = self.scalars.iter().filter(is_like).find(|scalar| {
            streams.contains(&scalar.stream) && !is_in_other_group(&scalar.name, name)
        });
        // An attribute of the array itself, or a scalar of its group.
        let in_group = |group: &str| {
            let mut inner = self
                .scalars
                .iter()
                .filter(|scalar| !group.is_empty() && container(&scalar.name) == group);
            let only = inner.next()?;
            inner.next().is_none().then_some(only)
        };
        let scalars = in_group(&array_of(name));
        let found = scalars
            .or(by_name)
            .or_else(|| in_group(&container(name)).filter(is_like))?;
        let origin = RateOrigin::Scalar(found.name.clone(), found.word);
        Some(StatedRate {
            hz: found.hz,
            origin,
        })
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
        let candidates = self
            .scalars
            .iter()
            .map(|scalar| scalar.own_length.unwrap_or(longest) as f64 / scalar.hz);
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

/// Returns whether a scalar lies in a group that the vector is not in.
fn is_in_other_group(scalar: &str, vector: &str) -> bool {
    let (group, vector) = (container(scalar), container(vector));
    !(group.is_empty() || vector == group || vector.starts_with(&format!("{group}/")))
}

/// Returns the number of characters that two names share: at their start, as `S.force.` of `S.force.fs`, or of their
/// words.
fn common_prefix(a: &str, b: &str) -> usize {
    let start = a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count();
    let other = name_parts::words(b);
    let shared: usize = name_parts::words(a)
        .iter()
        .filter(|word| other.contains(word))
        .map(String::len)
        .sum();
    start + shared
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time_axis::TimeUnit;

    fn rates(list: &[(&str, f64)], vectors: &[(&str, u64)]) -> Rates {
        let scalars = list
            .iter()
            .filter_map(|(name, value)| RateScalar::new(name, *value, vectors))
            .collect();
        Rates {
            scalars,
            ..Rates::default()
        }
    }

    fn scalars(list: &[(&str, f64)]) -> Rates {
        rates(list, &[])
    }

    #[test]
    fn scalars_name_their_stream_in_one_word_or_by_their_group() {
        // The streams were stopped apart, so that no duration fits.
        let vectors = [
            ("a", 2_000_000),
            ("b", 2_000_000),
            ("z_mm", 19_000),
            ("enc", 5_200),
            ("v", 1_040),
        ];
        let list = [("fs", 2e5), ("fsz", 2e3), ("enc_fs", 500.0), ("dtv", 0.01)];
        let named = rates(&list, &vectors);
        let lengths = vectors.map(|(_, length)| length);
        for (name, length, hz, scalar) in [
            ("z_mm", 19_000, 2e3, "fsz"),
            ("enc", 5_200, 500.0, "enc_fs"),
            ("v", 1_040, 100.0, "dtv"),
        ] {
            let found = named.rate(name, length, None, &lengths).unwrap();
            assert!((found.hz - hz).abs() < 1e-6, "{found:?}");
            assert!(
                matches!(&found.origin, RateOrigin::Scalar(name, _) if name == scalar),
                "{found:?}"
            );
        }
        let list = [
            ("Fast/Fs", 156_250.0),
            ("/slow@Fs", 500.0),
            ("/cam/x@rate", 50.0),
        ];
        let vectors = [
            ("Fast/raw[:,0]", 1_562_500),
            ("slow/Fn", 4_600),
            ("cam/x", 480),
        ];
        let grouped = rates(&list, &vectors);
        for ((name, length), (_, hz)) in vectors.into_iter().zip(list) {
            let found = grouped.rate(name, length, None, &vectors.map(|(_, length)| length));
            assert_eq!(found.unwrap().hz, hz, "{name}");
        }
        // An attribute of a short array states the duration by that array.
        let vectors = [("u", 500_000), ("w", 500_000), ("f", 5_000)];
        let rates_of_arrays = rates(&[("/f@rate", 1e3)], &vectors);
        assert_eq!(
            rates_of_arrays
                .rate("u", 500_000, None, &vectors.map(|(_, length)| length))
                .unwrap()
                .hz,
            1e5
        );
        // A rate with which its group would last ten times as long is not its own.
        let shared = scalars(&[("daq/Fs", 1e5)]);
        let force = shared
            .rate("daq/F", 50_000, None, &[500_000, 50_000])
            .unwrap();
        assert_eq!((force.hz, force.origin), (1e4, RateOrigin::Duration));
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
            factor: 1.0,
            rate_hz: 100.0,
            unit: TimesUnit {
                unit: TimeUnit::Seconds,
                is_sure: true,
                reason: String::new(),
            },
            start: StreamStart {
                begin_s: 0.0,
                is_of_day: false,
            },
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
