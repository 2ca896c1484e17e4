//! Numbers in cells, with a decimal point or a decimal comma.

use crate::separator::Separator;

/// Decimal sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DecimalSign {
    Point,
    Comma,
}

/// Reader of the numbers of one table, which have one decimal sign.
#[derive(Debug, Clone)]
pub struct Numbers {
    separator: Separator,
    sign: Option<DecimalSign>,
}

/// Reason why a cell is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NumberFault {
    /// The cell has other characters.
    #[error("it is not a number")]
    NotNumber,
    /// The comma may be a decimal sign or may group thousands.
    #[error(
        "its comma may be a decimal sign or group thousands; write a decimal point, and no groups"
    )]
    Ambiguous,
    /// The cell has groups of thousands, or two decimal signs.
    #[error(
        "it has more than one decimal sign, or groups of thousands; write one decimal sign and no groups"
    )]
    Grouped,
    /// Another number of the table has the other decimal sign.
    #[error("an earlier number of the table has the other decimal sign; write one sign throughout")]
    OtherSign,
}

impl Numbers {
    /// Creates a reader for a table whose cells have this separator.
    #[must_use]
    pub fn new(separator: Separator) -> Self {
        Self {
            separator,
            sign: None,
        }
    }

    /// Returns whether the numbers are known to have decimal commas.
    #[must_use]
    pub fn has_commas(&self) -> bool {
        self.sign == Some(DecimalSign::Comma)
    }

    /// Returns whether no number had a decimal sign so far.
    #[must_use]
    pub fn is_undecided(&self) -> bool {
        self.sign.is_none()
    }

    /// States that the numbers have decimal points.
    pub fn assume_points(&mut self) {
        self.sign = Some(DecimalSign::Point);
    }

    /// States that the numbers have decimal commas.
    pub fn assume_commas(&mut self) {
        self.sign = Some(DecimalSign::Comma);
    }

    /// Reads a number; a missing value, `NA` or `n/a`, is NaN.
    ///
    /// # Errors
    /// [`NumberFault`] for any other cell without a number in it, and for an ambiguous one.
    pub fn read(&mut self, cell: &str) -> Result<f64, NumberFault> {
        if ["NA", "n/a", "N/A"].contains(&cell) {
            return Ok(f64::NAN);
        }
        // Word processors write U+2212 for a minus.
        let text = cell.replace('\u{2212}', "-");
        let (commas, points) = (text.matches(',').count(), text.matches('.').count());
        let sign = match (points, commas) {
            (0, 0) => None,
            (1, 0) => Some(DecimalSign::Point),
            (0, 1) => Some(DecimalSign::Comma),
            _ if text.bytes().any(|byte| byte.is_ascii_digit()) => {
                return Err(NumberFault::Grouped);
            }
            _ => return Err(NumberFault::NotNumber),
        };
        let number = text.replace(',', ".").parse();
        let number = number.map_err(|_| NumberFault::NotNumber)?;
        let Some(sign) = sign else {
            return Ok(number);
        };
        if self.sign.is_some_and(|earlier| earlier != sign) {
            return Err(NumberFault::OtherSign);
        }
        // Where semicolons separate cells, the comma is the decimal sign.
        let is_known = self.sign.is_some() || self.separator == Separator::Semicolon;
        if sign == DecimalSign::Comma && !is_known && is_thousand(&text) {
            return Err(NumberFault::Ambiguous);
        }
        self.sign = Some(sign);
        Ok(number)
    }
}

/// Returns whether the number reads as thousands in groups: `1,234`.
fn is_thousand(text: &str) -> bool {
    let Some((whole, rest)) = text.trim_start_matches(['+', '-']).split_once(',') else {
        return false;
    };
    (1..=3).contains(&whole.len())
        && !whole.starts_with('0')
        && rest.len() == 3
        && rest.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(separator: Separator, cells: &[&str]) -> Result<Vec<f64>, NumberFault> {
        let mut numbers = Numbers::new(separator);
        cells.iter().map(|cell| numbers.read(cell)).collect()
    }

    #[test]
    fn a_table_has_one_decimal_sign() {
        let tab = |cells: &[&str]| read(Separator::Tab, cells);
        assert_eq!(tab(&["5", "0,25", "1,5E-3"]).unwrap(), [5.0, 0.25, 1.5e-3]);
        assert_eq!(tab(&["-2.5", "1e3"]).unwrap(), [-2.5, 1e3]);
        assert_eq!(tab(&["\u{2212}2.5"]).unwrap(), [-2.5]);
        assert_eq!(tab(&["0,5", "1.5"]), Err(NumberFault::OtherSign));
        assert_eq!(tab(&["1.5", "0,5"]), Err(NumberFault::OtherSign));
        assert_eq!(tab(&["1.234,5"]), Err(NumberFault::Grouped));
        assert_eq!(tab(&["1,234,500"]), Err(NumberFault::Grouped));
        assert_eq!(tab(&["4 N"]), Err(NumberFault::NotNumber));
        assert_eq!(tab(&["Zeit, s"]), Err(NumberFault::NotNumber));
        assert!(tab(&["NA"]).unwrap()[0].is_nan());
    }

    #[test]
    fn a_comma_before_three_digits_is_ambiguous_until_another_number_decides() {
        assert_eq!(
            read(Separator::Tab, &["1,234"]),
            Err(NumberFault::Ambiguous)
        );
        assert_eq!(
            read(Separator::Semicolon, &["1,234"]).unwrap(),
            [1.234],
            "where semicolons separate cells"
        );
        assert_eq!(
            read(Separator::Tab, &["0,125", "1,234"]).unwrap(),
            [0.125, 1.234]
        );
    }
}
