//! Cells of a line, and their numbers.

use std::borrow::Cow;

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
const MISSING: [&str; 9] = ["", "-", "--", "na", "n/a", "#n/a", "null", "none", "nan"];

/// Reads a number: NaN for a missing value, 1 and 0 for true and false, infinities of any program.
///
/// # Errors
/// The reason why the cell is not a number.
pub fn number(cell: &str, numbers: &mut Numbers) -> Result<f64, String> {
    if is_plain(cell) && (!cell.contains('.') || !numbers.is_undecided() && !numbers.has_commas()) {
        return cell.parse().map_err(|_| "is not a number".to_owned());
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
        return Err("is not a number".to_owned());
    }
    numbers.read(cell).map_err(|fault| match fault {
        NumberFault::NotNumber => "is not a number".to_owned(),
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

/// Reads a time as seconds: `2026-11-26T12:34:56.789` since 1970, `12:34:56.789` since midnight; NaN for a missing value.
#[must_use]
pub fn time_s(cell: &str) -> Option<f64> {
    if MISSING.contains(&cell.to_ascii_lowercase().as_str()) {
        return Some(f64::NAN);
    }
    let cell = cell.trim_end_matches('Z');
    match cell.split_once(['T', ' ']) {
        Some((date, clock)) => Some(day(date)? * 86_400.0 + clock_s(clock)?),
        None => clock_s(cell),
    }
}

fn clock_s(text: &str) -> Option<f64> {
    let mut parts = text.split(':');
    let (hours, minutes, seconds) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() || hours.len() > 2 || minutes.len() != 2 || seconds.len() < 2 {
        return None;
    }
    let hours: u32 = hours.parse().ok()?;
    let minutes: u32 = minutes.parse().ok()?;
    let seconds = seconds.replace(',', ".");
    let is_clock = seconds
        .bytes()
        .all(|byte| byte.is_ascii_digit() || byte == b'.');
    let seconds: f64 = seconds.parse().ok().filter(|_| is_clock)?;
    Some(f64::from(hours * 3600 + minutes * 60) + seconds)
}

/// Returns the days from 1970 to a date `2026-11-26`.
fn day(text: &str) -> Option<f64> {
    let mut parts = text.split(['-', '/']);
    let (year, month, day) = (parts.next()?, parts.next()?, parts.next()?);
    if parts.next().is_some() || year.len() != 4 {
        return None;
    }
    let (year, month, day): (i64, i64, i64) =
        (year.parse().ok()?, month.parse().ok()?, day.parse().ok()?);
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Days of the civil calendar, counted from March.
    let (year, month) = if month > 2 {
        (year, month - 3)
    } else {
        (year - 1, month + 9)
    };
    let days = year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    Some((days + (153 * month + 2) / 5 + day - 1 - 719_468) as f64)
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
    fn times_are_seconds() {
        assert_eq!(time_s("01:00:01.5"), Some(3601.5));
        assert_eq!(time_s("1970-01-02 00:00:00"), Some(86_400.0));
        assert_eq!(time_s("2026-11-26T00:00:01Z"), Some(1_795_651_201.0));
        assert_eq!(time_s("2000-03-01 00:00:00"), Some(951_868_800.0));
        for cell in ["12:34", "26.11.2026 12:00:00", "1.5", "a:bb:cc"] {
            assert_eq!(time_s(cell), None, "{cell}");
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
