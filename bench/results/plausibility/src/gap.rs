//! Rows of forces that are missing while a finger slides.

use recording::ForceRow;
use statistics::median;

use crate::implausible::Implausible;

/// Usual intervals of rows, and time, s, beyond which rows are missing.
const MOST_STEPS: f64 = 5.0;
const LONGEST_S: f64 = 0.02;

/// Returns the finding of the longest time without a row in `slides_s`.
#[must_use]
pub fn force_gap(rows: &[ForceRow], slides_s: &[(f64, f64)]) -> Option<Implausible> {
    let pairs = || rows.windows(2).map(|pair| (pair[0].time_s, pair[1].time_s));
    let step_s = median(pairs().map(|(from_s, to_s)| to_s - from_s))?;
    let is_sliding = |(from_s, to_s): &(f64, f64)| {
        let mut slides = slides_s.iter();
        slides.any(|(start_s, end_s)| *to_s >= *start_s && *from_s <= *end_s)
    };
    let gaps = pairs().filter(is_sliding);
    let (from_s, to_s) = gaps.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    let is_long = to_s - from_s > LONGEST_S.max(MOST_STEPS * step_s);
    is_long.then_some(Implausible::Gap {
        from_s,
        to_s,
        step_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_rows_are_found_where_a_finger_slides() {
        let rows = |step_s: f64, lost: std::ops::Range<u32>| -> Vec<ForceRow> {
            let kept = (0..3000).filter(|n| !lost.contains(n));
            let row = |n: u32| ForceRow {
                time_s: f64::from(n) * step_s,
                normal_n: 0.5,
                lateral_n: 0.2,
            };
            kept.map(row).collect()
        };
        let found = force_gap(&rows(1e-3, 1500..1650), &[(1.0, 2.0)]).unwrap();
        assert!(
            found
                .to_string()
                .contains("nothing was read for 0.15 s from 1.499 s on"),
            "{found}"
        );
        assert_eq!(force_gap(&rows(1e-3, 0..0), &[(1.0, 2.0)]), None);
        assert_eq!(force_gap(&rows(1e-3, 500..900), &[(1.0, 2.0)]), None);
        // An interval by a rule ends where its rows do.
        assert!(force_gap(&rows(1e-3, 1500..2900), &[(1.0, 1.499)]).is_some());
        // A slow sensor.
        assert_eq!(force_gap(&rows(0.05, 50..53), &[(1.0, 5.0)]), None);
        assert_eq!(force_gap(&[], &[(1.0, 5.0)]), None);
    }
}
