//! Positions of a sliding finger, and the sign of its friction.

use recording::{ForceRow, PositionRow};
use statistics::{median, quantile};

use crate::implausible::Implausible;

/// Share of the way at each end of an exploration in which the finger starts and stops.
const WAY_SHARE: f64 = 0.1;
/// Longest travel on a plate, m, and greatest speed of an exploring finger, m/s.
const LONGEST_TRAVEL_M: f64 = 1.0;
const GREATEST_SPEED_M_PER_S: f64 = 2.0;
/// Share of a slide at each end in which the finger starts and stops.
const END_SHARE: f64 = 0.1;
/// Fewest positions of a slide.
const FEWEST: usize = 10;
/// Share of the lateral force's readings on either side of zero above which its sign is certain.
const CERTAIN_SHARE: f64 = 0.7;
/// Share of the readings of slides there and back that have one sign where it was lost.
const UNTURNED_SHARE: f64 = 0.95;

/// Modulation index from which on the plate is nearly at rest once in a period.
const LEAST_INDEX: f64 = 0.5;

/// Returns whether a plate is nearly at rest once in a period of a modulation of this index, so that friction returns in each.
#[must_use]
pub fn rests(modulation_index: f64) -> bool {
    modulation_index >= LEAST_INDEX
}

/// Slide of a finger over the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slide {
    /// Whether the position grows, as the recording states it.
    pub grows: bool,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

impl Slide {
    /// Returns start and end without the parts in which the finger starts and stops, s.
    pub(crate) fn middle_s(&self) -> (f64, f64) {
        let margin_s = END_SHARE * (self.end_s - self.start_s);
        (self.start_s + margin_s, self.end_s - margin_s)
    }

    /// Returns the finite positions between the parts in which the finger starts and stops.
    pub(crate) fn rows<'a>(
        &self,
        rows: &'a [PositionRow],
    ) -> impl DoubleEndedIterator<Item = &'a PositionRow> + Clone + use<'a> {
        let (start_s, end_s) = self.middle_s();
        let start = rows.partition_point(|row| row.time_s < start_s);
        let end = rows.partition_point(|row| row.time_s <= end_s);
        let inside = rows.get(start..end).unwrap_or_default();
        inside.iter().filter(|row| row.position_m.is_finite())
    }

    /// Returns the way that the finger goes, m, and its mean speed, m/s; `None` with too few positions.
    pub(crate) fn way(&self, rows: &[PositionRow]) -> Option<(f64, f64)> {
        let mut inside = self.rows(rows);
        let count = inside.clone().count();
        let (first, last) = (inside.next()?, inside.next_back()?);
        let way_m = last.position_m - first.position_m;
        let time_s = last.time_s - first.time_s;
        (count >= FEWEST && time_s > 0.0).then_some((way_m, way_m / time_s))
    }
}

/// Returns the implausible positions among `rows`.
#[must_use]
pub fn positions(rows: &[PositionRow], slides: &[Slide]) -> Vec<Implausible> {
    let ways: Vec<(bool, f64, f64)> = slides
        .iter()
        .filter_map(|slide| {
            slide
                .way(rows)
                .map(|(way_m, speed)| (slide.grows, way_m, speed))
        })
        .collect();
    let Some(travel_m) = ways.iter().map(|way| way.1.abs()).reduce(f64::max) else {
        return Vec::new();
    };
    let speed_m_per_s = median(ways.iter().map(|way| way.2.abs())).unwrap_or_default();
    if travel_m == 0.0 {
        return vec![Implausible::PositionStill];
    }
    let mut findings = Vec::new();
    if travel_m > LONGEST_TRAVEL_M || speed_m_per_s > GREATEST_SPEED_M_PER_S {
        findings.push(Implausible::PositionUnit {
            travel_m,
            speed_m_per_s,
        });
    }
    let agrees = |way: &&(bool, f64, f64)| way.0 == (way.1 > 0.0);
    if !ways.iter().any(|way| agrees(&way)) {
        findings.push(Implausible::Backwards);
    }
    findings
}

/// Returns the finding of a lateral force with the wrong sign in all slides, or with one sign in slides there and back; `rows` are taken
/// against the zero.
#[must_use]
pub fn lateral_sign(rows: &[ForceRow], slides: &[Slide], contact_n: f64) -> Option<Implausible> {
    let sides = slides.iter().filter_map(|slide| {
        let (start_s, end_s) = slide.middle_s();
        let is_inside = |row: &&ForceRow| {
            (start_s..=end_s).contains(&row.time_s)
                && row.normal_n >= contact_n
                && row.lateral_n.is_finite()
        };
        let lateral = rows.iter().filter(is_inside).map(|row| row.lateral_n);
        let mut lateral: Vec<f64> = lateral.collect();
        lateral.sort_by(f64::total_cmp);
        let sign = |share: f64| {
            let (low, high) = (quantile(&lateral, 1.0 - share)?, quantile(&lateral, share)?);
            Some(f64::from(i8::from(low > 0.0) - i8::from(high < 0.0)))
        };
        let signs = (sign(CERTAIN_SHARE)?, sign(UNTURNED_SHARE)?);
        (lateral.len() >= FEWEST).then_some((slide.grows, signs))
    });
    let sides: Vec<(bool, (f64, f64))> = sides.collect();
    let &(_, (_, first)) = sides.first()?;
    let is_against =
        |(grows, signs): &(bool, (f64, f64))| signs.0 == if *grows { -1.0 } else { 1.0 };
    if sides.iter().all(is_against) {
        return Some(Implausible::LateralSign);
    }
    let has = |grows: bool| sides.iter().any(|side| side.0 == grows);
    let is_unturned = first != 0.0 && sides.iter().all(|(_, signs)| signs.1 == first);
    (is_unturned && has(true) && has(false)).then_some(Implausible::LateralUnsigned)
}

