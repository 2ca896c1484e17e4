//! Plausibility of readings: forces that no finger makes, and channels read at a fraction of their scale.
//!
//! A recording made elsewhere may contain millinewtons under `normal_n`, or the sensor's own sign. The estimates would be wrong
//! by that factor, and some of them would still converge.

mod cells;
mod channel;
pub mod clipped;
mod columns;
mod consequences;
mod course;
mod drift;
mod encoder;
mod equal_tail;
mod extremes;
mod filtered_envelopes;
mod friction_fit;
mod friction_split;
mod frictionless_slide;
mod gap;
mod held;
mod implausible;
mod interpolated;
mod jump;
mod lag;
mod largest_drive;
mod lateral_alone;
mod lateral_evidence;
mod lateral_times;
mod level_jump;
mod modulation_jump;
mod motion;
mod moved_zero;
mod plate;
mod quantity;
mod repeated;
mod rest_spectrum;
mod roughness;
mod signal_jumps;
mod stray;
mod strokes;
mod tone;
mod units;
mod unloaded;
mod wrapped;
pub mod zero_stretch;

use recording::ForceRow;

pub use channel::Channel;
pub use columns::mixed_columns;
pub use course::{Course, amplitude, light_touch, off_course, small_forces};
pub use encoder::position_jumps;
pub use equal_tail::EqualTail;
pub use extremes::{Clipping, Extremes};
pub use filtered_envelopes::filtered_envelopes;
pub use friction_fit::friction_fit;
pub use friction_split::FrictionSplit;
pub use gap::force_gap;
pub use held::remove_held_forces;
pub use implausible::Implausible;
pub use interpolated::interpolated;
pub use lateral_evidence::LateralEvidence;
pub use lateral_times::lateral_times;
pub use motion::{Slide, lateral_sign, moving_s, positions, rests};
pub use moved_zero::{MovedZero, moved_zero};
pub use plate::{amplitude_dependence, envelopes, is_of_scale, pickup_quantity, plate_scale};
pub use quantity::Quantity;
pub use repeated::repeated;
pub use rest_spectrum::at_rest;
pub use roughness::{RoughnessError, roughness};
pub use signal_jumps::{level_jump, lost_samples};
pub use stray::{remove_stray_forces, remove_stray_positions, stray_readings};
pub use strokes::{StrokeFriction, friction_jumps, strokes_differ};
pub use tone::without_carrier;
pub use units::LARGEST_N;
use units::{CONTACT_AREA_M2, FRICTION};
pub use unloaded::UnloadedFinger;
pub use wrapped::wrapped;

/// Smallest force of a finger that touches, N.
const SMALLEST_N: f64 = 1e-3;
/// Fewest readings from which a force is judged.
const FEWEST: usize = 50;
/// Share of the readings beyond the quantile that stands for the pressing finger.
const TAIL: f64 = 0.1;
/// Ratio of the pull to the push above which the normal force has the other sign.
const OPPOSITE: f64 = 5.0;
/// Largest distance of a carrier from the plate's resonance, relative; at Q = 200 the plate moves a quarter as far there.
const CARRIER_DISTANCE: f64 = 0.01;
/// Share of full scale that 24-bit samples reach if they are read as 32-bit ones.
const SMALL_SHARE: f32 = 1.0 / 256.0;

/// Greatest ratio of the friction at the greatest stimulus to that at the least.
const GREATEST_RISE: f64 = 10.0;
/// Largest crosstalk between the axes of a sensor, N/N, three standard errors of that which is assumed.
const LARGEST_CROSSTALK: f64 = 0.075;

/// Readings of a barometer in mmHg up to 900 m above the sea.
const MMHG: [f64; 2] = [680.0, 800.0];

/// Value of a column in a row.
type Column = fn(&ForceRow) -> f64;

