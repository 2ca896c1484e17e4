//! Scales of streams by their units and sizes, and the rule of explorations by the speeds.

use crate::excerpt::FineCourse;
use crate::map_text::{Reason, check, sure};
use crate::name_parts;
use crate::nature::{Nature, grouped};
use crate::portrait::VectorPortrait;
use crate::slow::Slow;
use crate::trial;
use crate::units::{FREE_FALL_M_PER_S2, UnitMeaning};

/// Returns the unit, empty without one.
pub(crate) fn unit(vector: &VectorPortrait) -> String {
    vector.unit_text().unwrap_or_default()
}

/// Returns a stated scale with the factor that attributes state, and the reason.
pub(crate) fn scaled(vector: &VectorPortrait, scale: f64, text: String) -> (f64, Reason) {
    match &vector.scaling {
        Some(scaling) => {
            let factor = scale * scaling.factor;
            let text = format!("{text}, times {} of the array", scaling.text);
            match scaling.is_sure {
                true => (factor, sure(text)),
                false => (
                    factor,
                    check(format!(
                        "{text}: is the product right, and not applied already?"
                    )),
                ),
            }
        }
        None if vector.is_whole && vector.element.contains("int") => (
            scale,
            check(format!(
                "{text}, but its values are whole numbers and no attribute states a scale: write the {} of one count",
                unit(vector)
            )),
        ),
        None => (scale, sure(text)),
    }
}

/// Returns the factor that attributes state; 1 without one.
fn factor(vector: &VectorPortrait) -> f64 {
    vector
        .scaling
        .as_ref()
        .map_or(1.0, |scaling| scaling.factor)
}

/// Returns the text about a unit that is none of a stream's quantity.
fn no_unit(vector: &VectorPortrait, quantity: &str) -> String {
    match vector.unit_text() {
        Some(unit) => format!("stated in {unit}, which is no {quantity}"),
        None => "no unit is stated".to_owned(),
    }
}

/// Returns the quantity of a pickup, and its scale in SI units if the unit states it, each with the reason.
pub(crate) fn pickup_scale(
    vector: &VectorPortrait,
) -> (&'static str, Reason, Option<(f64, Reason)>) {
    let stated = || format!("stated in {}", unit(vector));
    let words = name_parts::words(&name_parts::leaf(&vector.name));
    let joined = words.concat();
    let by_name = |parts: &[&str]| parts.iter().any(|part| joined.contains(part));
    let motion = |quantity, scale| {
        (
            quantity,
            sure(stated()),
            Some(scaled(vector, scale, stated())),
        )
    };
    let is_in_g = unit(vector) == "g" || words.last().is_some_and(|word| word == "g");
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(scale)) => motion("displacement", scale),
        Some(UnitMeaning::MetresPerSecond(scale)) => motion("velocity", scale),
        Some(UnitMeaning::MetresPerSquareSecond(scale)) => motion("acceleration", scale),
        Some(UnitMeaning::Coulombs(_)) => ("charge", sure(stated()), None),
        _ if is_in_g && by_name(&["acc"]) => (
            "acceleration",
            check("by its name"),
            Some((
                FREE_FALL_M_PER_S2 * factor(vector),
                check("its name ends in g: free fall, 9.80665 m/s²?"),
            )),
        ),
        _ if by_name(&["vel", "ldv", "vibrometer", "polytec"]) => (
            "velocity",
            check("by its name; a vibrometer may also give displacement"),
            None,
        ),
        _ if by_name(&["acc"]) => ("acceleration", check("by its name"), None),
        _ => {
            let text = format!(
                "{}: displacement, velocity, acceleration or charge",
                no_unit(vector, "motion")
            );
            ("displacement", check(text), None)
        }
    }
}

/// Returns newtons per unit with the sign that makes pressing positive.
pub(crate) fn newtons(vector: &VectorPortrait, is_upside_down: Option<bool>) -> (f64, Reason) {
    // A factor below 0 turns the force too.
    let is_turned = is_upside_down.is_some_and(|upside_down| upside_down != (factor(vector) < 0.0));
    let direction = match (is_upside_down, is_turned) {
        (Some(true), true) => "; it falls at contact, so its sign is turned",
        (Some(true), false) => "; it falls at contact, and its scale turns it",
        (Some(false), true) => "; it rises at contact, so its scale is turned",
        (Some(false), false) => "",
        (None, _) => "; its direction is not seen",
    };
    let sign = if is_turned { -1.0 } else { 1.0 };
    force_scale(vector, sign, direction, is_upside_down.is_some())
}

/// Returns newtons per unit of a lateral force, whose sign turns with the direction.
pub(crate) fn lateral_newtons(vector: &VectorPortrait) -> (f64, Reason) {
    force_scale(vector, 1.0, "; its sign turns with the direction", true)
}

