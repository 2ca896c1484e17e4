//! Scales of streams by their units and sizes, and the rule of explorations by the speeds.

use crate::map_text::{Reason, check, sure};
use crate::names::{self, UnitMeaning};
use crate::nature::{Nature, grouped};
use crate::portrait::VectorPortrait;
use crate::slow::Slow;

/// Returns the unit, empty without one.
pub(crate) fn unit(vector: &VectorPortrait) -> String {
    vector.unit_text().unwrap_or_default()
}

/// Returns the quantity of a pickup, and its scale in SI units if the unit states it.
pub(crate) fn pickup_scale(vector: &VectorPortrait) -> (&'static str, Option<f64>, Reason) {
    let stated = || sure(format!("stated in {}", unit(vector)));
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(scale)) => ("displacement", Some(scale), stated()),
        Some(UnitMeaning::MetresPerSecond(scale)) => ("velocity", Some(scale), stated()),
        Some(UnitMeaning::MetresPerSquareSecond(scale)) => ("acceleration", Some(scale), stated()),
        Some(UnitMeaning::Coulombs(_)) => ("charge", None, stated()),
        _ => {
            let words = names::words(&names::leaf(&vector.name)).concat();
            let by_name = |parts: &[&str]| parts.iter().any(|part| words.contains(part));
            if by_name(&["vel", "ldv", "vibrometer", "polytec"]) {
                (
                    "velocity",
                    None,
                    check("by its name; a vibrometer may also give displacement"),
                )
            } else if by_name(&["acc"]) {
                ("acceleration", None, check("by its name"))
            } else {
                (
                    "displacement",
                    None,
                    check("no unit is stated: displacement, velocity, acceleration or charge"),
                )
            }
        }
    }
}

/// Returns newtons per unit with the sign that makes pressing positive.
pub(crate) fn newtons(vector: &VectorPortrait, is_upside_down: Option<bool>) -> (f64, Reason) {
    let sign = if is_upside_down == Some(true) {
        -1.0
    } else {
        1.0
    };
    let direction = match is_upside_down {
        Some(true) => "; it falls at contact, so its sign is turned",
        Some(false) => "",
        None => "; its direction is not seen",
    };
    match vector.unit_meaning() {
        Some(UnitMeaning::Newtons(scale)) => {
            let text = format!("stated in {}{direction}", unit(vector));
            (
                sign * scale,
                Reason {
                    text,
                    is_sure: is_upside_down.is_some(),
                },
            )
        }
        Some(UnitMeaning::Volts(_)) => (
            sign,
            check(format!(
                "stated in {}: write the sensor's newtons per volt{direction}",
                unit(vector)
            )),
        ),
        _ => {
            let largest = vector.extremes.as_ref().map_or(0.0, |extremes| {
                extremes.greatest.abs().max(extremes.least.abs())
            });
            let text = format!(
                "no unit is stated; its largest value is {}{direction}",
                statistics::significant(largest)
            );
            (sign, check(text))
        }
    }
}

pub(crate) fn has_force_unit(vector: &VectorPortrait) -> bool {
    matches!(vector.unit_meaning(), Some(UnitMeaning::Newtons(_)))
}

/// Returns metres, or m/s, per unit.
pub(crate) fn metres(vector: &VectorPortrait, is_velocity: bool) -> (f64, Reason) {
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(scale)) if !is_velocity => (
            scale,
            sure(format!(
                "stated in {}; left to right is growing position",
                unit(vector)
            )),
        ),
        Some(UnitMeaning::MetresPerSecond(scale)) if is_velocity => {
            (scale, sure(format!("stated in {}", unit(vector))))
        }
        _ => match &vector.nature {
            Nature::Slow(Slow::Counts(counts)) => {
                let text = format!(
                    "counts of an encoder over {} counts: write the metres of one",
                    grouped(counts.travel.range).replace('\u{a0}', " ")
                );
                (1e-6, check(text))
            }
            _ => {
                let range = vector
                    .extremes
                    .as_ref()
                    .map_or(0.0, |extremes| extremes.greatest - extremes.least);
                // A finger travels 1 to 50 cm, at up to 0.5 m/s.
                match range {
                    range if (0.01..=1.0).contains(&range) => (
                        1.0,
                        check(format!(
                            "no unit is stated; its range of {range:.3} is that of metres"
                        )),
                    ),
                    range if (10.0..=1_000.0).contains(&range) => (
                        1e-3,
                        check(format!(
                            "no unit is stated; its range of {range:.1} is that of millimetres"
                        )),
                    ),
                    range => (
                        1.0,
                        check(format!(
                            "no unit is stated; its range is {}",
                            statistics::significant(range)
                        )),
                    ),
                }
            }
        },
    }
}

/// Parts of a course over which a speed is taken: few enough for a stroke, many for even counts of samples.
const SPEED_PARTS: usize = 8;
/// Speeds of a rule about the median speed of the strokes.
const SPEED_BAND: (f64, f64) = (0.7, 1.3);

/// Returns the rule of explorations by the speed of the strokes.
pub(crate) fn exploration(vector: &VectorPortrait, is_velocity: bool) -> (String, Reason) {
    let default = || {
        (
            "40 to 60 mm/s for 0.5 s".to_owned(),
            check("the speeds of the published study: write those of your strokes"),
        )
    };
    let (scale, scale_reason) = metres(vector, is_velocity);
    let Some(rate_hz) = vector.rate_hz() else {
        return default();
    };
    let part_s = vector.length as f64 / rate_hz / vector.course.len().max(1) as f64;
    let speeds: Vec<f64> = match is_velocity {
        true => vector.course.iter().map(|v| (v * scale).abs()).collect(),
        false => vector
            .course
            .windows(SPEED_PARTS + 1)
            .map(|parts| {
                ((parts[SPEED_PARTS] - parts[0]) * scale / part_s / SPEED_PARTS as f64).abs()
            })
            .collect(),
    };
    let fastest = speeds
        .iter()
        .copied()
        .filter(|speed| speed.is_finite())
        .fold(0.0, f64::max);
    let moving = speeds.into_iter().filter(|speed| *speed > 0.2 * fastest);
    let Some(median) = statistics::median(moving).filter(|median| (1e-6..=2.0).contains(median))
    else {
        return default();
    };
    let mm = |share: f64| two_digits(1e3 * share * median);
    let rule = format!(
        "{} to {} mm/s for 0.5 s",
        mm(SPEED_BAND.0),
        mm(SPEED_BAND.1)
    );
    let text = format!(
        "the strokes' median speed is {} mm/s",
        two_digits(1e3 * median)
    );
    (
        rule,
        Reason {
            text,
            is_sure: scale_reason.is_sure,
        },
    )
}

pub(crate) fn two_digits(value: f64) -> String {
    statistics::significant(format!("{value:.1e}").parse().unwrap_or(value))
}
