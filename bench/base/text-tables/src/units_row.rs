//! Rows of units below headers.

use crate::fault::TableFault;
use crate::header::Header;
use crate::unit::{is_same, unit};

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
        if !text.is_empty() && !is_same(&text, unit) {
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
}
