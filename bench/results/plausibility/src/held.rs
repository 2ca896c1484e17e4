//! Forces that keep one value while the finger slides: a sensor, or the program that reads it, that sent nothing new.
//!
//! A reading of a coarse sensor keeps its value for as long as the force stays within a step of the sensor, so that the shortest run
//! that no finger makes depends on the number of steps in the range of the readings. A force that is steady in all slides, as of a
//! simulation without noise, is judged by no run.

use std::borrow::Cow;

use recording::ForceRow;

use crate::Column;
use crate::implausible::Implausible;

/// Fewest equal rows.
const FEWEST: usize = 50;
/// Shortest run in the readings of a fine sensor, s: friction under a finger changes within a period of the modulation, and the force
/// of a hand trembles at 10 Hz.
const SHORTEST_FINE_S: f64 = 0.1;
/// Shortest run in the readings of a coarser one, s.
const SHORTEST_S: f64 = 1.0;
/// Steps of a fine sensor in the range of its readings, and fewest steps by which a run is judged.
const FINE_STEPS: f64 = 1000.0;
const FEWEST_STEPS: f64 = 50.0;
/// Smallest share of the rows of the slides that change.
const CHANGING: f64 = 0.2;
/// Force below which a finger may be off the plate, where a sensor with a dead band reads zero, N.
const TOUCH_N: f64 = 0.05;

/// Equal readings of one column in consecutive rows.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Run {
    first: usize,
    last: usize,
}

