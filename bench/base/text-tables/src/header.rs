//! Headers of tables.

use std::borrow::Cow;

use crate::cells::cells;
use crate::fault::TableFault;
use crate::lines::BYTE_ORDER_MARK;
use crate::separator::Separator;
use crate::unit::unit;

/// Number of characters of a header in messages.
const SHOWN: usize = 80;

/// Columns that a reader needs, and those that a table may omit. The ending of a name states the unit of its numbers; a
/// column without one has text.
#[derive(Debug, Clone, Copy)]
pub struct Columns {
    /// Names of the required columns.
    pub required: &'static [&'static str],
    /// Names of the optional columns.
    pub optional: &'static [&'static str],
}

impl Columns {
    /// Returns the names, the required ones first.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        self.required.iter().chain(self.optional).copied()
    }
}

/// Header of a table.
#[derive(Debug, Clone)]
pub struct Header {
    /// Separator of the table's cells.
    pub separator: Separator,
    /// Number of columns in the table.
    pub width: usize,
    places: Vec<(&'static str, Option<usize>)>,
}

impl Header {
    /// Finds `columns` in the header `line`, by name in any order and case; further columns are ignored. Without a stated
    /// separator, it is the one that yields most of the columns.
    ///
    /// # Errors
    /// A required column is missing, an optional one is there in another unit, or one is there twice.
    pub fn read(
        line: &str,
        stated: Option<Separator>,
        columns: &Columns,
    ) -> Result<Self, TableFault> {
        let line = line.trim_start_matches(BYTE_ORDER_MARK);
        let count = |separator: Separator| {
            let names = cells(line, separator);
            let found = columns
                .names()
                .filter(|column| place(&names, column).is_some());
            (found.count(), names.len())
        };
        let separator = stated.unwrap_or_else(|| {
            let candidates = Separator::ALL.into_iter();
            candidates
                .max_by_key(|candidate| count(*candidate))
                .unwrap_or(Separator::Comma)
        });
        let names = cells(line, separator);
        let mut places = Vec::new();
        for column in columns.names() {
            let place = place(&names, column);
            let is_same = |name: &&Cow<'_, str>| name.eq_ignore_ascii_case(column);
            if names.iter().filter(is_same).count() > 1 {
                return Err(TableFault::Twice {
                    column: column.to_owned(),
                });
            }
            let other_unit = || other_unit(&names, column).map(str::to_owned);
            if place.is_none() && columns.required.contains(&column) {
                return Err(TableFault::MissingColumn {
                    column: column.to_owned(),
                    header: beginning(line),
                    separator,
                    nearest: other_unit(),
                });
            }
            if let (None, Some(found), Some(unit)) = (place, other_unit(), unit(column)) {
                let column = column.to_owned();
                return Err(TableFault::OtherUnit {
                    found,
                    column,
                    unit,
                });
            }
            places.push((column, place));
        }
        Ok(Self {
            separator,
            width: names.len(),
            places,
        })
    }

