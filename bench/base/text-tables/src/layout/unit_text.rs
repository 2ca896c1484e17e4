//! Units in headers of tables.

/// Units that a row of units may consist of.
const UNITS: [&str; 62] = [
    "", "-", "--", "s", "sec", "second", "seconds", "ms", "us", "µs", "ns", "min", "h", "N", "mN",
    "kN", "uN", "µN", "g", "kg", "mg", "gf", "kgf", "lbf", "V", "mV", "uV", "µV", "kV", "A", "mA",
    "C", "pC", "nC", "m", "cm", "mm", "um", "µm", "nm", "m/s", "mm/s", "cm/s", "um/s", "µm/s",
    "m/s^2", "m/s²", "Hz", "kHz", "MHz", "rad", "deg", "°", "°C", "%", "dB", "Pa", "kPa", "counts",
    "samples", "Nm", "a.u.",
];

/// Returns a cell of a row of units without brackets, and with one sign for micro.
pub(crate) fn unit_text(cell: &str) -> &str {
    cell.trim_matches(['[', ']', '(', ')', ' '])
}

/// Returns whether a cell is a unit, or empty.
pub(crate) fn is_unit(cell: &str) -> bool {
    let text = unit_text(cell).replace('μ', "µ");
    let is_bracketed = cell.starts_with(['[', '(']) && cell.ends_with([']', ')']);
    UNITS.contains(&text.as_str())
        || is_bracketed && text.len() <= 12 && text.parse::<f64>().is_err()
}

/// Splits a column's name into the name and the unit that ends it: `Force (N)`, `Force [N]`, `F / N`.
pub(crate) fn name_and_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((stem, unit)) = name
            .strip_suffix(close)
            .and_then(|name| name.rsplit_once(open))
        {
            let unit = unit.trim();
            return (stem.trim_end(), (!unit.is_empty()).then_some(unit));
        }
    }
    match name.rsplit_once('/') {
        Some((stem, unit))
            if !unit.trim().is_empty() && !stem.trim().is_empty() && is_unit(unit.trim()) =>
        {
            (stem.trim_end(), Some(unit.trim()))
        }
        _ => (name, None),
    }
}

/// Returns whether a column's name is one of a time.
#[must_use]
pub fn is_time_name(name: &str) -> bool {
    let (name, _) = name_and_unit(name);
    let stem = name.split('.').next().unwrap_or(name).trim().to_lowercase();
    [
        "t",
        "time",
        "times",
        "zeit",
        "temps",
        "tempo",
        "tid",
        "x_value",
        "timestamp",
    ]
    .contains(&stem.as_str())
        || stem.starts_with("time_")
        || stem.starts_with("time ")
        || stem.starts_with("t_")
        || stem.ends_with("_time")
        || stem.ends_with(" time")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_in_names_and_in_rows() {
        for (name, stem, unit) in [
            ("Force (N)", "Force", Some("N")),
            ("x [µm]", "x", Some("µm")),
            ("F / N", "F", Some("N")),
            ("out/left", "out/left", None),
            ("Force", "Force", None),
        ] {
            assert_eq!(name_and_unit(name), (stem, unit));
        }
        for cell in ["s", "[mN]", "(V)", "", "m/s²", "[foo]"] {
            assert!(is_unit(cell), "{cell}");
        }
        for cell in ["t", "F", "Force", "1.5", "[1.5]"] {
            assert!(!is_unit(cell), "{cell}");
        }
    }

    #[test]
    fn names_of_times_are_found() {
        for name in ["Time", "t [s]", "time.1", "Zeit (ms)", "X_Value", "time_s"] {
            assert!(is_time_name(name), "{name}");
        }
        for name in ["torque", "F", "estimate"] {
            assert!(!is_time_name(name), "{name}");
        }
    }
}
