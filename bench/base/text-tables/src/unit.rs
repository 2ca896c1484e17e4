//! Units in the names of columns.

/// Ending of a column's name, its unit, and further ways to write it.
const UNITS: [(&str, &str, &[&str]); 7] = [
    ("s", "s", &["sec", "second", "seconds"]),
    ("n", "N", &["newton", "newtons"]),
    ("m", "m", &["metre", "metres", "meter", "meters"]),
    (
        "um",
        "µm",
        &[
            "um",
            "micrometre",
            "micrometres",
            "micrometer",
            "micrometers",
            "micron",
            "microns",
        ],
    ),
    ("v", "V", &["volt", "volts"]),
    ("g", "g", &["gram", "grams"]),
    ("hz", "Hz", &["hertz"]),
];

/// Returns the unit in a column's name; `None` if its name states none, because its cells are text.
pub(crate) fn unit(column: &str) -> Option<&'static str> {
    let (_, ending) = column.rsplit_once('_')?;
    let row = UNITS.iter().find(|(end, _, _)| *end == ending)?;
    Some(row.1)
}

/// Returns whether a text is the unit `unit` of a column, or another way to write it.
pub(crate) fn is_same(text: &str, unit: &str) -> bool {
    let others = UNITS
        .iter()
        .find(|row| row.1 == unit)
        .map_or(&[][..], |row| row.2);
    text == unit || others.contains(&text.to_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_ends_with_its_unit() {
        assert_eq!(unit("known_um"), Some("µm"));
        assert_eq!(unit("known_at_hz"), Some("Hz"));
        assert_eq!(unit("participant_id"), None);
        assert_eq!(unit("axis"), None);
    }
}
