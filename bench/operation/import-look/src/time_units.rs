//! Units of arrays of times, by the signals that were sampled at them.

use std::ops::RangeInclusive;

use crate::carrier::PLATES_HZ;
use crate::nature::grouped;
use crate::time_axis::{TimeAxis, TimeUnit};

/// Array of times, and the signals with as many values.
#[derive(Debug, Clone)]
pub(crate) struct SampledTimes {
    pub name: String,
    pub axis: TimeAxis,
    pub length: u64,
    /// Factor that attributes state, with which all values here are multiplied.
    pub factor: f64,
    /// First and last value.
    pub first: f64,
    pub last: f64,
    pub stated: Option<TimeUnit>,
    /// Whether the name is one of times.
    pub is_named: bool,
    /// Carriers of the signals, in cycles a sample, with the signals' names.
    pub carriers: Vec<(String, f64)>,
    /// Samples of a stroke of the finger or of a contact, with the signals' names.
    pub strokes: Vec<(String, f64)>,
}

/// Unit of an array of times, with the reason.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TimesUnit {
    pub unit: TimeUnit,
    pub is_sure: bool,
    pub reason: String,
}

/// Durations of a stroke or a contact of a finger, s.
const STROKES_S: RangeInclusive<f64> = 0.08..=60.0;
/// Part of the span by which first and last values of times of one recording may differ.
const SAME_SPAN: f64 = 0.25;
/// Lead of a unit over the others from which on it is sure.
const SURE_LEAD: f64 = 2.0;

impl SampledTimes {
    fn span(&self) -> f64 {
        self.last - self.first
    }

    /// Returns whether both arrays begin and end at about the same times, each with values in its unit, s.
    fn is_beside(&self, scale: f64, other: &Self, other_scale: f64) -> bool {
        let span = scale * self.span();
        [(self.first, other.first), (self.last, other.last)]
            .iter()
            .all(|(own, other)| (scale * own - other_scale * other).abs() < SAME_SPAN * span)
    }

    /// Returns whether the unit is open: neither stated nor the numbers of samples.
    fn is_open(&self) -> bool {
        let is_index = self.axis.is_count() && matches!(self.first, 0.0 | 1.0) && !self.is_named;
        self.stated.is_none() && !is_index
    }

    /// Returns whether more than one unit, or none, is plausible by the interval and the duration alone.
    pub fn is_ambiguous(&self) -> bool {
        self.is_open() && (self.axis.is_count() || !self.axis.likely_unit(self.length).1)
    }
}

/// Evidence for a unit.
#[derive(Debug, Default)]
struct UnitEvidence {
    score: f64,
    reasons: Vec<String>,
}

impl UnitEvidence {
    fn add(&mut self, weight: f64, reason: Option<String>) {
        self.score += weight;
        self.reasons.extend(reason);
    }
}

/// Returns the unit of each array; `rates_hz` are those that scalars of the file state.
pub(crate) fn units(all: &[SampledTimes], rates_hz: &[f64]) -> Vec<TimesUnit> {
    all.iter().map(|times| unit(times, all, rates_hz)).collect()
}

