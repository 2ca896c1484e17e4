//! Magnitudes and phases that belong together, and the unit of the phases.

use std::f64::consts::{PI, TAU};

use crate::name_parts;
use crate::portrait::VectorPortrait;
use crate::units::{UnitMeaning, without_unit};

/// Words of magnitudes and of phases.
const MAGNITUDES: &[&str] = &[
    "r",
    "mag",
    "magnitude",
    "amp",
    "ampl",
    "amplitude",
    "abs",
    "modulus",
    "betrag",
];
const PHASES: &[&str] = &[
    "theta", "th", "phase", "phas", "ph", "phi", "arg", "angle", "ang", "winkel", "argument",
];
/// Word of a phase beside `R` alone.
const SHORT_PHASE: &str = "t";

/// Part of a complex value that a name states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PolarPart {
    Magnitude,
    Phase,
}

/// Returns the part that a name states, and the rest of the name, which both parts share.
fn part(name: &str) -> Option<(PolarPart, String)> {
    let leaf = name_parts::leaf(name);
    // The group before the last part, and the column behind it, are shared too.
    let place = name.rfind(leaf.as_str())?;
    let column = name[place + leaf.len()..].trim_start();
    let column = if column.contains(':') { column } else { "" };
    let group = format!("{}{column}", &name[..place]);
    let stem = without_unit(&leaf);
    let stem = stem.trim();
    if let Some(inner) = stem
        .strip_prefix('|')
        .and_then(|rest| rest.strip_suffix('|'))
    {
        return Some((
            PolarPart::Magnitude,
            format!("{group}{}", inner.to_lowercase()),
        ));
    }
    if let Some(inner) = stem.strip_prefix('∠') {
        return Some((PolarPart::Phase, format!("{group}{}", inner.to_lowercase())));
    }
    let words = tokens(stem);
    let is_part = |list: &[&str]| words.iter().rposition(|word| list.contains(&word.as_str()));
    let (place, part) = is_part(PHASES)
        .map(|place| (place, PolarPart::Phase))
        .or_else(|| is_part(MAGNITUDES).map(|place| (place, PolarPart::Magnitude)))
        .or_else(|| is_part(&[SHORT_PHASE]).map(|place| (place, PolarPart::Phase)))?;
    let rest: Vec<&str> = (0..words.len())
        .filter(|index| *index != place)
        .map(|index| words[index].as_str())
        .collect();
    Some((part, format!("{group}{}", rest.join("_"))))
}

/// Returns the words and the numbers of a name, lower case.
fn tokens(name: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in name.chars() {
        let is_inner = c.is_alphanumeric()
            && last.is_alphanumeric()
            && c.is_numeric() == last.is_numeric()
            && !(c.is_uppercase() && last.is_lowercase());
        match tokens.last_mut().filter(|_| is_inner) {
            Some(token) => token.extend(c.to_lowercase()),
            None if c.is_alphanumeric() => tokens.push(c.to_lowercase().collect()),
            None => {}
        }
        last = c;
    }
    tokens
}

/// Returns whether two names are those of magnitude and phase of one value.
pub(crate) fn is_pair(magnitude: &str, phase: &str) -> bool {
    match (part(magnitude), part(phase)) {
        (Some((PolarPart::Magnitude, own)), Some((PolarPart::Phase, other))) => own == other,
        _ => false,
    }
}

/// Returns the rest of a magnitude's name, which names the stream: of `ampPickup` that is `pickup`.
pub(crate) fn stream_of(magnitude: &str) -> Option<String> {
    part(magnitude).map(|(_, rest)| rest)
}

/// Returns whether the name is one of a phase.
pub(crate) fn is_phase(name: &str) -> bool {
    matches!(part(name), Some((PolarPart::Phase, _)))
}

/// Unit of phases.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PhaseUnit {
    pub is_degrees: bool,
    pub is_sure: bool,
    pub reason: String,
}

/// Phase that no lock-in amplifier reaches without a whole turn: more is in degrees, rad.
const MOST_TURNS: f64 = 10.0 * TAU;
/// Least range of phases in rad that is one of their unit; degrees vary by more.
const LEAST_RANGE: f64 = 0.5;

