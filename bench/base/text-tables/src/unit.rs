//! Units of columns: in their names, and in a row below the header.

use crate::fault::TableFault;
use crate::header::Header;

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

/// Returns whether the line below the header is a row of units: its numeric columns state units, or nothing.
///
/// # Errors
/// [`TableFault::UnitsRow`] if a column has another unit than its name.
pub fn units_row(
    cells: &[impl AsRef<str>],
    line: usize,
    header: &Header,
) -> Result<bool, TableFault> {
    let mut stated = Vec::new();
    for (column, place) in header.places() {
        let (Some(unit), Some(place)) = (unit(column), place) else {
            continue;
        };
        let cell = cells.get(place).map_or("", AsRef::as_ref);
        let text = cell
            .trim_matches(['[', ']', '(', ')', ' '])
            .replace('μ', "µ");
        if !text.is_empty() && !is_unit(&text) {
            return Ok(false);
        }
        stated.push((column, unit, text));
    }
    if stated.iter().all(|(_, _, text)| text.is_empty()) {
        return Ok(false);
    }
    for (column, unit, text) in stated {
        let (_, _, others) = UNITS[UNITS.iter().position(|row| row.1 == unit).unwrap_or(0)];
        let is_same =
            text.is_empty() || text == unit || others.contains(&text.to_lowercase().as_str());
        if !is_same {
            return Err(TableFault::UnitsRow {
                line,
                column: column.to_owned(),
                found: text,
                unit,
            });
        }
    }
    Ok(true)
}

/// Returns whether a text reads as a unit: a letter, `%` or `°`, then letters and signs of powers, products and ratios.
fn is_unit(text: &str) -> bool {
    let is_sign = |c: char| {
        c.is_alphanumeric() || matches!(c, '%' | '°' | '/' | '^' | '·' | '*' | '-' | '⁻' | ' ')
    };
    let is_missing =
        ["na", "n/a", "nan", "inf", "infinity"].contains(&text.to_lowercase().as_str());
    !is_missing
        && text.starts_with(|c: char| c.is_alphabetic() || matches!(c, '%' | '°'))
        && text.chars().all(is_sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Columns;

    const COLUMNS: Columns = Columns {
        required: &["time_s", "normal_n"],
        optional: &["axis"],
    };

    fn is_row(cells: &[&str]) -> Result<bool, TableFault> {
        let header = Header::read("time_s,normal_n,axis", None, &COLUMNS).unwrap();
        units_row(cells, 2, &header)
    }

    #[test]
    fn a_row_of_units_agrees_with_the_names_of_the_columns() {
        for cells in [
            ["s", "N", ""],
            ["[s]", "(N)", "-"],
            ["seconds", "newtons", ""],
            ["", "N", ""],
        ] {
            assert_eq!(is_row(&cells), Ok(true), "{cells:?}");
        }
        for cells in [
            ["0", "0.5", ""],
            ["NaN", "NaN", ""],
            ["", "", ""],
            ["n/a", "1", ""],
        ] {
            assert_eq!(is_row(&cells), Ok(false), "{cells:?}");
        }
        for (cells, found) in [
            (["s", "mN", ""], "mN"),
            (["ms", "N", ""], "ms"),
            (["s", "V", ""], "V"),
        ] {
            let fault = is_row(&cells).unwrap_err();
            assert!(
                matches!(&fault, TableFault::UnitsRow { found: unit, .. } if unit == found),
                "{fault}"
            );
        }
    }

    #[test]
    fn a_name_ends_with_its_unit() {
        assert_eq!(unit("known_um"), Some("µm"));
        assert_eq!(unit("known_at_hz"), Some("Hz"));
        assert_eq!(unit("participant_id"), None);
        assert_eq!(unit("axis"), None);
    }
}
