//! Cells of a line, and their numbers.

use std::borrow::Cow;

use super::cell_words::no_number;
use crate::cells::cells;
use crate::number::{NumberFault, Numbers};
use crate::separator::Separator;

/// Separator of the cells of a table, runs of blanks included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// One character.
    At(Separator),
    /// Runs of blanks.
    Blanks,
}

impl Split {
    /// All separators, the safest first.
    pub const ALL: [Self; 4] = [
        Self::At(Separator::Tab),
        Self::At(Separator::Semicolon),
        Self::At(Separator::Comma),
        Self::Blanks,
    ];

    /// Returns the cells of a line.
    #[must_use]
    pub fn cells(self, line: &str) -> Vec<Cow<'_, str>> {
        match self {
            Self::At(separator) => cells(line, separator),
            Self::Blanks => line
                .split_whitespace()
                .map(|cell| Cow::Borrowed(cell.trim_matches('"')))
                .collect(),
        }
    }

    /// Returns the cell of a column; `None` where the line is shorter.
    #[must_use]
    pub fn cell(self, line: &str, column: usize) -> Option<Cow<'_, str>> {
        match self {
            Self::At(separator) if !line.contains('"') => line
                .split(separator.character())
                .nth(column)
                .map(|cell| Cow::Borrowed(cell.trim())),
            Self::At(separator) => cells(line, separator).into_iter().nth(column),
            Self::Blanks => line
                .split_whitespace()
                .nth(column)
                .map(|cell| Cow::Borrowed(cell.trim_matches('"'))),
        }
    }

    /// Returns the separator in words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::At(separator) => separator.name(),
            Self::Blanks => "blanks",
        }
    }

    /// Returns a reader of numbers in such cells.
    #[must_use]
    pub fn numbers(self) -> Numbers {
        Numbers::new(match self {
            Self::At(separator) => separator,
            Self::Blanks => Separator::Tab,
        })
    }
}

/// Cells that stand for a missing value.
pub(super) const MISSING: [&str; 9] = ["", "-", "--", "na", "n/a", "#n/a", "null", "none", "nan"];

/// Reads a number: NaN for a missing value, 1 and 0 for true and false, infinities of any program.
///
/// # Errors
/// The reason why the cell is not a number.
pub fn number(cell: &str, numbers: &mut Numbers) -> Result<f64, String> {
    if is_plain(cell) && (!cell.contains('.') || !numbers.is_undecided() && !numbers.has_commas()) {
        return cell.parse().map_err(|_| no_number(cell));
    }
    let lower = cell.to_ascii_lowercase();
    if MISSING.contains(&lower.as_str()) || lower.ends_with("nan") {
        return Ok(f64::NAN);
    }
    match lower.as_str() {
        "true" => return Ok(1.0),
        "false" => return Ok(0.0),
        "inf" | "+inf" | "1.#inf" | "infinity" => return Ok(f64::INFINITY),
        "-inf" | "-1.#inf" | "-infinity" => return Ok(f64::NEG_INFINITY),
        "1.#qnan" | "-1.#ind" | "1.#ind" => return Ok(f64::NAN),
        _ => {}
    }
    // Fortran writes exponents of double precision with a D.
    let with_exponent;
    let cell = match cell
        .bytes()
        .filter(|byte| matches!(byte, b'd' | b'D'))
        .count()
    {
        1 => {
            with_exponent = cell.replace(['d', 'D'], "e");
            with_exponent.as_str()
        }
        _ => cell,
    };
    if !cell.bytes().any(|byte| byte.is_ascii_digit()) {
        return Err(no_number(cell));
    }
    numbers.read(cell).map_err(|fault| match fault {
        NumberFault::NotNumber => no_number(cell),
        fault => format!("is not one number: {fault}"),
    })
}

/// Returns whether a cell consists of digits, signs, points and exponents alone.
fn is_plain(cell: &str) -> bool {
    !cell.is_empty()
        && cell
            .bytes()
            .all(|byte| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E'))
        && cell.as_bytes()[0] != b'e'
        && cell.as_bytes()[0] != b'E'
        && cell.bytes().any(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_any_program_are_read() {
        let read = |split: Split, cell: &str| number(cell, &mut split.numbers());
        let tab = Split::At(Separator::Tab);
        for (cell, value) in [
            ("-1.5e-3", -1.5e-3),
            ("12", 12.0),
            ("0,25", 0.25),
            ("1.0D+03", 1000.0),
            ("TRUE", 1.0),
            ("-Inf", f64::NEG_INFINITY),
            ("1.#INF", f64::INFINITY),
        ] {
            assert_eq!(read(tab, cell), Ok(value), "{cell}");
        }
        for cell in ["", "NaN", "n/a", "1.#QNAN", "-nan", "NULL"] {
            assert!(read(tab, cell).unwrap().is_nan(), "{cell}");
        }
        for cell in ["4 N", "abc", "e5", "1,234", "--5"] {
            assert!(read(tab, cell).is_err(), "{cell}");
        }
    }

    #[test]
    fn a_cell_is_found_without_the_others() {
        for split in Split::ALL {
            for line in ["a,b;c\td e", " 1 , 2 ", "\"x;y\";2\t3", ""] {
                let cells = split.cells(line);
                for column in 0..4 {
                    assert_eq!(
                        split.cell(line, column),
                        cells.get(column).cloned(),
                        "{line:?}"
                    );
                }
            }
        }
    }
}