/// Returns the parts of explorations in which the finger is on its way: without the first and the last tenth of it.
#[must_use]
pub fn moving_s(rows: &[PositionRow], spans_s: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let moving = |&(start_s, end_s): &(f64, f64)| {
        let start = rows.partition_point(|row| row.time_s < start_s);
        let end = rows.partition_point(|row| row.time_s < end_s);
        let inside = rows.get(start..end).unwrap_or_default();
        let (Some(first), Some(last)) = (inside.first(), inside.last()) else {
            return (start_s, end_s);
        };
        let way_m = last.position_m - first.position_m;
        let passed_s = |share: f64| {
            let is_past = |row: &&PositionRow| (row.position_m - first.position_m) / way_m >= share;
            inside.iter().find(is_past).map(|row| row.time_s)
        };
        let moving_s = passed_s(WAY_SHARE).zip(passed_s(1.0 - WAY_SHARE));
        moving_s
            .filter(|(from_s, to_s)| from_s < to_s)
            .unwrap_or((start_s, end_s))
    };
    spans_s.iter().map(moving).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A finger that slides by 85 mm from 1 to 2.7 s and back from 3 to 4.7 s.
    fn rows(scale: f64) -> Vec<PositionRow> {
        let row = |step: u32| {
            let time_s = f64::from(step) * 1e-3;
            let forth = ((time_s - 1.0) / 1.7).clamp(0.0, 1.0);
            let back = ((time_s - 3.0) / 1.7).clamp(0.0, 1.0);
            PositionRow {
                time_s,
                position_m: scale * (0.01 + 0.085 * (forth - back)),
            }
        };
        (0..5000).map(row).collect()
    }

    fn slides() -> [Slide; 2] {
        [(true, 1.0, 2.7), (false, 3.0, 4.7)].map(|(grows, start_s, end_s)| Slide {
            grows,
            start_s,
            end_s,
        })
    }

    #[test]
    fn units_directions_and_still_positions_are_named() {
        assert_eq!(positions(&rows(1.0), &slides()), []);
        assert_eq!(positions(&[], &slides()), []);
        assert_eq!(positions(&rows(-1.0), &slides()), [Implausible::Backwards]);
        assert_eq!(
            positions(&rows(0.0), &slides()),
            [Implausible::PositionStill]
        );
        for (scale, unit) in [
            (1e3, "millimetres: divide by 1000"),
            (1e2, "centimetres"),
            (2e8, "counts"),
        ] {
            let [found] = &positions(&rows(scale), &slides())[..] else {
                panic!("{scale}");
            };
            assert!(found.to_string().contains(unit), "{found}");
            assert!(found.spoils_estimates());
        }
        // A finger that turns round in one slide, or goes one way only, contradicts nothing.
        let one = [
            Slide {
                grows: false,
                ..slides()[0]
            },
            slides()[1],
        ];
        assert_eq!(positions(&rows(1.0), &one), []);
    }

    #[test]
    fn friction_against_every_slide_is_named() {
        let forces = |sign: f64| -> Vec<ForceRow> {
            let row = |step: u32| {
                let time_s = f64::from(step) * 1e-3;
                let direction = if time_s < 2.85 { sign } else { -sign };
                let friction = 0.3 * (1.0 + (40.0 * time_s).sin());
                ForceRow {
                    time_s,
                    normal_n: 0.6,
                    lateral_n: 0.6 * direction * friction,
                }
            };
            (0..5000).map(row).collect()
        };
        assert_eq!(lateral_sign(&forces(1.0), &slides(), 0.1), None);
        assert_eq!(
            lateral_sign(&forces(-1.0), &slides(), 0.1),
            Some(Implausible::LateralSign)
        );
        assert_eq!(
            lateral_sign(&forces(-1.0), &slides(), 1.0),
            None,
            "no contact"
        );
        let identical = [
            Slide {
                grows: true,
                ..slides()[1]
            },
            slides()[0],
        ];
        assert_eq!(
            lateral_sign(&forces(-1.0), &identical, 0.1),
            None,
            "one of two directions"
        );
    }

    #[test]
    fn a_force_that_does_not_turn_with_the_finger_lost_its_sign() {
        let forces = |lateral: fn(f64, f64) -> f64| -> Vec<ForceRow> {
            let row = |step: u32| {
                let time_s = f64::from(step) * 1e-3;
                let direction = if time_s < 2.85 { 1.0 } else { -1.0 };
                let friction = 0.3 * (1.02 + (40.0 * time_s).sin());
                ForceRow {
                    time_s,
                    normal_n: 0.6,
                    lateral_n: lateral(0.6, 0.6 * direction * friction),
                }
            };
            (0..5000).map(row).collect()
        };
        let lost = Some(Implausible::LateralUnsigned);
        for (lateral, expected) in [
            ((|_, lateral| lateral) as fn(f64, f64) -> f64, None),
            (|_, lateral| lateral.abs(), lost.clone()),
            (|_, lateral| -lateral.abs(), lost.clone()),
            (f64::hypot, lost),
            // Crosstalk and a zero that is off turn all the same.
            (|normal, lateral| lateral + 0.2 * normal, None),
            (|_, lateral| lateral + 0.1, None),
        ] {
            assert_eq!(lateral_sign(&forces(lateral), &slides(), 0.1), expected);
        }
    }
}
