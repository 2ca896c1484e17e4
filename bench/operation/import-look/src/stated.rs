//! Statements of a file about its arrays: scales in attributes.

use source_files::{Format, SourceFile};

use crate::name_parts;
use crate::portrait::{Scaling, SinglePortrait};
use crate::units::unit_meaning;

/// Words of attributes that state a factor of counts, and those that programs also state of values that are scaled
/// already.
const FACTORS: &[&str] = &[
    "scale",
    "scalefactor",
    "scaling",
    "slope",
    "multiplier",
    "factor",
    "unitspercount",
    "unitpercount",
];
const GAINS: &[&str] = &["gain", "resolution", "lsb"];
const OFFSETS: &[&str] = &["offset", "addoffset", "intercept", "bias"];
/// Words for one count of a converter or an encoder.
const COUNTS: &[&str] = &[
    "count",
    "counts",
    "lsb",
    "bit",
    "bits",
    "digit",
    "tick",
    "ticks",
    "pulse",
    "pulses",
    "inc",
    "increment",
    "step",
];
/// Resolutions of converters in bits, which are no factors.
const BITS: std::ops::RangeInclusive<f64> = 8.0..=32.0;

/// Returns the scaling that the attributes of an array state; `is_whole` if its values are whole numbers.
pub(crate) fn scaling(array: &str, is_whole: bool, singles: &[SinglePortrait]) -> Option<Scaling> {
    let mut found: Option<Scaling> = None;
    let mut offset = None;
    let mut add = |factor: f64, unit: Option<String>, single: &SinglePortrait, is_sure: bool| {
        let text = format!("{} = {}", attribute_name(single), single.text);
        found = Some(match found.take() {
            // Two factors may be one twice: a gain in a scale.
            Some(before) => Scaling {
                factor: before.factor * factor,
                text: format!("{}, {text}", before.text),
                is_sure: false,
                unit: before.unit.or(unit),
                ..before
            },
            None => Scaling {
                factor,
                offset: 0.0,
                text,
                is_sure,
                unit,
            },
        });
    };
    for single in singles {
        let is_own = single
            .name
            .split_once('@')
            .is_some_and(|(object, _)| object.trim_start_matches('/') == array);
        let Some(number) = single.number.filter(|number| is_own && number.is_finite()) else {
            continue;
        };
        let words = name_parts::words(attribute_name(single));
        let joined = words.concat();
        let is_factor = |list: &[&str]| list.contains(&joined.as_str()) && number != 0.0;
        if let Some((factor, unit)) = per_count(attribute_name(single), number) {
            add(factor, Some(unit), single, true);
        } else if is_factor(FACTORS) {
            add(number, None, single, is_whole);
        } else if is_factor(GAINS)
            && is_whole
            && !(joined == "resolution" && BITS.contains(&number))
        {
            // An amplifier's gain is above 1, and divides.
            add(number, None, single, joined != "gain" || number.abs() < 1.0);
        } else if OFFSETS.contains(&joined.as_str()) && number != 0.0 {
            offset = Some((
                number,
                format!("{} = {}", attribute_name(single), single.text),
            ));
        }
    }
    if let Some((number, text)) = offset.filter(|_| is_whole || found.is_some()) {
        let before = found.unwrap_or(Scaling {
            factor: 1.0,
            offset: 0.0,
            text: String::new(),
            is_sure: false,
            unit: None,
        });
        let separator = if before.text.is_empty() { "" } else { ", " };
        found = Some(Scaling {
            offset: number,
            text: format!("{}{separator}{text}", before.text),
            ..before
        });
    }
    found
}

fn attribute_name(single: &SinglePortrait) -> &str {
    single
        .name
        .rsplit_once('@')
        .map_or(single.name.as_str(), |(_, name)| name)
}

/// Returns factor and unit of an attribute as `mm_per_count`, or as `counts_per_mm`.
fn per_count(name: &str, number: f64) -> Option<(f64, String)> {
    let (unit, per) = name.split_once("_per_").or_else(|| name.split_once('/'))?;
    let is_count = |word: &str| COUNTS.contains(&word.to_lowercase().as_str());
    let has_meaning = |unit: &str| unit_meaning(&long_unit(unit)).is_some() && !is_count(unit);
    if number == 0.0 {
        None
    } else if is_count(per) && has_meaning(unit) {
        Some((number, long_unit(unit)))
    } else if is_count(unit) && has_meaning(per) {
        Some((1.0 / number, long_unit(per)))
    } else {
        None
    }
}

