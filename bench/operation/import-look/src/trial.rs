//! Trial of guessed rules on the data that they were guessed from.

use interval_rules::{Rule, Series};

use crate::excerpt::FineCourse;

/// Shortest time in which a rule is tried, s.
const SHORTEST: &str = "0.001 s";

/// Returns the velocity of positions in m, m/s.
pub(crate) fn velocity(position: &FineCourse, metres: f64) -> FineCourse {
    let values: Vec<f64> = position.values.iter().map(|value| value * metres).collect();
    let velocity = interval_rules::velocity(&Series {
        time_s: &times_s(position),
        values: &values,
    });
    FineCourse {
        interval_s: position.interval_s,
        values: velocity,
    }
}

/// Returns the longest time for which a velocity in m/s keeps to a range of speeds, such as `40 to 60 mm/s`, in one direction, s.
pub(crate) fn longest_stroke_s(velocity: &FineCourse, speeds: &str) -> f64 {
    let Ok(rule) = Rule::parse(&format!("{speeds} for {SHORTEST}")) else {
        return 0.0;
    };
    let (time_s, values) = (times_s(velocity), &velocity.values);
    let series = Series {
        time_s: &time_s,
        values,
    };
    let strokes = rule.explorations(&series, &series).into_iter();
    let lengths = strokes.map(|stroke| stroke.span.to_s - stroke.span.from_s);
    lengths.fold(0.0, f64::max)
}

/// Returns whether a rule of the normal force holds anywhere among `values` in N at the times of `fine`.
pub(crate) fn ever_holds(fine: &FineCourse, values: &[f64], rule: &str) -> bool {
    let time_s = times_s(fine);
    let series = Series {
        time_s: &time_s,
        values,
    };
    Rule::parse(rule).is_ok_and(|rule| !rule.spans(&series).is_empty())
}

fn times_s(fine: &FineCourse) -> Vec<f64> {
    let count = fine.values.len();
    (0..count).map(|n| n as f64 * fine.interval_s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_has_its_speed_for_its_time() {
        // 2 s of rest, 1.5 s at 20 mm/s, rest; 400 Hz, in mm.
        let values = (0..2_000).map(|n| 20.0 * (f64::from(n) / 400.0 - 2.0).clamp(0.0, 1.5));
        let position = FineCourse {
            interval_s: 1.0 / 400.0,
            values: values.collect(),
        };
        let speed = velocity(&position, 1e-3);
        let stroke_s = longest_stroke_s(&speed, "14 to 26 mm/s");
        assert!((stroke_s - 1.5).abs() < 0.05, "{stroke_s}");
        assert!(longest_stroke_s(&speed, "50 to 100 mm/s") < 0.02);
        let force = position.values.clone();
        assert!(ever_holds(&position, &force, "normal < 1 N for 1.9 s"));
        assert!(!ever_holds(&position, &force, "normal > 31 N for 0.1 s"));
    }
}