/// Removes the rows in which a force keeps one value during `slides_s`, the intervals in which a finger slides, and returns their
/// findings.
pub fn remove_held_forces(rows: &mut Vec<ForceRow>, slides_s: &[(f64, f64)]) -> Vec<Implausible> {
    let columns: [(&'static str, Column, Column); 2] = [
        ("normal_n", |row| row.normal_n, |row| row.lateral_n),
        ("lateral_n", |row| row.lateral_n, |row| row.normal_n),
    ];
    let mut held = vec![false; rows.len()];
    let mut findings = Vec::new();
    for (name, value, other) in columns {
        for run in runs(rows, slides_s, value, other) {
            findings.push(Implausible::Held {
                column: Cow::Borrowed(name),
                value: value(&rows[run.first]),
                from_s: rows[run.first].time_s,
                to_s: rows[run.last].time_s,
            });
            held[run.first..=run.last].fill(true);
        }
    }
    if !findings.is_empty() {
        let mut held = held.iter();
        rows.retain(|_| held.next() == Some(&false));
    }
    findings
}

/// Returns the runs of equal readings of one column that are too long for a finger.
fn runs(rows: &[ForceRow], slides_s: &[(f64, f64)], value: Column, other: Column) -> Vec<Run> {
    let equal = rows.chunk_by(|a, b| value(a) == value(b));
    let mut first = 0;
    let runs: Vec<Run> = equal
        .map(|chunk| {
            let run = Run {
                first,
                last: first + chunk.len() - 1,
            };
            first += chunk.len();
            run
        })
        .collect();
    // One value throughout is that of a dead channel.
    let Some(steps) = steps(rows, value).filter(|steps| *steps >= FEWEST_STEPS) else {
        return Vec::new();
    };
    let shortest_s = if steps < FINE_STEPS {
        SHORTEST_S
    } else {
        SHORTEST_FINE_S
    };
    let is_long = |run: &Run| {
        let (from_s, to_s) = (rows[run.first].time_s, rows[run.last].time_s);
        let overlap_s = |slide: &(f64, f64)| to_s.min(slide.1) - from_s.max(slide.0);
        let sliding_s: f64 = slides_s.iter().map(overlap_s).map(|s| s.max(0.0)).sum();
        run.last - run.first + 1 >= FEWEST && sliding_s >= shortest_s
    };
    let is_touching = |run: &Run| {
        let mut inside = rows[run.first..=run.last].iter();
        value(&rows[run.first]) != 0.0 || inside.any(|row| other(row).abs() >= TOUCH_N)
    };
    let held: Vec<Run> = runs
        .into_iter()
        .filter(|run| is_long(run) && is_touching(run))
        .collect();
    let is_sliding = |time_s: f64| {
        let mut slides = slides_s.iter();
        slides.any(|(start_s, end_s)| (*start_s..=*end_s).contains(&time_s))
    };
    let is_held = |index: usize| {
        let run = held.get(held.partition_point(|run| run.last < index));
        run.is_some_and(|run| run.first <= index)
    };
    let sliding = (0..rows.len()).filter(|index| is_sliding(rows[*index].time_s));
    let (equal, changing): (Vec<usize>, Vec<usize>) = sliding.partition(|index| is_held(*index));
    let changing_rows: Vec<ForceRow> = changing.iter().map(|index| rows[*index]).collect();
    let is_changing = changing.len() as f64 >= CHANGING * (equal.len() + changing.len()) as f64
        && self::steps(&changing_rows, value).is_some_and(|steps| steps >= FEWEST_STEPS);
    if is_changing { held } else { Vec::new() }
}

/// Returns the number of the sensor's steps in the range of its readings; `None` if they do not change.
fn steps(rows: &[ForceRow], value: Column) -> Option<f64> {
    let changes = rows
        .windows(2)
        .map(|pair| (value(&pair[1]) - value(&pair[0])).abs());
    let step = changes.filter(|change| *change > 0.0).reduce(f64::min)?;
    let mut values: Vec<f64> = rows
        .iter()
        .map(value)
        .filter(|value| value.is_finite())
        .collect();
    values.sort_by(f64::total_cmp);
    let at = |share| statistics::quantile(&values, share);
    Some((at(0.95)? - at(0.05)?) / step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows at 1 kHz of a finger that slides from 1 to 3 s, with friction that the film modulates.
    fn rows(step_n: f64) -> Vec<ForceRow> {
        let read = |force_n: f64| (force_n / step_n).round() * step_n;
        let row = |i: u32| {
            let time_s = f64::from(i) * 1e-3;
            let press_n = if time_s < 1.0 {
                0.0
            } else {
                0.6 + 0.1 * (2.0 * time_s).sin()
            };
            let friction = 0.4 + 0.3 * (40.0 * time_s).sin();
            ForceRow {
                time_s,
                normal_n: read(press_n),
                lateral_n: read(press_n * friction),
            }
        };
        (0..3500).map(row).collect()
    }

    fn held(mut rows: Vec<ForceRow>) -> (usize, Vec<String>) {
        let found = remove_held_forces(&mut rows, &[(1.0, 3.0)]);
        (rows.len(), found.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn a_force_that_keeps_its_value_under_a_sliding_finger_is_left_out() {
        for value in [0.0, 0.21] {
            let mut stuck = rows(1e-5);
            stuck[1800..]
                .iter_mut()
                .for_each(|row| row.lateral_n = value);
            let (count, words) = held(stuck);
            assert_eq!(count, 1800);
            let [words] = &words[..] else {
                panic!("{words:?}")
            };
            assert!(
                words.starts_with(&format!(
                    "force.csv: lateral_n is {value} N from 1.800 to 3.499 s"
                )),
                "{words}"
            );
        }
        let mut stuck = rows(1e-5);
        stuck[1500..2000]
            .iter_mut()
            .for_each(|row| row.normal_n = 0.6);
        assert_eq!(held(stuck).0, 3000);
    }

    #[test]
    fn a_finger_at_rest_or_off_the_plate_and_a_coarse_sensor_are_none() {
        for step_n in [1e-6, 1e-3, 5e-3, 0.02, 0.1] {
            assert_eq!(held(rows(step_n)), (3500, Vec::new()), "{step_n}");
        }
        let mut lifted = rows(1e-5);
        for row in &mut lifted[1500..2500] {
            (row.normal_n, row.lateral_n) = (0.0, 0.0);
        }
        assert_eq!(held(lifted).0, 3500);
        let mut before = rows(1e-5);
        before[..1050]
            .iter_mut()
            .for_each(|row| row.lateral_n = 0.3);
        assert_eq!(held(before).0, 3500);
        let mut steady = rows(1e-5);
        for row in steady.iter_mut().filter(|row| row.time_s >= 1.0) {
            row.normal_n = 0.6;
        }
        assert_eq!(held(steady).0, 3500, "a simulation without noise");
        let mut dead = rows(1e-5);
        dead.iter_mut().for_each(|row| row.lateral_n = 0.3);
        assert_eq!(held(dead).0, 3500);
    }
}