/// Returns the symbol of a unit that is written out.
fn long_unit(unit: &str) -> String {
    match unit.to_lowercase().as_str() {
        "metre" | "metres" | "meter" | "meters" => "m".to_owned(),
        "millimetre" | "millimetres" | "millimeter" | "millimeters" => "mm".to_owned(),
        "micrometre" | "micrometres" | "micron" | "microns" => "um".to_owned(),
        "volt" | "volts" => "V".to_owned(),
        "newton" | "newtons" => "N".to_owned(),
        _ => unit.to_owned(),
    }
}

/// Returns the notes of a file, without the separator of the cells where there is but one column.
pub(crate) fn notes(file: &SourceFile) -> Vec<String> {
    let is_column = file.format() == Format::Text && file.arrays().len() == 1;
    file.notes()
        .iter()
        .filter(|note| !(is_column && note.starts_with("its cells are separated")))
        .cloned()
        .collect()
}

/// Returns single values without those that a text file's lines of words only resemble: a heading of two columns, a
/// date with a colon.
pub(crate) fn without_invented(
    mut singles: Vec<SinglePortrait>,
    file: &SourceFile,
) -> Vec<SinglePortrait> {
    if file.format() != Format::Text {
        return singles;
    }
    let columns: Vec<&str> = file
        .arrays()
        .iter()
        .map(|info| info.name.as_str())
        .collect();
    singles.retain(|single| {
        let name = single.name.strip_prefix('@');
        let is_heading = |name: &str| {
            columns.contains(&name) && columns.contains(&single.text.trim_matches('"'))
        };
        name.is_none_or(|name| !name.contains(['\t', ';', ',']) && !is_heading(name))
    });
    singles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(name: &str, number: f64) -> SinglePortrait {
        SinglePortrait {
            name: name.to_owned(),
            element: "attribute".to_owned(),
            shape: String::new(),
            number: Some(number),
            unit: None,
            text: statistics::significant(number),
        }
    }

    fn found(list: &[(&str, f64)], is_whole: bool) -> Option<(f64, f64, bool, Option<String>)> {
        let singles: Vec<SinglePortrait> = list
            .iter()
            .map(|(name, value)| single(&format!("/g/ch@{name}"), *value))
            .collect();
        scaling("g/ch", is_whole, &singles).map(|scaling| {
            (
                scaling.factor,
                scaling.offset,
                scaling.is_sure,
                scaling.unit,
            )
        })
    }

    #[test]
    fn attributes_of_each_name_scale_whole_numbers() {
        for name in [
            "gain",
            "scale",
            "scale_factor",
            "ScaleFactor",
            "resolution",
            "slope",
            "lsb",
            "units_per_count",
        ] {
            assert_eq!(
                found(&[(name, 2.5e-4)], true),
                Some((2.5e-4, 0.0, true, None)),
                "{name}"
            );
        }
        assert_eq!(
            found(&[("scale_factor", 0.5), ("add_offset", -3.0)], true),
            Some((0.5, -3.0, true, None))
        );
        for (name, value, factor, unit) in [
            ("um_per_count", 0.25, 0.25, "um"),
            ("counts_per_mm", 200.0, 0.005, "mm"),
            ("volts_per_lsb", 1e-3, 1e-3, "V"),
        ] {
            assert_eq!(
                found(&[(name, value)], true),
                Some((factor, 0.0, true, Some(unit.to_owned()))),
                "{name}"
            );
        }
    }

    #[test]
    fn gains_of_amplifiers_and_bits_of_converters_are_doubted_or_left() {
        assert_eq!(
            found(&[("gain", 50.0)], true),
            Some((50.0, 0.0, false, None))
        );
        assert_eq!(found(&[("gain", 50.0)], false), None);
        assert_eq!(found(&[("resolution", 16.0)], true), None);
        assert_eq!(
            found(&[("scale", 1e-3), ("gain", 0.1)], true).map(|scaling| scaling.2),
            Some(false)
        );
        assert_eq!(found(&[("temperature", 21.0)], true), None);
        assert_eq!(scaling("other", true, &[single("/g/ch@gain", 0.1)]), None);
    }
}
