//! Forces on a straight line while the finger slides: a gap that was filled in.

use std::borrow::Cow;

use recording::ForceRow;
use statistics::{median, quantile};

use crate::Column;
use crate::implausible::Implausible;

/// Shortest line, s, and fewest rows of it.
const SHORTEST_S: f64 = 0.1;
const FEWEST: usize = 50;
/// Change of the slope from one row to the next on a line, as a share of the usual one, which noise makes.
const STRAIGHT: f64 = 0.02;
/// Smallest usual change of the slope, as a share of the range of the readings: those of a simulation without noise have none.
const NOISY: f64 = 1e-3;

/// Returns the finding of forces that follow the longest straight line in one of `slides_s`. A force that keeps one value has its own.
#[must_use]
pub fn interpolated(rows: &[ForceRow], slides_s: &[(f64, f64)]) -> Option<Implausible> {
    let columns: [(&'static str, Column); 2] = [
        ("normal_n", |row| row.normal_n),
        ("lateral_n", |row| row.lateral_n),
    ];
    let lines = columns.into_iter().filter_map(|(column, value)| {
        let (from_s, to_s) = longest_line_s(rows, slides_s, value)?;
        Some(Implausible::Interpolated {
            column: Cow::Borrowed(column),
            from_s,
            to_s,
        })
    });
    lines.into_iter().next()
}

/// Returns start and end of the longest line of a column, s.
fn longest_line_s(rows: &[ForceRow], slides_s: &[(f64, f64)], value: Column) -> Option<(f64, f64)> {
    let slides: Vec<&[ForceRow]> = { slides_s.iter() }
        .filter_map(|(start_s, end_s)| {
            let place = |time_s: f64| rows.partition_point(|row| row.time_s < time_s);
            rows.get(place(*start_s)..place(*end_s))
        })
        .collect();
    let bend = |three: &[ForceRow]| match three {
        [a, b, c] => (value(c) - 2.0 * value(b) + value(a)).abs(),
        _ => f64::NAN,
    };
    let usual = median(slides.iter().flat_map(|slide| slide.windows(3).map(bend)))?;
    let mut values: Vec<f64> = { slides.iter() }
        .flat_map(|slide| slide.iter().map(value))
        .filter(|value| value.is_finite())
        .collect();
    values.sort_by(f64::total_cmp);
    let range = quantile(&values, 0.95)? - quantile(&values, 0.05)?;
    if usual.is_nan() || usual <= NOISY * range {
        return None;
    }
    let lines_s = slides.iter().flat_map(|slide| {
        let straight: Vec<bool> = slide
            .windows(3)
            .map(|three| bend(three) < STRAIGHT * usual)
            .collect();
        let mut first = 0;
        let runs: Vec<(usize, usize)> = straight
            .chunk_by(|a, b| a == b)
            .filter_map(|run| {
                let start = first;
                first += run.len();
                run[0].then_some((start, start + run.len() + 1))
            })
            .collect();
        runs.into_iter().filter_map(|(first, last)| {
            let (first_row, last_row) = (slide.get(first)?, slide.get(last)?);
            let is_level = value(first_row) == value(last_row);
            let length_s = last_row.time_s - first_row.time_s;
            let is_long = last - first >= FEWEST && length_s >= SHORTEST_S;
            (is_long && !is_level).then_some((first_row.time_s, last_row.time_s))
        })
    });
    lines_s.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings at 1 kHz of a finger that slides from 1 to 3 s, with noise of `noise_n`, by a generator of Numerical Recipes.
    fn rows(noise_n: f64) -> Vec<ForceRow> {
        let mut state = 1u64;
        let mut noise = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            3.5 * noise_n * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
        };
        let row = |step: u32| {
            let time_s = f64::from(step) * 1e-3;
            let press_n = 0.6 + 0.1 * (2.0 * time_s).sin();
            ForceRow {
                time_s,
                normal_n: press_n + noise(),
                lateral_n: press_n * (0.4 + 0.3 * (40.0 * time_s).sin()) + noise(),
            }
        };
        (0..3500).map(row).collect()
    }

    fn bridged(mut rows: Vec<ForceRow>, first: usize, last: usize) -> Vec<ForceRow> {
        let (from, to) = (rows[first].lateral_n, rows[last].lateral_n);
        for (index, row) in rows[first..last].iter_mut().enumerate() {
            let share = index as f64 / (last - first) as f64;
            row.lateral_n = from + share * (to - from);
        }
        rows
    }

    #[test]
    fn a_gap_that_was_filled_in_is_named() {
        let found = interpolated(&bridged(rows(2e-3), 1500, 1800), &[(1.0, 3.0)]);
        let Some(Implausible::Interpolated {
            column,
            from_s,
            to_s,
        }) = found
        else {
            panic!("{found:?}");
        };
        assert_eq!(column, "lateral_n");
        assert!((from_s - 1.5).abs() < 3e-3 && (to_s - 1.8).abs() < 3e-3);
        assert_eq!(interpolated(&rows(2e-3), &[(1.0, 3.0)]), None);
        assert_eq!(
            interpolated(&bridged(rows(2e-3), 1500, 1550), &[(1.0, 3.0)]),
            None
        );
        assert_eq!(
            interpolated(&bridged(rows(0.0), 1500, 1800), &[(1.0, 3.0)]),
            None
        );
        assert_eq!(
            interpolated(&bridged(rows(2e-3), 1500, 1800), &[(2.0, 3.0)]),
            None
        );
        assert_eq!(interpolated(&[], &[(1.0, 3.0)]), None);
    }
}
