//! Meanings of units, and units at the ends of names.

use crate::name_parts::leaf;
use crate::time_axis::TimeUnit;

/// Quantity and SI value of a unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum UnitMeaning {
    Newtons(f64),
    Volts(f64),
    Metres(f64),
    MetresPerSecond(f64),
    MetresPerSquareSecond(f64),
    Coulombs(f64),
    Time(TimeUnit),
    Degrees,
    Radians,
    Counts,
    /// Picture elements of a camera, which are no length.
    Pixels,
    /// Quantity that no recording needs, as a temperature or a torque.
    Other,
}

/// Standard acceleration of free fall, m/s²: a gram-force is 9.80665 mN.
pub(crate) const FREE_FALL_M_PER_S2: f64 = 9.806_65;

/// SI prefixes that occur before units of recordings.
const PREFIXES: &[(&str, f64)] = &[
    ("", 1.0),
    ("k", 1e3),
    ("d", 1e-1),
    ("c", 1e-2),
    ("m", 1e-3),
    ("u", 1e-6),
    ("n", 1e-9),
    ("p", 1e-12),
];
/// Quantity of a unit by its SI value.
type QuantityOfUnit = fn(f64) -> UnitMeaning;

/// Symbols that take a prefix, with their quantity.
const SYMBOLS: &[(&[&str], QuantityOfUnit)] = &[
    (
        &["N", "newton", "newtons", "Newton", "Newtons"],
        UnitMeaning::Newtons,
    ),
    (&["V", "volt", "volts", "Volt", "Volts"], UnitMeaning::Volts),
    (
        &["m", "meter", "meters", "metre", "metres"],
        UnitMeaning::Metres,
    ),
    (
        &["m/s", "ms^-1", "m*s^-1", "m_s", "m_per_s", "mps"],
        UnitMeaning::MetresPerSecond,
    ),
    (
        &["m/s^2", "m/s2", "m/s²", "ms^-2", "m_s2", "m_per_s2"],
        UnitMeaning::MetresPerSquareSecond,
    ),
    (&["C"], UnitMeaning::Coulombs),
];
/// Units of quantities that no recording needs.
const OTHERS: &[&str] = &[
    "%", "°C", "degC", "K", "bar", "Pa", "kPa", "hPa", "Nm", "mNm", "N*m", "Nmm", "A", "mA", "Hz",
    "kHz", "dB", "rpm", "Ohm", "ohm", "Ω", "W", "°/s", "rad/s", "deg/s",
];

/// Returns the meaning of a unit.
pub(crate) fn unit_meaning(unit: &str) -> Option<UnitMeaning> {
    use UnitMeaning::{Counts, Degrees, Metres, Newtons, Other, Pixels, Radians, Time};
    const G_N: f64 = 1e-3 * FREE_FALL_M_PER_S2;
    let unit = unit.trim().replace(['μ', 'µ'], "u").replace([' ', '·'], "");
    Some(match unit.as_str() {
        "gf" | "gram" | "grams" | "g" | "pond" => Newtons(G_N),
        "kgf" | "kg" | "kp" => Newtons(1e3 * G_N),
        "lbf" | "lb" | "lbs" => Newtons(453.592_37 * G_N),
        "ozf" | "oz" => Newtons(28.349_523_125 * G_N),
        "dyn" => Newtons(1e-5),
        "in" | "inch" | "inches" => Metres(0.0254),
        "deg" | "degree" | "degrees" | "Deg" | "°" | "Grad" => Degrees,
        "rad" | "radian" | "radians" | "Rad" => Radians,
        "px" | "pix" | "pixel" | "pixels" | "Pixel" | "Pixels" => Pixels,
        "counts" | "count" | "ticks" | "pulses" | "cts" | "digits" | "LSB" | "bits" => Counts,
        unit if OTHERS.contains(&unit) => Other,
        unit => prefixed(unit).or_else(|| TimeUnit::parse(unit).map(Time))?,
    })
}

/// Returns the meaning of a symbol with a prefix.
fn prefixed(unit: &str) -> Option<UnitMeaning> {
    PREFIXES.iter().find_map(|(prefix, factor)| {
        let symbol = unit.strip_prefix(prefix)?;
        // Degrees Celsius, not coulombs, are written as C.
        let is_allowed = symbol != "C" || !prefix.is_empty();
        let (_, quantity) = SYMBOLS
            .iter()
            .find(|(symbols, _)| is_allowed && symbols.contains(&symbol))?;
        Some(quantity(*factor))
    })
}

/// Returns the unit at a name's end: in brackets, or after `_` or a blank; or the name, if it is a unit as `mN`.
pub(crate) fn unit_in_name(name: &str) -> Option<String> {
    parted(name).map(|(_, unit)| unit)
}

/// Returns a name without the unit at its end.
pub(crate) fn without_unit(name: &str) -> String {
    match parted(name) {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => name.to_owned(),
    }
}

