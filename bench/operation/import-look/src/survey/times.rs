//! Arrays of times of a file, and their units by the signals beside them.

use source_files::{Element, SourceError, SourceFile, Vector};

use super::reading::excerpt;

use crate::carrier::carrier;
use crate::names;
use crate::portrait::StreamStart;
use crate::rates::Times;
use crate::slow::{Slow, slow};
use crate::time_axis::{TimeUnit, time_axis};
use crate::time_units::{SampledTimes, units};
use crate::units::unit_in_name;

/// Values at the start of a vector by which an array of times is known.
const HEAD: u64 = 4_096;
/// Most signals by which the unit of an array of times is found.
const MOST_SIGNALS: usize = 6;

/// Returns whether no unit of another quantity is stated.
pub(super) fn may_be_time(vector: &Vector) -> bool {
    stated_unit(vector)
        .is_none_or(|unit| TimeUnit::parse(&unit).is_some() || vector.element() == Element::Time)
}

fn stated_unit(vector: &Vector) -> Option<String> {
    vector
        .unit()
        .map(str::to_owned)
        .or_else(|| unit_in_name(vector.name()))
}

/// Returns the arrays of times among vectors, each with the factor that attributes state; `rates_hz` are those that scalars state. An array that cannot be read is
/// none.
pub(super) fn times(
    file: &mut SourceFile,
    vectors: &[(&Vector, f64)],
    rates_hz: &[f64],
) -> Vec<Times> {
    let mut sampled: Vec<SampledTimes> = Vec::new();
    for (vector, factor) in vectors {
        sampled.extend(sampled_times(file, vector, *factor).ok().flatten());
    }
    for index in 0..sampled.len() {
        if !sampled[index].is_ambiguous() {
            continue;
        }
        let is_signal = |vector: &&Vector| {
            vector.len() == sampled[index].length
                && !vector.is_complex()
                && sampled.iter().all(|times| times.name != vector.name())
        };
        let signals: Vec<&Vector> = vectors
            .iter()
            .map(|(vector, _)| *vector)
            .filter(is_signal)
            .take(MOST_SIGNALS)
            .collect();
        for signal in signals {
            // An array that cannot be read is listed with the reason.
            if let Ok(excerpt) = excerpt(file, signal) {
                let name = signal.name().to_owned();
                let length = excerpt.longest().len() as f64;
                if let Some(found) = carrier(excerpt.longest(), None) {
                    sampled[index].carriers.push((name, found.frequency_hz));
                    continue;
                }
                let movements = match slow(&excerpt, None) {
                    Slow::Travel(travel) => travel.strokes,
                    Slow::Counts(counts) => counts.travel.strokes,
                    Slow::Steps(steps) => steps.count,
                    _ => 0,
                };
                if movements > 0 {
                    let samples = length / movements as f64;
                    sampled[index].strokes.push((name, samples));
                }
            }
        }
    }
    let found = units(&sampled, rates_hz);
    let times = sampled.iter().zip(found).filter_map(|(times, unit)| {
        let seconds = unit.unit.seconds()?;
        let begin_s = times.first * seconds;
        let interval_s = times.axis.interval * seconds;
        Some(Times {
            name: times.name.clone(),
            length: times.length,
            factor: times.factor,
            rate_hz: 1.0 / interval_s,
            start: StreamStart {
                begin_s,
                is_of_day: begin_s.abs() > 2.0 * interval_s,
            },
            unit,
        })
    });
    times.collect()
}

/// Returns the vector as an array of times, if it begins as one and ends as one.
fn sampled_times(
    file: &mut SourceFile,
    vector: &Vector,
    factor: f64,
) -> Result<Option<SampledTimes>, Box<SourceError>> {
    let length = vector.len();
    if vector.is_complex() || length < 8 || factor <= 0.0 || !may_be_time(vector) {
        return Ok(None);
    }
    let mut head = Vec::new();
    file.read(vector, 0..length.min(HEAD), &mut head)?;
    let Some(mut axis) = time_axis(&head) else {
        return Ok(None);
    };
    let mut end = Vec::new();
    file.read(vector, length - 1..length, &mut end)?;
    let interval = (end[0] - head[0]) / (length - 1) as f64;
    // An encoder moves on at a steady pace for a while, but not to the end.
    let is_steady = (interval / axis.interval - 1.0).abs() < 0.2;
    if !is_steady {
        return Ok(None);
    }
    if !axis.is_count() || factor != 1.0 {
        axis.interval = factor * interval;
    }
    let stated = match vector.element() {
        Element::Time => Some(TimeUnit::Seconds),
        _ => stated_unit(vector).and_then(|unit| TimeUnit::parse(&unit)),
    };
    let is_named = matches!(names::role(vector.name()), Some((names::Role::Time, _)));
    let is_certain = is_named || stated.is_some() || axis.jitter < 1e-3;
    Ok(is_certain.then(|| SampledTimes {
        name: vector.name().to_owned(),
        axis,
        length,
        factor,
        first: factor * head[0],
        last: factor * end[0],
        stated,
        is_named,
        carriers: Vec::new(),
        strokes: Vec::new(),
    }))
}
