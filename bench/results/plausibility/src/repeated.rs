//! Readings that come twice, to the last digit: a buffer that was written again, or a stretch that was copied.
//!
//! A sensor has noise, so that not even forty readings of its two axes come a second time. Readings without noise, as of a simulation,
//! may, and are not judged.

use std::collections::HashMap;

use recording::ForceRow;

use crate::implausible::Implausible;

/// Rows of a window that is looked for.
const WINDOW: usize = 40;
/// Base of the polynomials: an odd number without a pattern, 2⁶⁴ divided by the golden ratio.
const BASE: u64 = 0x9E37_79B9_7F4A_7C15;
/// Shortest stretch, s.
const SHORTEST_S: f64 = 0.1;
/// Smallest share of a window's rows that are unlike every other of it, and at which an axis turns.
const UNLIKE: f64 = 0.5;
const TURNS: f64 = 0.25;

/// Returns the finding of the longest stretch of readings that comes a second time.
#[must_use]
pub fn repeated(rows: &[ForceRow]) -> Option<Implausible> {
    let values: Vec<[u64; 2]> = rows
        .iter()
        .map(|row| [row.normal_n.to_bits(), row.lateral_n.to_bits()])
        .collect();
    let keys = window_keys(&values);
    let mut firsts: HashMap<u64, usize> = HashMap::new();
    for first in (0..keys.len()).step_by(WINDOW) {
        if is_noisy(&rows[first..first + WINDOW]) {
            firsts.entry(keys[first]).or_insert(first);
        }
    }
    let (mut longest, mut passed) = (None::<(usize, usize, usize)>, 0);
    for (place, window) in values.windows(WINDOW).enumerate() {
        let Some(&first) = firsts.get(&keys[place]).filter(|_| place >= passed) else {
            continue;
        };
        if first + WINDOW > place || values[first..first + WINDOW] != *window {
            continue;
        }
        let before = (0..first.min(place - first))
            .take_while(|back| values[first - back - 1] == values[place - back - 1])
            .count();
        let (first, again) = (first - before, place - before);
        let length = (0..values.len() - again)
            .take_while(|on| first + on < again && values[first + on] == values[again + on])
            .count();
        passed = again + length;
        if longest.is_none_or(|(_, _, most)| length > most) {
            longest = Some((first, again, length));
        }
    }
    let (first, again, length) = longest?;
    let time_s = |index: usize| rows[index].time_s;
    let from_s = time_s(again);
    let to_s = time_s(again + length - 1);
    (to_s - from_s >= SHORTEST_S).then(|| Implausible::Repeated {
        from_s,
        to_s,
        first_s: time_s(first),
    })
}

/// Returns a key of each window of rows: a polynomial of its values, from one window to the next by one step (Karp and Rabin 1987).
fn window_keys(values: &[[u64; 2]]) -> Vec<u64> {
    let mixed = |value: &[u64; 2]| {
        let mixed = (value[0] ^ value[1].rotate_left(32)).wrapping_mul(BASE);
        mixed ^ (mixed >> 29)
    };
    let leaving = (0..WINDOW).fold(1_u64, |power, _| power.wrapping_mul(BASE));
    let mut keys = Vec::with_capacity(values.len());
    let mut key = 0_u64;
    for (index, value) in values.iter().enumerate() {
        key = key.wrapping_mul(BASE).wrapping_add(mixed(value));
        if let Some(first) = index.checked_sub(WINDOW) {
            key = key.wrapping_sub(mixed(&values[first]).wrapping_mul(leaving));
        }
        if index + 1 >= WINDOW {
            keys.push(key);
        }
    }
    keys
}

/// Returns whether the rows are unlike each other, and have noise: a smooth force turns rarely.
fn is_noisy(rows: &[ForceRow]) -> bool {
    let is_unlike = |index: &usize| {
        let row = &rows[*index];
        rows[..*index]
            .iter()
            .all(|other| (other.normal_n, other.lateral_n) != (row.normal_n, row.lateral_n))
    };
    let unlike = (0..rows.len()).filter(is_unlike).count();
    let turns = |value: crate::Column| {
        let rises = rows
            .windows(3)
            .map(|rows| (value(&rows[1]) - value(&rows[0])) * (value(&rows[2]) - value(&rows[1])));
        rises.filter(|product| *product < 0.0).count()
    };
    let most = turns(|row| row.normal_n).max(turns(|row| row.lateral_n));
    unlike as f64 >= UNLIKE * rows.len() as f64 && most as f64 >= TURNS * rows.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two seconds at 1 kHz of a finger with noise of this size, in steps of 1 mN.
    fn finger(noise_n: f64) -> Vec<ForceRow> {
        let mut state = 12_345_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise_n * (f64::from(state) / f64::from(u32::MAX) - 0.5)
        };
        let mut row = |n: u32| {
            let phase = std::f64::consts::TAU * f64::from(n % 250) / 250.0;
            let read = |force_n: f64| (force_n / 1e-3).round() * 1e-3;
            ForceRow {
                time_s: f64::from(n) * 1e-3,
                normal_n: read(0.6 + 0.05 * phase.cos() + next()),
                lateral_n: read(0.3 + 0.2 * phase.sin() + next()),
            }
        };
        (0..2000).map(&mut row).collect()
    }

    #[test]
    fn a_stretch_that_comes_twice_is_found() {
        for (from, to, length) in [(300, 1000, 150), (517, 700, 183), (0, 1000, 1000)] {
            let mut rows = finger(0.02);
            for n in 0..length {
                let copied = rows[from + n];
                rows[to + n].normal_n = copied.normal_n;
                rows[to + n].lateral_n = copied.lateral_n;
            }
            let Some(Implausible::Repeated {
                from_s,
                to_s,
                first_s,
            }) = repeated(&rows)
            else {
                panic!("{from}, {to}, {length}");
            };
            let found = [first_s, from_s, to_s];
            let expected = [from, to, to + length - 1].map(|n| n as f64 * 1e-3);
            let is_near = |(found, expected): (f64, f64)| (found - expected).abs() < 2e-3;
            assert!(
                found.into_iter().zip(expected).all(is_near),
                "{found:?} is not {expected:?}"
            );
        }
    }

    #[test]
    fn noise_short_copies_and_readings_without_noise_are_none() {
        assert_eq!(repeated(&finger(0.02)), None);
        assert_eq!(repeated(&finger(0.0)), None, "four periods a second");
        let mut short = finger(0.02);
        for n in 0..60 {
            short[1000 + n].normal_n = short[300 + n].normal_n;
            short[1000 + n].lateral_n = short[300 + n].lateral_n;
        }
        assert_eq!(repeated(&short), None);
        assert_eq!(repeated(&[]), None);
    }
}