    /// Returns the names of the columns that are read, the required ones first, with their places in a line.
    pub fn places(&self) -> impl Iterator<Item = (&'static str, Option<usize>)> {
        self.places.iter().copied()
    }
}

fn place(names: &[Cow<'_, str>], column: &str) -> Option<usize> {
    names
        .iter()
        .position(|name| name.eq_ignore_ascii_case(column))
}

/// Returns the name that differs from `column` only in its unit.
fn other_unit<'a>(names: &'a [Cow<'_, str>], column: &str) -> Option<&'a str> {
    unit(column)?;
    let (stem, _) = column.rsplit_once('_')?;
    let is_like = |name: &&Cow<'_, str>| {
        let name = name.to_ascii_lowercase();
        let end = name.strip_prefix(stem);
        let end = end.filter(|end| end.is_empty() || !end.starts_with(char::is_alphanumeric));
        // `known_at_hz` is not `known_um` in another unit.
        end.is_some_and(|end| !end.trim_start_matches('_').contains('_'))
    };
    names.iter().find(is_like).map(AsRef::as_ref)
}

/// Returns the separator that a line `sep=;` states, which spreadsheets write before the header.
///
/// ```
/// use text_tables::{Separator, stated_separator};
///
/// assert_eq!(stated_separator("sep=;"), Some(Separator::Semicolon));
/// assert_eq!(stated_separator("drive_v;known_um"), None);
/// ```
#[must_use]
pub fn stated_separator(line: &str) -> Option<Separator> {
    let line = line.trim_matches([BYTE_ORDER_MARK, ' ', '\r', '\n', '"']);
    let (key, value) = line.split_once('=')?;
    let is_stated = |separator: &Separator| value.starts_with(separator.character());
    let separator = Separator::ALL.into_iter().find(is_stated);
    separator.filter(|_| key.eq_ignore_ascii_case("sep"))
}

/// Returns the beginning of a header, for messages.
fn beginning(line: &str) -> String {
    let printable = |c: char| if c.is_control() { ' ' } else { c };
    line.trim_end_matches(['\r', '\n'])
        .chars()
        .map(printable)
        .take(SHOWN)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: Columns = Columns {
        required: &["drive_v", "known_um"],
        optional: &["known_at_hz"],
    };

    fn read(line: &str) -> Result<Header, TableFault> {
        Header::read(line, None, &COLUMNS)
    }

    fn places(line: &str) -> Vec<Option<usize>> {
        let header = read(line).unwrap();
        header.places().map(|(_, place)| place).collect()
    }

    #[test]
    fn columns_are_found_by_name_with_any_separator() {
        for line in [
            "drive_v,known_um",
            "\u{feff}drive_v;known_um",
            "drive_v\tknown_um",
            "\"drive_v\",\"known_um\"",
            " Drive_V ; KNOWN_UM ",
        ] {
            assert_eq!(places(line), [Some(0), Some(1), None], "{line:?}");
        }
        let line = "\"\";note, free;known_at_hz;known_um;drive_v";
        assert_eq!(places(line), [Some(4), Some(3), Some(2)]);
        assert_eq!(read(line).unwrap().width, 5);
    }

    #[test]
    fn a_column_in_another_unit_is_named() {
        let missing = |line: &str| match read(line).unwrap_err() {
            TableFault::MissingColumn {
                column, nearest, ..
            } => (column, nearest),
            other => panic!("{other}"),
        };
        for (line, found) in [
            ("drive_v;known_nm", Some("known_nm")),
            ("drive_v,known (um)", Some("known (um)")),
            ("drive_v,known", Some("known")),
            ("drive_v,knowledge_um,known_at_hz", None),
        ] {
            let expected = ("known_um".to_owned(), found.map(str::to_owned));
            assert_eq!(missing(line), expected, "{line}");
        }
        let fault = Header::read(
            "axis,mass_g,sigma_mg",
            None,
            &Columns {
                required: &["axis", "mass_g"],
                optional: &["sigma_g"],
            },
        );
        assert!(
            matches!(&fault, Err(TableFault::OtherUnit { found, unit: "g", .. }) if found == "sigma_mg"),
            "{fault:?}"
        );
        let fault = read("drive_v,known_um,Drive_v").unwrap_err();
        assert!(matches!(fault, TableFault::Twice { .. }), "{fault}");
    }

    #[test]
    fn a_stated_separator_is_obeyed() {
        assert_eq!(
            stated_separator("\u{feff}sep=,\r\n"),
            Some(Separator::Comma)
        );
        assert_eq!(stated_separator("\"SEP=\t\""), Some(Separator::Tab));
        assert_eq!(stated_separator("sep=|"), None);
        assert_eq!(stated_separator("a=;"), None);
        let fault = Header::read("drive_v,known_um", Some(Separator::Tab), &COLUMNS);
        assert!(fault.is_err());
    }
}
