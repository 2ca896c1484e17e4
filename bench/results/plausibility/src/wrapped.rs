//! Forces that wrap: integers that went beyond their range and began again at its other end.
//!
//! The friction of a hard slider turns as abruptly where its stroke turns. A force that wraps goes on as before the jump: it rises to
//! the upper end, jumps to the lower one, and rises on. Its noise makes it jump back and forth there within a few rows, as no slider
//! turns.

use recording::ForceRow;
use statistics::median;

use crate::implausible::Implausible;

/// Share of the range at either end between which a wrap jumps: one row later the force is not far from where it left.
const END_SHARE: f64 = 0.1;
/// Fewest jumps, and share of them around which the force goes on.
const FEWEST: usize = 3;
const GOES_ON: f64 = 0.7;
/// Most rows from a jump to one back.
const BACK_ROWS: usize = 5;
/// Longest interval of rows across which a jump is judged, in usual ones.
const LONGEST_STEPS: f64 = 3.0;
/// Smallest range that is judged, N.
const SMALLEST_N: f64 = 0.1;

/// Returns the finding of a column that wraps.
#[must_use]
pub fn wrapped(rows: &[ForceRow]) -> Option<Implausible> {
    let columns: [(&'static str, crate::Column); 2] = [
        ("normal_n", |row| row.normal_n),
        ("lateral_n", |row| row.lateral_n),
    ];
    columns
        .into_iter()
        .find_map(|(name, value)| column(rows, name, value))
}

fn column(rows: &[ForceRow], name: &'static str, value: crate::Column) -> Option<Implausible> {
    let values = || rows.iter().map(value).filter(|value| value.is_finite());
    let (least, most) = (values().reduce(f64::min)?, values().reduce(f64::max)?);
    let range = most - least;
    let step_s = median(rows.windows(2).map(|pair| pair[1].time_s - pair[0].time_s))?;
    let is_low = |row: &ForceRow| value(row) < least + END_SHARE * range;
    let is_high = |row: &ForceRow| value(row) > most - END_SHARE * range;
    let is_jump = |pair: &&[ForceRow]| {
        let is_near = pair[1].time_s - pair[0].time_s <= LONGEST_STEPS * step_s;
        is_near
            && ((is_low(&pair[0]) && is_high(&pair[1])) || (is_high(&pair[0]) && is_low(&pair[1])))
    };
    let jumps: Vec<usize> = rows
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| is_jump(pair))
        .map(|(index, _)| index)
        .collect();
    let at = |index: Option<usize>| index.and_then(|index| rows.get(index)).map(value);
    let goes_on = |index: &usize| {
        let (before, after) = (*index, *index + 1);
        let rise = |from: Option<usize>, to: usize| Some(at(Some(to))? - at(from)?);
        let slopes = rise(before.checked_sub(1), before).zip(rise(Some(after), after + 1));
        let jump = value(&rows[after]) - value(&rows[before]);
        slopes.is_some_and(|(first, second)| first * jump < 0.0 && second * jump < 0.0)
    };
    let is_back_and_forth = |place: usize| {
        let neighbours = [place.checked_sub(1), Some(place + 1)]
            .into_iter()
            .flatten();
        { neighbours }
            .filter_map(|neighbour| jumps.get(neighbour))
            .any(|neighbour| neighbour.abs_diff(jumps[place]) <= BACK_ROWS)
    };
    let places = jumps.iter().enumerate();
    let going_on = places
        .filter(|(place, index)| goes_on(index) || is_back_and_forth(*place))
        .count() as f64;
    let is_wrap = jumps.len() >= FEWEST && going_on >= GOES_ON * jumps.len() as f64;
    let jumps = jumps.len();
    (range > SMALLEST_N && least < 0.0 && is_wrap).then(|| Implausible::Wrapped {
        column: name.into(),
        least_n: least,
        most_n: most,
        jumps,
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn rows(limit_n: f64, noise_n: f64) -> Vec<ForceRow> {
        let wrap = |force_n: f64| (force_n + limit_n).rem_euclid(2.0 * limit_n) - limit_n;
        let row = |n: u32| {
            let time_s = f64::from(n) * 1e-3;
            let turn = if time_s < 2.0 { 1.0 } else { -1.0 };
            let friction_n = 0.6 * turn * (0.45 + 0.4 * (TAU * 6.0 * time_s).cos());
            ForceRow {
                time_s,
                normal_n: 0.6,
                lateral_n: wrap(friction_n + noise_n * (7.7 * f64::from(n)).sin()),
            }
        };
        (0..4000).map(row).collect()
    }

    #[test]
    fn integers_that_began_again_are_named() {
        for (limit_n, noise_n) in [(0.3, 0.0), (0.45, 0.0), (0.4, 0.02), (0.3, 0.03)] {
            let found = wrapped(&rows(limit_n, noise_n)).map(|found| found.to_string());
            assert!(
                found
                    .as_ref()
                    .is_some_and(|found| found.contains("lateral_n jumps between")),
                "{found:?}"
            );
        }
        assert_eq!(wrapped(&rows(0.56, 0.02)), None);
        // A hard slider, with noise, turns eight times at 100 Hz.
        let slider = |n: u32| ForceRow {
            time_s: f64::from(n) * 0.01,
            normal_n: 1.0,
            lateral_n: if (n / 100).is_multiple_of(2) {
                0.3
            } else {
                -0.3
            } + 0.01 * (2.3 * f64::from(n)).sin(),
        };
        assert_eq!(wrapped(&(0..900).map(slider).collect::<Vec<_>>()), None);
        assert_eq!(wrapped(&[]), None);
    }
}