/// Returns the implausible forces among `rows`, which a finger made in `explorations_s` and not in `unloaded_s`; it moved in
/// `slides_s`.
#[must_use]
pub fn forces(
    rows: &[ForceRow],
    explorations_s: &[(f64, f64)],
    slides_s: &[(f64, f64)],
    unloaded_s: &[(f64, f64)],
) -> Vec<Implausible> {
    let columns: [(&str, Column); 2] = [
        ("normal_n", |row| row.normal_n),
        ("lateral_n", |row| row.lateral_n),
    ];
    let constants = columns.map(|(column, value)| constant(rows, column, value));
    let [is_normal_constant, is_lateral_constant] = [0, 1].map(|axis| constants[axis].is_some());
    let mut findings: Vec<Implausible> = constants.into_iter().flatten().collect();
    findings.extend(
        columns
            .iter()
            .filter_map(|(column, value)| clipped(rows, column, *value)),
    );
    let readings = |spans_s: &[(f64, f64)], value: Column| {
        let is_inside = |row: &&ForceRow| {
            let mut spans = spans_s.iter();
            spans.any(|(start_s, end_s)| (*start_s..=*end_s).contains(&row.time_s))
        };
        let values = rows.iter().filter(is_inside).map(value);
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let unloaded_n = |value: Column| statistics::quantile(&readings(unloaded_s, value), 0.5);
    let touched = readings(explorations_s, columns[0].1);
    let far_n = unloaded_n(columns[0].1).filter(|normal_n| unloaded::is_far(*normal_n, &touched));
    if let Some(normal_n) = far_n.filter(|_| touched.len() >= FEWEST) {
        let unloaded = readings(unloaded_s, columns[0].1);
        let all = readings(&[(f64::NEG_INFINITY, f64::INFINITY)], columns[0].1);
        // Signs and sizes are relative to a zero that the recording does not show.
        findings.push(match unloaded::finger(&unloaded, &touched, &all) {
            Some(evidence) => Implausible::FingerUnloaded { normal_n, evidence },
            None => Implausible::Untared { normal_n },
        });
        return findings;
    }
    // A finger that rests has little friction.
    let under_finger = [(explorations_s, columns[0].1), (slides_s, columns[1].1)];
    let [normal, lateral] = under_finger.map(|(spans_s, value)| {
        let zero_n = unloaded_n(value).unwrap_or_default();
        let mut forces_n = readings(spans_s, value);
        forces_n.iter_mut().for_each(|force_n| *force_n -= zero_n);
        forces_n
    });
    if normal.len() < FEWEST || is_normal_constant {
        return findings;
    }
    let quantile = |values: &[f64], share| statistics::quantile(values, share).unwrap_or_default();
    let (pull_n, push_n) = (quantile(&normal, TAIL), quantile(&normal, 1.0 - TAIL));
    let press_n = push_n.max(-pull_n);
    if press_n > SMALLEST_N && push_n < -pull_n / OPPOSITE {
        findings.push(Implausible::Sign { normal_n: pull_n });
    }
    if !(SMALLEST_N..=LARGEST_N).contains(&press_n) {
        findings.push(Implausible::Size { normal_n: press_n });
        return findings;
    }
    let friction_n = quantile(&lateral, 1.0 - TAIL).max(-quantile(&lateral, TAIL));
    let ratio = friction_n / press_n;
    let [least, most] = FRICTION;
    if lateral.len() >= FEWEST && !is_lateral_constant && !(least..=most).contains(&ratio) {
        findings.push(Implausible::Friction { ratio });
    }
    findings
}

/// Returns the finding of a contact area that no finger has.
#[must_use]
pub fn contact_area(area_m2: f64) -> Option<Implausible> {
    let [least_m2, most_m2] = CONTACT_AREA_M2;
    (!(least_m2..=most_m2).contains(&area_m2)).then_some(Implausible::ContactArea { area_m2 })
}

/// Returns the finding of a column that has one value in all its rows.
fn constant(rows: &[ForceRow], column: &'static str, value: Column) -> Option<Implausible> {
    let mut values = rows.iter().map(value).filter(|value| value.is_finite());
    let first = values.next()?;
    let (rows, is_constant) = values.fold((1, true), |(rows, is_constant), value| {
        (rows + 1, is_constant && value == first)
    });
    (is_constant && rows >= FEWEST).then_some(Implausible::Constant {
        column: column.into(),
        value: first,
        rows,
    })
}

/// Returns the finding of a column that was cut off at the end of a range.
fn clipped(rows: &[ForceRow], column: &'static str, value: Column) -> Option<Implausible> {
    let values: Vec<f64> = rows.iter().map(value).collect();
    let limit = clipped::limit(&values)?;
    Some(Implausible::Clipped {
        column: column.into(),
        limit_n: limit.value,
        rows: limit.count,
    })
}

/// Returns the finding of a carrier far from the plate's resonance.
#[must_use]
pub fn carrier(carrier_hz: f64, resonance_hz: f64) -> Option<Implausible> {
    let is_off = (carrier_hz / resonance_hz - 1.0).abs() > CARRIER_DISTANCE;
    is_off.then_some(Implausible::Carrier {
        carrier_hz,
        resonance_hz,
    })
}

/// Returns the finding of a friction at the least stimulus that is many times smaller than at the greatest: electroadhesion, the strongest
/// stimulus that raises friction, does so up to some five times.
#[must_use]
pub fn stimulus(mu_at_least: f64, mu_at_greatest: f64) -> Option<Implausible> {
    (mu_at_greatest > GREATEST_RISE * mu_at_least).then_some(Implausible::StimulusUpsideDown {
        mu_at_least,
        mu_at_greatest,
    })
}

/// Returns the finding of a crosstalk from the normal to the lateral force beyond that of a sensor's axes.
#[must_use]
pub fn crosstalk(per_normal: f64) -> Option<Implausible> {
    (per_normal > LARGEST_CROSSTALK).then_some(Implausible::Crosstalk { per_normal })
}

/// Returns the finding of an ambient pressure that a barometer in millimetres of mercury reads near the sea.
#[must_use]
pub fn pressure(pressure_hpa: f64) -> Option<Implausible> {
    let [least, most] = MMHG;
    (least..=most)
        .contains(&pressure_hpa)
        .then_some(Implausible::Pressure { pressure_hpa })
}

/// Returns the finding of a channel with `level` as its largest |sample|, as a share of full scale.
#[must_use]
pub fn channel(name: &str, level: f32) -> Option<Implausible> {
    (level > 0.0 && level < SMALL_SHARE).then(|| Implausible::SmallShare {
        channel: name.to_owned(),
        level,
    })
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows at 1 kHz of a finger that presses with about 0.7 N from 1 to 3 s, scaled.
    fn rows(normal_scale: f64, lateral_scale: f64) -> Vec<ForceRow> {
        let row = |i: u32| {
            let time_s = f64::from(i) * 1e-3;
            let ripple = 1.0 + 0.2 * (40.0 * time_s).sin();
            let press_n = if time_s < 1.0 {
                0.001 * ripple
            } else {
                0.7 * ripple
            };
            ForceRow {
                time_s,
                normal_n: normal_scale * press_n,
                lateral_n: lateral_scale * 0.5 * press_n,
            }
        };
        (0..3000).map(row).collect()
    }

    fn words(rows: &[ForceRow]) -> String {
        let findings = forces(rows, &[(1.0, 3.0)], &[(1.0, 3.0)], &[(0.0, 0.9)]);
        let words: Vec<String> = findings.iter().map(ToString::to_string).collect();
        words.join("\n")
    }

    #[test]
    fn a_finger_that_rests_before_it_slides_has_the_friction_of_its_slide() {
        let mut rows = rows(1.0, 1.0);
        rows[..2850].iter_mut().for_each(|row| row.lateral_n = 0.0);
        let found = |slide_s| forces(&rows, &[(1.0, 3.0)], &[slide_s], &[(0.0, 0.9)]);
        assert_eq!(found((2.86, 3.0)), []);
        assert!(matches!(
            found((1.0, 3.0))[..],
            [Implausible::Friction { .. }]
        ));
    }

    #[test]
    fn the_forces_of_a_finger_are_plausible_with_any_zero() {
        assert_eq!(words(&rows(1.0, 1.0)), "");
        assert_eq!(words(&rows(0.1, -0.1)), "", "a light touch, to the left");
        let mut shifted = rows(1.0, 1.0);
        shifted.iter_mut().for_each(|row| row.normal_n -= 30.0);
        let shifted = words(&shifted);
        assert!(
            shifted.contains("reads -29.999 N in the intervals without a finger")
                && !shifted.contains("multiply it by"),
            "{shifted}"
        );
        let touch = &rows(1e3, 1e3)[990..1030];
        assert_eq!(words(touch), "", "too few readings");
    }

    #[test]
    fn a_finger_in_the_unloaded_intervals_is_no_zero_of_the_sensor() {
        let steady = |row: &mut ForceRow| {
            if row.time_s < 0.9 {
                row.normal_n = 0.5 + 0.001 * (97.0 * row.time_s).sin();
            }
        };
        let mut lifted = rows(1.0, 1.0);
        lifted.iter_mut().for_each(steady);
        let elsewhere = words(&lifted);
        assert!(
            elsewhere.contains("N elsewhere: a finger was on the plate")
                && !elsewhere.contains("untared"),
            "{elsewhere}"
        );
        let mut unsteady = rows(1.0, 1.0);
        for row in &mut unsteady {
            if row.time_s < 1.0 {
                row.normal_n = 0.6 + 0.1 * (7.0 * row.time_s).sin();
            }
        }
        let unsteady = words(&unsteady);
        assert!(unsteady.contains("and varies there by"), "{unsteady}");
        for zero_n in [0.5, -0.5, -0.9, 2.0] {
            let mut untared = rows(1.0, 1.0);
            untared.iter_mut().for_each(|row| row.normal_n += zero_n);
            let untared = words(&untared);
            assert!(untared.contains("it is untared"), "{zero_n}: {untared}");
        }
    }

    #[test]
    fn another_unit_is_named_with_its_remedy() {
        for (scale, unit) in [
            (1e3, "millinewtons: divide by 1000"),
            (101.97, "grams: multiply by 0.00980665"),
            (1e-3, "kilonewtons: multiply by 1000"),
            (8.4e12, "counts"),
        ] {
            let words = words(&rows(scale, scale));
            assert!(words.contains(unit), "{scale}: {words}");
            assert!(!words.contains("negative"), "{words}");
        }
        let both = words(&rows(-1e3, 1e3));
        assert!(
            both.contains("millinewtons") && both.contains("multiply it by -1"),
            "{both}"
        );
    }

    #[test]
    fn another_sign_a_constant_column_and_an_impossible_friction_are_named() {
        assert!(words(&rows(-1.0, 1.0)).contains("multiply it by -1"));
        assert!(words(&rows(1.0, 1e3)).contains("lateral_n is"));
        let mut constant = rows(1.0, 1.0);
        constant.iter_mut().for_each(|row| row.lateral_n = 0.25);
        assert!(words(&constant).contains("lateral_n is 0.25 in each of 3000 rows"));
    }

    #[test]
    fn friction_that_vanishes_without_a_stimulus_is_named() {
        assert_eq!(stimulus(0.8, 0.01), None, "levitation");
        assert_eq!(stimulus(0.2, 1.0), None, "electroadhesion");
        let found = stimulus(0.0075, 0.84).unwrap();
        assert!(
            found.to_string().contains("0.0075 at the least stimulus"),
            "{found}"
        );
        assert!(!found.spoils_estimates());
    }

    #[test]
    fn a_pressure_in_mmhg_is_named_and_one_in_hpa_is_not() {
        for pressure_hpa in [500.0, 850.0, 1013.25, 1100.0] {
            assert_eq!(pressure(pressure_hpa), None, "{pressure_hpa}");
        }
        let text = pressure(760.0).unwrap().to_string();
        assert!(
            text.contains("2360 m above the sea") && text.contains("760 mmHg are 1013 hPa"),
            "{text}"
        );
        assert!(!pressure(760.0).unwrap().spoils_estimates());
    }

    #[test]
    fn a_channel_below_a_256th_of_full_scale_is_named() {
        assert_eq!(channel("pickup", 0.3), None);
        assert_eq!(channel("pickup", 0.0), None, "silence");
        let finding = channel("pickup", 0.3 / 256.0).unwrap();
        assert!(
            finding.to_string().contains("1/853 of full scale"),
            "{finding}"
        );
        assert!(!finding.spoils_estimates());
    }
}