fn unit(times: &SampledTimes, all: &[SampledTimes], rates_hz: &[f64]) -> TimesUnit {
    if let Some(unit) = times.stated {
        let reason = format!("its times are in {}", unit.symbol());
        return TimesUnit {
            unit,
            is_sure: true,
            reason,
        };
    }
    let (likely, _) = times.axis.likely_unit(times.length);
    if !times.is_open() {
        let reason = "it counts up by 1".to_owned();
        return TimesUnit {
            unit: TimeUnit::Samples,
            is_sure: false,
            reason,
        };
    }
    // Arrays with the same range of numbers have one unit.
    let group: Vec<&SampledTimes> = all
        .iter()
        .filter(|axis| axis.is_open() && times.is_beside(1.0, axis, 1.0))
        .collect();
    let mut scored: Vec<(TimeUnit, UnitEvidence)> = TimeUnit::ALL
        .into_iter()
        .map(|unit| (unit, evidence(unit, times, &group, all, rates_hz)))
        .collect();
    for (unit, evidence) in &mut scored {
        evidence.score += if *unit == likely { 0.5 } else { 0.0 };
    }
    // A stable sort: of equal scores the longest unit.
    scored.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
    let (best, found) = &scored[0];
    let lead = found.score - scored[1].1.score;
    let is_alone = group.len() == 1 && times.axis.is_count();
    // Numbers of samples without any sign of their rate.
    if is_alone && found.reasons.is_empty() {
        let reason = "it counts up by 1".to_owned();
        return TimesUnit {
            unit: TimeUnit::Samples,
            is_sure: false,
            reason,
        };
    }
    let is_sure = lead >= SURE_LEAD && found.score > 0.0 && !is_alone;
    let symbol = best.symbol();
    let reason = match (is_sure, found.reasons.is_empty()) {
        (true, true) => {
            format!("no unit is stated; only in {symbol} it lasts as long as a recording")
        }
        (true, false) => format!(
            "no unit is stated; in {symbol} {}",
            found.reasons.join(", ")
        ),
        (false, false) => format!(
            "no unit is stated, and another is as likely; in {symbol} {}",
            found.reasons.join(", ")
        ),
        (false, true) => {
            "no unit is stated, and neither its length nor another array tells it: s, ms, µs or ns?"
                .to_owned()
        }
    };
    TimesUnit {
        unit: *best,
        is_sure,
        reason,
    }
}

