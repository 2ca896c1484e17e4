//! Positions that jump under a pressing finger: an encoder that stood still and made up for it, or a counter that wraps, is set back or
//! miscounts.

use recording::{ForceRow, PositionRow};
use statistics::median;

use crate::implausible::Implausible;

/// Shortest and longest time for which a position stands still, s, and the smallest jump after it, m.
const STILL_S: [f64; 2] = [0.02, 1.0];
const SMALLEST_HELD_M: f64 = 5e-4;
/// Smallest jump of a position at once, m.
const SMALLEST_LEAP_M: f64 = 5e-3;
/// Time and jump of a step that stood still, and jump of one at once, in usual steps.
const HELD: f64 = 5.0;
const LEAP: f64 = 20.0;
/// Greatest way of the steps beside a jump, relative: a finger that moves fast does so in several.
const BESIDE: f64 = 0.25;

/// Step of an encoder, from the begin of one run of equal readings to that of the next.
#[derive(Debug, Clone, Copy)]
struct Step {
    from_s: f64,
    to_s: f64,
    way_m: f64,
}

impl Step {
    fn duration_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// Returns the findings of positions that stand still and then jump, and of those that jump at once, while the finger presses with
/// `contact_n` or more. A finger that waits goes on from where it is, and one that was lifted lands elsewhere.
pub fn position_jumps(
    rows: &[PositionRow],
    force: &[ForceRow],
    contact_n: f64,
) -> impl Iterator<Item = Implausible> + use<> {
    let (held, leaps) = jumps(&steps(rows), force, contact_n).unwrap_or_default();
    let held = held.first().map(|first| Implausible::PositionHeld {
        from_s: first.from_s,
        to_s: first.to_s,
        jump_m: first.way_m,
        count: held.len(),
    });
    let leaps = leaps.first().map(|first| Implausible::PositionJumps {
        at_s: first.to_s,
        jump_m: first.way_m,
        count: leaps.len(),
    });
    held.into_iter().chain(leaps)
}

fn steps(rows: &[PositionRow]) -> Vec<Step> {
    let finite = rows.iter().filter(|row| row.position_m.is_finite());
    let known: Vec<PositionRow> = finite.copied().collect();
    let runs: Vec<&[PositionRow]> = known
        .chunk_by(|a, b| a.position_m == b.position_m)
        .collect();
    let step = |pair: &[&[PositionRow]]| Step {
        from_s: pair[0][0].time_s,
        to_s: pair[1][0].time_s,
        way_m: pair[1][0].position_m - pair[0][0].position_m,
    };
    runs.windows(2).map(step).collect()
}

/// Returns the jumps after a standstill, and those at once; `None` without steps.
fn jumps(steps: &[Step], force: &[ForceRow], contact_n: f64) -> Option<(Vec<Step>, Vec<Step>)> {
    let usual_s = median(steps.iter().map(Step::duration_s))?;
    let usual_m = median(steps.iter().map(|step| step.way_m.abs()))?;
    let way_m = |index: Option<usize>| {
        let step = index.and_then(|index| steps.get(index));
        step.map_or(0.0, |step| step.way_m.abs())
    };
    let (mut held, mut leaps) = (Vec::new(), Vec::new());
    for (index, step) in steps.iter().enumerate() {
        let (duration_s, jump_m) = (step.duration_s(), step.way_m.abs());
        let is_before_others = way_m(Some(index + 1)) <= BESIDE * jump_m;
        let is_after_others = way_m(index.checked_sub(1)) <= BESIDE * jump_m;
        let is_held = (STILL_S[0].max(HELD * usual_s)..=STILL_S[1]).contains(&duration_s)
            && jump_m >= SMALLEST_HELD_M.max(HELD * usual_m);
        let is_leap = duration_s <= HELD * usual_s
            && jump_m >= SMALLEST_LEAP_M.max(LEAP * usual_m)
            && is_after_others;
        if is_before_others && (is_held || is_leap) && presses(force, step, contact_n) {
            if is_held { &mut held } else { &mut leaps }.push(*step);
        }
    }
    Some((held, leaps))
}

/// Returns whether the finger presses in all readings of a step, and there are such.
fn presses(force: &[ForceRow], step: &Step, contact_n: f64) -> bool {
    let first = force.partition_point(|row| row.time_s < step.from_s);
    let end = force.partition_point(|row| row.time_s <= step.to_s);
    // A sensor may be slower than the encoder.
    let inside = force.get(first..end.max(first + 1)).unwrap_or_default();
    !inside.is_empty() && inside.iter().all(|row| row.normal_n >= contact_n)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces at 1 kHz of a finger that presses from 1 s on.
    fn forces() -> Vec<ForceRow> {
        let row = |i: u32| ForceRow {
            time_s: f64::from(i) * 1e-3,
            normal_n: if i < 1000 { 0.0 } else { 0.6 },
            lateral_n: 0.2,
        };
        (0..3500).map(row).collect()
    }

    fn words(rows: &[PositionRow], force: &[ForceRow]) -> String {
        let words = position_jumps(rows, force, 0.1).map(|found| found.to_string());
        words.collect::<Vec<_>>().join("\n")
    }

    /// Positions at 1 kHz of a slide of 50 mm/s from 1 to 3 s, by an encoder of this step.
    fn slide(step_m: f64) -> Vec<PositionRow> {
        let row = |i: u32| {
            let time_s = f64::from(i) * 1e-3;
            let at_m = 0.05 * (time_s.clamp(1.0, 3.0) - 1.0);
            PositionRow {
                time_s,
                position_m: (at_m / step_m).round() * step_m,
            }
        };
        (0..3500).map(row).collect()
    }

    #[test]
    fn a_position_that_stands_still_and_jumps_is_named() {
        for step_m in [1e-6, 5e-5, 1e-3, 5e-3] {
            assert_eq!(words(&slide(step_m), &forces()), "", "{step_m} m");
        }
        let mut held = slide(5e-5);
        for start in [1500, 2000] {
            let position_m = held[start].position_m;
            held[start..start + 40]
                .iter_mut()
                .for_each(|row| row.position_m = position_m);
        }
        let found = words(&held, &forces());
        assert!(
            found.contains("s and then jumps by 2.0 mm, and so 2 times") && !found.contains('\n'),
            "{found}"
        );
        assert_eq!(words(&[], &forces()), "");
        assert_eq!(words(&held, &[]), "");
    }

    #[test]
    fn a_finger_that_waits_or_lands_elsewhere_does_not_jump() {
        let mut waiting = slide(5e-5);
        for row in &mut waiting[1500..] {
            row.position_m = 0.05 * ((row.time_s - 0.3).max(1.5) - 1.0);
        }
        assert_eq!(words(&waiting, &forces()), "");
        let mut landing = slide(5e-5);
        landing[1500..2000]
            .iter_mut()
            .for_each(|row| row.position_m = 0.025);
        assert!(words(&landing, &forces()).contains("and then jumps"));
        let mut lifted = forces();
        lifted[1700..1800]
            .iter_mut()
            .for_each(|row| row.normal_n = 0.0);
        assert_eq!(words(&landing, &lifted), "");
        // An encoder that dithers under a finger at rest, which then moves fast.
        let mut fast = slide(5e-5);
        for (n, row) in fast.iter_mut().enumerate() {
            let dither_m = if n % 2 == 0 { 5e-5 } else { 0.0 };
            let way_m = 0.006 * (n as f64 - 2000.0).clamp(0.0, 15.0);
            row.position_m = way_m + dither_m;
        }
        assert_eq!(words(&fast, &forces()), "");
    }

    #[test]
    fn a_counter_that_wraps_under_a_finger_is_named() {
        let mut wrapped = slide(5e-5);
        for row in &mut wrapped {
            row.position_m = row.position_m.rem_euclid(0.0328);
        }
        let found = words(&wrapped, &forces());
        assert!(
            found.contains("jumps by -32.8 mm") && found.contains("3 times"),
            "{found}"
        );
        let mut lifted = forces();
        lifted.iter_mut().for_each(|row| row.normal_n = 0.0);
        assert_eq!(words(&wrapped, &lifted), "");
    }
}