/// Returns the last part of a name without its unit, and the unit.
fn parted(name: &str) -> Option<(String, String)> {
    let bracketed = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let (stem, unit) = name.trim_end().strip_suffix(close)?.rsplit_once(open)?;
            (unit_meaning(unit).is_some() && unit.parse::<u64>().is_err())
                .then(|| (leaf(stem), unit.trim().to_owned()))
        });
    bracketed.or_else(|| trailing(&leaf(name)))
}

/// Returns a name and the unit at its end, of at most three words: `v_mm_s`, `v_mm_per_s`.
fn trailing(leaf: &str) -> Option<(String, String)> {
    let mut places: Vec<usize> = leaf
        .rmatch_indices(['_', ' '])
        .map(|(place, _)| place)
        .take(3)
        .collect();
    places.reverse();
    let found = places.into_iter().find_map(|place| {
        let unit = &leaf[place + 1..];
        let is_composite = unit.contains(['_', ' ']);
        let spelt = unit.replace(' ', "_");
        let meaning = unit_meaning(&spelt)?;
        let is_motion = matches!(
            meaning,
            UnitMeaning::MetresPerSecond(_) | UnitMeaning::MetresPerSquareSecond(_)
        );
        // A gram or an inch at the end of a name is more often an index or a word.
        let is_index = matches!(
            unit,
            "g" | "kg" | "in" | "lb" | "oz" | "K" | "A" | "W" | "pm" | "dV" | "Grad"
        );
        let is_unit = !is_index && place > 0 && (!is_composite || is_motion);
        let text = match meaning {
            UnitMeaning::MetresPerSecond(_) => with_slash(&spelt, "/s"),
            UnitMeaning::MetresPerSquareSecond(_) => with_slash(&spelt, "/s²"),
            _ => unit.to_owned(),
        };
        is_unit.then(|| (leaf[..place].to_owned(), text))
    });
    // An array `mN` of a group `force` states the unit by its name.
    let is_whole = matches!(
        leaf,
        "mN" | "cN" | "uN" | "µN" | "kN" | "mm" | "cm" | "um" | "µm" | "mV" | "kV"
    );
    found.or_else(|| is_whole.then(|| (String::new(), leaf.to_owned())))
}

/// Returns a unit of a velocity or an acceleration as it is printed.
fn with_slash(unit: &str, end: &str) -> String {
    let length = unit.split(['_', '/', '^', '*']).next().unwrap_or_default();
    let length = length.strip_suffix("ps").unwrap_or(length);
    format!("{length}{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_at_the_end_of_names() {
        for (name, unit) in [
            ("Fz [N]", Some("N")),
            ("Fz [cN]", Some("cN")),
            ("Position (mm)", Some("mm")),
            ("F_mN", Some("mN")),
            ("v_mm/s", Some("mm/s")),
            ("v_mm_s", Some("mm/s")),
            ("speed_cm_per_s", Some("cm/s")),
            ("finger speed m s", Some("m/s")),
            ("vel_mmps", Some("mm/s")),
            ("acc_m_s2", Some("m/s²")),
            ("stage_m/s", Some("m/s")),
            ("t_s", Some("s")),
            ("x_m_t_s", Some("s")),
            ("theta1_deg", Some("deg")),
            ("camera/x [px]", Some("px")),
            ("Forces/mN[:,0]", Some("mN")),
            ("Temp (°C)", Some("°C")),
            ("Fn", None),
            ("S[2]", None),
            ("x_1", None),
            ("left (raw)", None),
            ("group/mm", Some("mm")),
        ] {
            assert_eq!(unit_in_name(name).as_deref(), unit, "{name}");
        }
        assert_eq!(without_unit("v_mm_s"), "v");
        assert_eq!(without_unit("Fz [cN]").trim(), "Fz");
    }

    #[test]
    fn prefixes_scale_every_unit_of_a_recording() {
        use UnitMeaning::{Coulombs, Metres, MetresPerSecond, Newtons, Volts};
        for (unit, meaning) in [
            ("µN", Newtons(1e-6)),
            ("cN", Newtons(1e-2)),
            ("dN", Newtons(1e-1)),
            ("kN", Newtons(1e3)),
            ("uV", Volts(1e-6)),
            ("cm", Metres(1e-2)),
            ("nm", Metres(1e-9)),
            ("um/s", MetresPerSecond(1e-6)),
            ("pC", Coulombs(1e-12)),
        ] {
            assert_eq!(unit_meaning(unit), Some(meaning), "{unit}");
        }
        assert_eq!(unit_meaning("bananas"), None);
        assert_eq!(unit_meaning("C"), None);
        assert_eq!(
            unit_meaning("min"),
            Some(UnitMeaning::Time(TimeUnit::Minutes))
        );
        assert_eq!(
            unit_meaning("ms"),
            Some(UnitMeaning::Time(TimeUnit::Milliseconds))
        );
    }
}