fn force_scale(
    vector: &VectorPortrait,
    sign: f64,
    direction: &str,
    is_direction_sure: bool,
) -> (f64, Reason) {
    match vector.unit_meaning() {
        Some(UnitMeaning::Newtons(scale)) => {
            let (scale, reason) = scaled(vector, scale, format!("stated in {}", unit(vector)));
            (
                sign * scale,
                Reason {
                    text: format!("{}{direction}", reason.text),
                    is_sure: reason.is_sure && is_direction_sure,
                },
            )
        }
        Some(UnitMeaning::Volts(_)) => (
            sign * factor(vector),
            check(format!(
                "stated in {}: write the sensor's newtons per volt{direction}",
                unit(vector)
            )),
        ),
        _ => {
            let largest = vector.extremes.as_ref().map_or(0.0, |extremes| {
                extremes.greatest.abs().max(extremes.least.abs())
            });
            let scaling = vector.scaling.as_ref();
            let scaling = scaling.map_or(String::new(), |scaling| {
                format!(", times {} of the array", scaling.text)
            });
            let text = format!(
                "{}; its largest value is {}{scaling}{direction}",
                no_unit(vector, "force"),
                statistics::significant(largest)
            );
            (sign * factor(vector), check(text))
        }
    }
}

pub(crate) fn has_force_unit(vector: &VectorPortrait) -> bool {
    matches!(vector.unit_meaning(), Some(UnitMeaning::Newtons(_)))
}

/// Returns metres, or m/s, per unit.
pub(crate) fn metres(vector: &VectorPortrait, is_velocity: bool) -> (f64, Reason) {
    let stated = |scale| {
        let (scale, reason) = scaled(vector, scale, format!("stated in {}", unit(vector)));
        let end = if is_velocity {
            ""
        } else {
            "; left to right is growing position"
        };
        let text = format!("{}{end}", reason.text);
        (scale, Reason { text, ..reason })
    };
    match vector.unit_meaning() {
        Some(UnitMeaning::Metres(scale)) if !is_velocity => return stated(scale),
        Some(UnitMeaning::MetresPerSecond(scale)) if is_velocity => return stated(scale),
        Some(UnitMeaning::Pixels) => {
            let text = format!(
                "stated in {}, which is no length: write the metres of one pixel, as a ruler in the picture shows",
                unit(vector)
            );
            return (1e-4 * factor(vector), check(text));
        }
        _ => {}
    }
    if let Nature::Slow(Slow::Counts(counts)) = &vector.nature
        && vector.scaling.is_none()
    {
        let text = format!(
            "counts of an encoder over {} counts: write the metres of one",
            grouped(counts.travel.range).replace('\u{a0}', " ")
        );
        return (1e-6, check(text));
    }
    let range = vector.extremes.as_ref().map_or(0.0, |extremes| {
        factor(vector).abs() * (extremes.greatest - extremes.least)
    });
    let quantity = if is_velocity { "velocity" } else { "length" };
    let text = no_unit(vector, quantity);
    // A finger travels 1 to 50 cm, at up to 0.5 m/s.
    let (scale, text) = match range {
        range if (0.01..=1.0).contains(&range) => (
            1.0,
            format!("{text}; its range of {range:.3} is that of metres"),
        ),
        range if (10.0..=1_000.0).contains(&range) => (
            1e-3,
            format!("{text}; its range of {range:.1} is that of millimetres"),
        ),
        range => (
            1.0,
            format!("{text}; its range is {}", statistics::significant(range)),
        ),
    };
    (scale * factor(vector), check(text))
}

/// Returns whether the scale of a position is a placeholder, with which no speed has a meaning.
fn has_open_scale(vector: &VectorPortrait) -> bool {
    match vector.unit_meaning() {
        Some(UnitMeaning::Pixels) => true,
        Some(UnitMeaning::Metres(_) | UnitMeaning::MetresPerSecond(_)) => false,
        _ => matches!(vector.nature, Nature::Slow(Slow::Counts(_))) && vector.scaling.is_none(),
    }
}

/// Parts of a course over which a speed is taken: few enough for a stroke, many for even counts of samples.
const SPEED_PARTS: usize = 8;
/// Speeds of a rule about the median speed of the strokes.
const SPEED_BAND: (f64, f64) = (0.7, 1.3);

/// Share of the speeds below the fastest one that is no stray.
const FASTEST_SHARE: f64 = 0.998;
/// Durations of a guessed rule, s: the longest that a stroke keeps to.
const DURATIONS_S: [f64; 4] = [0.5, 0.2, 0.1, 0.05];

