//! Choice of a sweep's columns.

use std::fmt;
use std::str::FromStr;

use crate::sweep_fault::SweepFault;
use crate::sweep_unit::SweepUnit;

/// Three columns: frequency, and two parts of the response.
///
/// Each is a heading, a heading without its unit, or a number from 0; a unit in square brackets replaces that of the file, as in
/// `f[kHz],mag[dB],phase[deg]`.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnChoice {
    text: String,
    pub(crate) columns: [ChosenColumn; 3],
}

/// One chosen column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChosenColumn {
    pub(crate) name: String,
    pub(crate) unit: Option<SweepUnit>,
}

impl fmt::Display for ColumnChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for ColumnChoice {
    type Err = SweepFault;

    fn from_str(text: &str) -> Result<Self, SweepFault> {
        let columns: Vec<ChosenColumn> = pieces(text)
            .into_iter()
            .map(chosen)
            .collect::<Result<_, _>>()?;
        let count = columns.len();
        let columns = columns.try_into().map_err(|_| SweepFault::ColumnCount {
            choice: text.to_owned(),
            count,
        })?;
        Ok(Self {
            text: text.trim().to_owned(),
            columns,
        })
    }
}

/// Returns the pieces between commas, but not those within brackets.
fn pieces(text: &str) -> Vec<&str> {
    let mut depth = 0i32;
    let split = text.split(move |c: char| {
        match c {
            '[' | '(' => depth += 1,
            ']' | ')' => depth -= 1,
            _ => {}
        }
        c == ',' && depth <= 0
    });
    split
        .map(str::trim)
        .filter(|piece| !piece.is_empty())
        .collect()
}

fn chosen(text: &str) -> Result<ChosenColumn, SweepFault> {
    let split = text
        .strip_suffix(']')
        .and_then(|text| text.rsplit_once('['));
    let Some((name, unit)) = split.filter(|(name, _)| !name.trim().is_empty()) else {
        return Ok(ChosenColumn {
            name: text.to_owned(),
            unit: None,
        });
    };
    let unit = SweepUnit::parse(unit).ok_or_else(|| SweepFault::UnknownUnit {
        unit: unit.to_owned(),
    })?;
    Ok(ChosenColumn {
        name: name.trim().to_owned(),
        unit: Some(unit),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_columns_are_chosen_with_their_units() {
        let names = |text: &str| -> Vec<(String, bool)> {
            let choice: ColumnChoice = text.parse().unwrap();
            let columns = choice.columns.into_iter();
            columns.map(|c| (c.name, c.unit.is_some())).collect()
        };
        let owned = |row: [(&str, bool); 3]| row.map(|(name, unit)| (name.to_owned(), unit));
        assert_eq!(
            names("f,G,B"),
            owned([("f", false), ("G", false), ("B", false)])
        );
        assert_eq!(
            names(" f [kHz], mag[dB re 1 m/V] ,2"),
            owned([("f", true), ("mag", true), ("2", false)])
        );
        assert_eq!(
            "f,G".parse::<ColumnChoice>().unwrap_err(),
            SweepFault::ColumnCount {
                choice: "f,G".to_owned(),
                count: 2
            }
        );
        let fault = "f[kHzz],G,B".parse::<ColumnChoice>().unwrap_err();
        assert!(matches!(fault, SweepFault::UnknownUnit { unit } if unit == "kHzz"));
    }
}