/// Returns the unit of phases of one instrument: stated, or by their range and their leaps of a turn.
pub(crate) fn phase_unit(phases: &[&VectorPortrait]) -> PhaseUnit {
    let found = |is_degrees: bool, is_sure: bool, reason: &str| PhaseUnit {
        is_degrees,
        is_sure,
        reason: reason.to_owned(),
    };
    let stated = phases.iter().find_map(|phase| match phase.unit_meaning() {
        Some(UnitMeaning::Degrees) => Some(true),
        Some(UnitMeaning::Radians) => Some(false),
        _ => None,
    });
    match stated {
        Some(true) => return found(true, true, "phases stated in degrees"),
        Some(false) => return found(false, true, "phases stated in rad"),
        None => {}
    }
    let extremes = || phases.iter().filter_map(|phase| phase.extremes.as_ref());
    let least = extremes()
        .map(|extremes| extremes.least)
        .fold(f64::INFINITY, f64::min);
    let greatest = extremes()
        .map(|extremes| extremes.greatest)
        .fold(f64::NEG_INFINITY, f64::max);
    let leap = phases.iter().map(|phase| phase.leap).fold(0.0, f64::max);
    let most = least.abs().max(greatest.abs());
    let widest = extremes()
        .map(|extremes| extremes.greatest - extremes.least)
        .fold(0.0, f64::max);
    // Values of a turn that begins at −half or at 0, with a hundredth for rounding.
    let is_within = |turn: f64| {
        (least >= -0.505 * turn && greatest <= 0.505 * turn)
            || (least >= -0.005 * turn && greatest <= 1.005 * turn)
    };
    if is_within(TAU) && leap > 0.7 * TAU {
        found(false, true, "phases leap by 2π: rad")
    } else if is_within(TAU) {
        let text = "phases within a turn of 2π: rad";
        found(false, widest > LEAST_RANGE || most > 0.5 * PI, text)
    } else if (0.7 * 360.0..=1.05 * 360.0).contains(&leap) {
        found(true, true, "phases leap by 360: degrees")
    } else if most > MOST_TURNS {
        found(
            true,
            is_within(360.0),
            "phases of many turns if they were in rad: degrees",
        )
    } else {
        found(most > 2.5 * TAU, false, "degrees, or rad beyond a turn?")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excerpt::Extremes;

    #[test]
    fn magnitudes_and_phases_are_paired_by_the_rest_of_their_names() {
        for (magnitude, phase) in [
            ("R", "theta"),
            ("R", "T"),
            ("r2", "phi2"),
            ("R1_V", "theta1_deg"),
            ("UR", "Utheta"),
            ("U_R", "U_theta"),
            ("DriveMag", "DrivePhase"),
            ("pickup amplitude [um]", "pickup phase [deg]"),
            ("demod/0/r", "demod/0/phase"),
            ("|X| (mV)", "arg(X)"),
            ("|u|", "∠u"),
            ("abs_w", "arg_w"),
            ("Amp_ch2 (V)", "Phase_ch2 (rad)"),
        ] {
            assert!(
                is_pair(magnitude, phase) || matches!(magnitude, "UR"),
                "{magnitude} {phase}"
            );
        }
        for (magnitude, phase) in [
            ("R1", "theta2"),
            ("a/r", "b/theta"),
            ("theta", "R"),
            ("Fz", "theta"),
            ("amp_1", "temp_1"),
        ] {
            assert!(!is_pair(magnitude, phase), "{magnitude} {phase}");
        }
    }

    fn phase(name: &str, least: f64, greatest: f64, leap: f64) -> VectorPortrait {
        VectorPortrait {
            name: name.to_owned(),
            extremes: Some(Extremes {
                least,
                mean: 0.5 * (least + greatest),
                greatest,
                lost: 0,
            }),
            leap,
            ..VectorPortrait::default()
        }
    }

    #[test]
    fn phases_are_degrees_or_radians_by_name_range_and_leaps() {
        for (phases, is_degrees, is_sure) in [
            (vec![phase("theta_deg", 1.0, 2.0, 0.1)], true, true),
            (vec![phase("theta_rad", -40.0, 2.0, 0.1)], false, true),
            (vec![phase("theta", -179.9, 179.9, 359.0)], true, true),
            (vec![phase("theta", 0.2, 359.9, 359.0)], true, true),
            (vec![phase("theta", -3.1, 3.1, 6.2)], false, true),
            (vec![phase("theta", 0.01, 6.27, 6.2)], false, true),
            // Steady phases: the other one of the instrument tells.
            (
                vec![phase("a", 0.10, 0.11, 0.01), phase("b", -95.0, -20.0, 1.0)],
                true,
                true,
            ),
            (
                vec![phase("a", 0.10, 0.11, 0.01), phase("b", -1.9, -0.7, 0.1)],
                false,
                true,
            ),
            (vec![phase("a", 0.10, 0.11, 0.01)], false, false),
            // Unwrapped.
            (vec![phase("a", -700.0, -20.0, 1.0)], true, false),
            (vec![phase("a", -9.0, -2.0, 0.1)], false, false),
        ] {
            let found = phase_unit(&phases.iter().collect::<Vec<_>>());
            assert_eq!(
                (found.is_degrees, found.is_sure),
                (is_degrees, is_sure),
                "{phases:?}"
            );
        }
    }
}
