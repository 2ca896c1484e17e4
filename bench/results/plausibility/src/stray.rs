//! Stray readings: values that a program writes in place of a lost reading (-999, 9.9e37, 0), and single disturbances.

use std::borrow::Cow;

use recording::{ForceRow, PositionRow};

use crate::{Implausible, LARGEST_N};

/// Most rows of a stray run: a finger that comes or goes changes more of them at any rate that is analysed.
const LONGEST_RUN: usize = 5;
/// Smallest jump of a stray position, m: three lengths of a plate.
const POSITION_JUMP_M: f64 = 0.3;
/// Jump relative to the range of the readings from which on they are stray, whatever their unit.
const JUMP_RANGES: f64 = 5.0;
/// Quantiles between which the readings range: stray ones are few.
const RANGE: [f64; 2] = [0.05, 0.95];
/// Shortest time from a pressing finger to the next one with a lift between, s.
const LIFT_S: f64 = 0.03;
/// Most readings by which the range is read.
const SAMPLED: usize = 100_000;
/// Smallest force on either side of zeros that stand for lost readings, N, and relative to the range of the readings.
const PRESSED_N: f64 = 0.2;
const PRESSED_RANGES: f64 = 0.2;

/// Removes the rows with a stray force, and returns their flaws.
pub fn remove_stray_forces(rows: &mut Vec<ForceRow>) -> Vec<Implausible> {
    let columns: [(&'static str, crate::Column); 2] = [
        ("normal_n", |row| row.normal_n),
        ("lateral_n", |row| row.lateral_n),
    ];
    let time_s: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
    let found = columns.map(|(name, value)| {
        let values: Vec<f64> = rows.iter().map(value).collect();
        let mut strays = stray_readings(&values, LARGEST_N);
        strays.extend(lost_zeros(&values, &time_s));
        (name, value, strays)
    });
    remove(rows, "force.csv", &found, |row| row.time_s)
}

/// Removes the rows with a stray position, and returns their flaw.
pub fn remove_stray_positions(rows: &mut Vec<PositionRow>) -> Vec<Implausible> {
    let value = |row: &PositionRow| row.position_m;
    let values: Vec<f64> = rows.iter().map(value).collect();
    let strays = stray_readings(&values, POSITION_JUMP_M);
    let found = [("position_m", value as fn(&PositionRow) -> f64, strays)];
    remove(rows, "position.csv", &found, |row| row.time_s)
}

/// Column with its name, its value in a row, and the indices of its stray rows.
type Found<R> = (&'static str, fn(&R) -> f64, Vec<usize>);

fn remove<R>(
    rows: &mut Vec<R>,
    file: &'static str,
    columns: &[Found<R>],
    time_s: impl Fn(&R) -> f64,
) -> Vec<Implausible> {
    let flaws = columns.iter().filter_map(|(name, value, strays)| {
        let first = &rows[*strays.iter().min()?];
        Some(Implausible::Stray {
            file: Cow::Borrowed(file),
            column: Cow::Borrowed(name),
            count: strays.len(),
            value: value(first),
            at_s: time_s(first),
        })
    });
    let flaws: Vec<Implausible> = flaws.collect();
    if !flaws.is_empty() {
        let mut is_stray = vec![false; rows.len()];
        let strays = columns.iter().flat_map(|(_, _, strays)| strays);
        strays.for_each(|index| is_stray[*index] = true);
        let mut index = 0;
        rows.retain(|_| {
            index += 1;
            !is_stray[index - 1]
        });
    }
    flaws
}

/// Returns the indices of readings that jump by more than `least`, and by more than the readings range, and back within a few
/// rows.
#[must_use]
pub fn stray_readings(values: &[f64], least: f64) -> Vec<usize> {
    let jump = least.max(JUMP_RANGES * range(values));
    let finite = (0..values.len()).filter(|index| values[*index].is_finite());
    let finite: Vec<usize> = finite.collect();
    let Some(mut last) = statistics::median(finite.iter().take(5).map(|index| values[*index]))
    else {
        return Vec::new();
    };
    let mut strays = Vec::new();
    let mut place = 0;
    while place < finite.len() {
        let is_far = |place: usize| (values[finite[place]] - last).abs() > jump;
        let end = place + LONGEST_RUN.min(finite.len() - place);
        let run = (place..end).take_while(|place| is_far(*place)).count();
        let returns = place + run == finite.len() || run < end - place;
        if run > 0 && returns {
            strays.extend_from_slice(&finite[place..place + run]);
            place += run;
        } else {
            last = values[finite[place]];
            place += 1;
        }
    }
    strays
}

/// Returns the range of most readings.
fn range(values: &[f64]) -> f64 {
    let step = values.len().div_ceil(SAMPLED).max(1);
    let sampled = values.iter().step_by(step).copied();
    let mut sampled: Vec<f64> = sampled.filter(|value| value.is_finite()).collect();
    sampled.sort_by(f64::total_cmp);
    let [low, high] = RANGE.map(|share| statistics::quantile(&sampled, share).unwrap_or_default());
    high - low
}

/// Returns the indices of zeros between readings of a pressing finger, so few and so brief that it did not lift.
fn lost_zeros(values: &[f64], time_s: &[f64]) -> Vec<usize> {
    let pressed = PRESSED_N.max(PRESSED_RANGES * range(values));
    let mut zeros = Vec::new();
    let mut last: Option<usize> = None;
    for (index, value) in values
        .iter()
        .enumerate()
        .filter(|(_, value)| **value != 0.0)
    {
        if let Some(before) = last.filter(|last| (2..=LONGEST_RUN + 1).contains(&(index - last))) {
            let is_pressed = values[before].abs().min(value.abs()) > pressed;
            let is_brief = time_s[index] - time_s[before] <= LIFT_S;
            if is_pressed && is_brief && values[before] * value > 0.0 {
                zeros.extend(before + 1..index);
            }
        }
        last = Some(index);
    }
    zeros
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a touch from 1 to 3 s, at a rate, with a lateral force that turns.
    fn touch(rate_hz: f64, unit: f64) -> Vec<ForceRow> {
        let row = |n: usize| {
            let time_s = n as f64 / rate_hz;
            let noise = 0.003 * (1.7 * n as f64).sin();
            let pressed = f64::from((1.0..3.0).contains(&time_s));
            ForceRow {
                time_s,
                normal_n: unit * (0.7 * pressed + noise),
                lateral_n: unit * (0.3 * pressed * if time_s < 2.0 { 1.0 } else { -1.0 } - noise),
            }
        };
        (0..(4.0 * rate_hz) as usize).map(row).collect()
    }

    #[test]
    fn a_finger_that_comes_turns_and_goes_is_no_stray_at_any_rate_or_unit() {
        for rate_hz in [20.0, 100.0, 1e3, 1e4] {
            for unit in [1.0, 1e3, -1e3, 9.8] {
                let mut rows = touch(rate_hz, unit);
                let count = rows.len();
                let flaws = remove_stray_forces(&mut rows);
                assert!(
                    flaws.is_empty() && rows.len() == count,
                    "{rate_hz} {unit}: {flaws:?}"
                );
            }
        }
    }

    #[test]
    fn signs_of_lost_readings_are_removed_and_named_with_their_first_time() {
        for (value, column) in [
            (-999.0, 0),
            (999.0, 1),
            (99.99, 0),
            (9.9e37, 1),
            (-9999.0, 1),
        ] {
            let mut rows = touch(1e3, 1.0);
            let clean = rows.clone();
            let strays = [0, 1500, 1501, 1502, 2200, 3999];
            for index in strays {
                match column {
                    0 => rows[index].normal_n = value,
                    _ => rows[index].lateral_n = value,
                }
            }
            let flaws = remove_stray_forces(&mut rows);
            let [
                Implausible::Stray {
                    count,
                    at_s,
                    value: first,
                    ..
                },
            ] = &flaws[..]
            else {
                panic!("{value}: {flaws:?}");
            };
            assert_eq!((*count, *at_s, *first), (strays.len(), 0.0, value));
            let mut expected = clean;
            for index in strays.into_iter().rev() {
                expected.remove(index);
            }
            assert_eq!(rows, expected, "{value}");
            let text = flaws[0].to_string();
            assert!(
                text.contains("0.000 s") && text.contains("force.csv"),
                "{text}"
            );
        }
    }

    #[test]
    fn lost_packets_written_as_zeros_are_removed_while_a_finger_presses() {
        let mut rows = touch(1e3, 1.0);
        for row in rows.iter_mut().step_by(10) {
            (row.normal_n, row.lateral_n) = (0.0, 0.0);
        }
        let flaws = remove_stray_forces(&mut rows);
        assert_eq!(flaws.len(), 2, "{flaws:?}");
        let pressed = rows.iter().filter(|row| (1.1..2.9).contains(&row.time_s));
        assert!(pressed.clone().all(|row| row.normal_n > 0.5));
        assert!(pressed.count() > 1600);
    }

    #[test]
    fn zeros_of_a_finger_that_lifts_are_kept_and_those_of_a_lost_packet_are_not() {
        for (rate_hz, run, is_lost) in [
            (1e3, 3, true),
            (1e3, 6, false),
            (100.0, 1, true),
            (100.0, 3, false),
        ] {
            let mut rows = touch(rate_hz, 1.0);
            let count = rows.len();
            let start = (1.5 * rate_hz) as usize;
            for row in &mut rows[start..start + run] {
                (row.normal_n, row.lateral_n) = (0.0, 0.0);
            }
            remove_stray_forces(&mut rows);
            let removed = count - rows.len();
            assert_eq!(
                removed,
                if is_lost { run } else { 0 },
                "{run} rows at {rate_hz} Hz"
            );
        }
    }

    #[test]
    fn a_lost_position_is_removed() {
        let row = |n: usize| PositionRow {
            time_s: n as f64 * 1e-3,
            position_m: 0.1 * (n as f64 * 1e-3).fract(),
        };
        let mut rows: Vec<PositionRow> = (0..4000).map(row).collect();
        assert!(remove_stray_positions(&mut rows).is_empty());
        rows[700].position_m = -1.0;
        assert_eq!(remove_stray_positions(&mut rows).len(), 1);
        assert_eq!(rows.len(), 3999);
    }
}