/// Returns the evidence for a unit of a group of arrays, and of `times` in it.
fn evidence(
    unit: TimeUnit,
    times: &SampledTimes,
    group: &[&SampledTimes],
    all: &[SampledTimes],
    rates_hz: &[f64],
) -> UnitEvidence {
    let mut found = UnitEvidence::default();
    let Some(seconds) = unit.seconds() else {
        return found;
    };
    let (mut has_carrier, mut has_stroke) = (false, false);
    for member in group {
        let interval_s = member.axis.interval * seconds;
        let is_plausible = member.axis.is_plausible(unit, member.length);
        found.add(if is_plausible { 1.0 } else { -1.0 }, None);
        for (name, cycles) in &member.carriers {
            let hz = cycles / interval_s;
            if PLATES_HZ.contains(&hz) && !has_carrier {
                has_carrier = true;
                let hz = grouped(hz.round()).replace('\u{a0}', " ");
                found.add(3.0, Some(format!("the carrier of `{name}` is at {hz} Hz")));
            } else if !PLATES_HZ.contains(&hz) {
                found.add(-1.0, None);
            }
        }
        for (name, samples) in &member.strokes {
            let stroke_s = samples * interval_s;
            if STROKES_S.contains(&stroke_s) && !has_stroke {
                has_stroke = true;
                let text =
                    statistics::significant(format!("{stroke_s:.1e}").parse().unwrap_or(stroke_s));
                found.add(2.0, Some(format!("a movement of `{name}` takes {text} s")));
            } else if !STROKES_S.contains(&stroke_s) {
                found.add(-2.0, None);
            }
        }
        let is_stated = |hz: &&f64| (*hz * interval_s - 1.0).abs() < 0.01;
        if let Some(hz) = rates_hz.iter().find(is_stated).filter(|_| is_plausible) {
            let hz = grouped(*hz).replace('\u{a0}', " ");
            found.add(
                3.0,
                Some(format!("it has the rate of {hz} Hz that the file states")),
            );
        }
    }
    let known = all.iter().find(|axis| {
        let scale = axis.stated.and_then(TimeUnit::seconds);
        scale.is_some_and(|scale| times.is_beside(seconds, axis, scale))
    });
    if let Some(axis) = known {
        found.add(
            4.0,
            Some(format!("it begins and ends with `{}`", axis.name)),
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(name: &str, first: f64, interval: f64, length: u64) -> SampledTimes {
        SampledTimes {
            name: name.to_owned(),
            axis: TimeAxis {
                interval,
                jitter: 0.0,
            },
            length,
            factor: 1.0,
            first,
            last: first + interval * (length - 1) as f64,
            stated: None,
            is_named: false,
            carriers: Vec::new(),
            strokes: Vec::new(),
        }
    }

    fn found(all: &[SampledTimes]) -> Vec<(TimeUnit, bool)> {
        units(all, &[])
            .into_iter()
            .map(|guess| (guess.unit, guess.is_sure))
            .collect()
    }

    #[test]
    fn a_carrier_tells_the_unit_of_all_times_with_the_same_numbers() {
        // 125 kHz, 5 kHz and 1 kHz for 6 s, in each unit.
        for (unit, scale) in [
            (TimeUnit::Seconds, 1.0),
            (TimeUnit::Milliseconds, 1e3),
            (TimeUnit::Microseconds, 1e6),
            (TimeUnit::Nanoseconds, 1e9),
        ] {
            let mut all = vec![
                times("a", 2.0 * scale, 8e-6 * scale, 750_000),
                times("b", 2.1 * scale, 2e-4 * scale, 29_000),
                times("c", 2.0 * scale, 1e-3 * scale, 6_000),
            ];
            all[0].carriers.push(("drive".to_owned(), 0.24));
            assert_eq!(found(&all), vec![(unit, true); 3], "{unit:?}");
        }
    }

    #[test]
    fn movements_tell_the_unit_where_the_length_does_not() {
        // 500 Hz in ms for 8 s: in s it would last 2 h, as some recordings do.
        let ambiguous = times("a", 0.0, 0.02, 300_000);
        assert!(ambiguous.is_ambiguous());
        assert_eq!(
            found(std::slice::from_ref(&ambiguous)),
            [(TimeUnit::Seconds, false)]
        );
        let mut moved = ambiguous.clone();
        moved.strokes.push(("x".to_owned(), 90_000.0));
        assert_eq!(found(&[moved]), [(TimeUnit::Milliseconds, true)]);
        let mut slow = ambiguous;
        slow.strokes.push(("x".to_owned(), 300.0));
        assert_eq!(found(&[slow]), [(TimeUnit::Seconds, true)]);
    }

    #[test]
    fn times_of_a_known_unit_tell_those_beside_them() {
        let mut known = times("k", 7.0, 1e-3, 6_000);
        known.stated = Some(TimeUnit::Seconds);
        let open = times("a", 7_000.0, 0.04, 150_000);
        assert!(open.is_ambiguous());
        assert_eq!(found(&[known, open])[1], (TimeUnit::Milliseconds, true));
        // The rate of another stream would be met by a recording of 6 ms.
        assert_eq!(
            units(&[times("a", 0.0, 1e-3, 6_000)], &[1e6])
                .iter()
                .map(|guess| (guess.unit, guess.is_sure))
                .collect::<Vec<_>>(),
            [(TimeUnit::Seconds, true)]
        );
        let found = units(&[times("a", 0.0, 0.02, 300_000)], &[50e3]);
        assert_eq!(
            (found[0].unit, found[0].is_sure),
            (TimeUnit::Milliseconds, true),
            "{found:?}"
        );
    }

    #[test]
    fn numbers_of_samples_stay_such_and_no_unit_is_doubted() {
        assert_eq!(
            found(&[times("n", 0.0, 1.0, 5_000)]),
            [(TimeUnit::Samples, false)]
        );
        // An hour of one value a minute fits no recording.
        let found = units(&[times("a", 0.0, 60.0, 60)], &[]);
        assert!(
            !found[0].is_sure && found[0].reason.contains("no unit"),
            "{found:?}"
        );
    }
}