/// Returns the rule of explorations by the speed of the strokes, tried on them.
pub(crate) fn exploration(vector: &VectorPortrait, is_velocity: bool) -> (String, Reason) {
    let default = |text: &str| ("40 to 60 mm/s for 0.5 s".to_owned(), check(text));
    const STUDY: &str = "the speeds of the published study: write those of your strokes";
    if has_open_scale(vector) {
        return default(
            "the speeds of the published study: write those of your strokes, once the metres of a unit are known",
        );
    }
    let (scale, scale_reason) = metres(vector, is_velocity);
    let Some(rate_hz) = vector.rate_hz() else {
        return default(STUDY);
    };
    let part_s = vector.length as f64 / rate_hz / vector.course.len().max(1) as f64;
    let coarse: Vec<f64> = match is_velocity {
        true => vector.course.iter().map(|v| (v * scale).abs()).collect(),
        false => vector
            .course
            .windows(SPEED_PARTS + 1)
            .map(|parts| {
                ((parts[SPEED_PARTS] - parts[0]) * scale / part_s / SPEED_PARTS as f64).abs()
            })
            .collect(),
    };
    let fine = vector.fine.as_ref().map(|fine| match is_velocity {
        true => FineCourse {
            values: fine.values.iter().map(|value| value * scale).collect(),
            ..fine.clone()
        },
        false => trial::velocity(fine, scale),
    });
    // Strokes that are shorter than the parts of the course are seen in the fine velocity alone.
    let swift = fine
        .iter()
        .map(|fine| fine.values.iter().map(|value| value.abs()).collect());
    let mut best: Option<SpeedRule> = None;
    for speeds in std::iter::once(coarse).chain(swift) {
        let Some(rule) = SpeedRule::from_speeds(speeds, fine.as_ref()) else {
            continue;
        };
        if best
            .as_ref()
            .is_none_or(|best| rule.longest_s > best.longest_s)
        {
            best = Some(rule);
        }
        if best
            .as_ref()
            .is_some_and(|best| best.longest_s >= DURATIONS_S[0])
        {
            break;
        }
    }
    let Some(rule) = best else {
        return default(STUDY);
    };
    let usual_s = DURATIONS_S[0];
    let text = rule.speed_text;
    let with_duration = |duration_s| {
        format!(
            "{} for {} s",
            rule.text,
            statistics::significant(duration_s)
        )
    };
    if rule.longest_s >= usual_s {
        let is_sure = scale_reason.is_sure && fine.is_some();
        return (with_duration(usual_s), Reason { text, is_sure });
    }
    let duration_s = DURATIONS_S
        .into_iter()
        .find(|duration_s| *duration_s <= rule.longest_s);
    let found = match duration_s {
        Some(_) => format!("none keeps to it for {usual_s} s"),
        None => "but no stretch looked at keeps to this rule: write the speeds and the time of your strokes".to_owned(),
    };
    (
        with_duration(duration_s.unwrap_or(usual_s)),
        check(format!("{text}; {found}")),
    )
}

/// Range of speeds about the median of the strokes.
struct SpeedRule {
    text: String,
    speed_text: String,
    /// Longest time for which the velocity keeps to it, s; infinite where it is not known.
    longest_s: f64,
}

impl SpeedRule {
    /// Returns the rule by speeds in m/s, tried on the velocity; `None` without a speed of a finger.
    fn from_speeds(speeds: Vec<f64>, velocity: Option<&FineCourse>) -> Option<Self> {
        let mut known: Vec<f64> = speeds
            .into_iter()
            .filter(|speed| speed.is_finite())
            .collect();
        known.sort_by(f64::total_cmp);
        let fastest = statistics::quantile(&known, FASTEST_SHARE)?;
        let moving = known.into_iter().filter(|speed| *speed > 0.2 * fastest);
        let median = statistics::median(moving).filter(|median| (1e-6..=2.0).contains(median))?;
        let limits = [SPEED_BAND.0, SPEED_BAND.1].map(|share| two_digits(1e3 * share * median));
        let text = format!("{} to {} mm/s", limits[0], limits[1]);
        let longest_s = velocity.map_or(f64::INFINITY, |velocity| {
            trial::longest_stroke_s(velocity, &text)
        });
        Some(Self {
            text,
            speed_text: format!(
                "the strokes' median speed is {} mm/s",
                two_digits(1e3 * median)
            ),
            longest_s,
        })
    }
}

/// Returns whether the guessed rule of unloaded stretches holds anywhere in a force; `None` if that is not known.
pub(crate) fn is_ever_unloaded(
    vector: &VectorPortrait,
    limit_n: f64,
    duration_s: f64,
) -> Option<bool> {
    let rest = match &vector.nature {
        Nature::Slow(Slow::Steps(steps)) => steps.rest,
        _ => 0.0,
    };
    let newtons = newtons(vector, None).0.abs();
    let fine = vector.fine.as_ref()?;
    let forces = fine.values.iter().map(|value| newtons * (value - rest));
    let rule = format!("normal < {limit_n} N for {duration_s} s");
    Some(trial::ever_holds(fine, &forces.collect::<Vec<_>>(), &rule))
}

pub(crate) fn two_digits(value: f64) -> String {
    statistics::significant(format!("{value:.1e}").parse().unwrap_or(value))
}
