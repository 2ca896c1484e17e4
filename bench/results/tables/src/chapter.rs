//! Dictionary of the columns as a chapter of the handbook.

use std::fmt::Write as _;

use analysis::{Analysis, KeptSeries, SeriesError};
use attempts::Attempts;
use descriptive::Description;
use study::exclusions::RecordingSelection;

use crate::column::Table;
use crate::content::Content;
use crate::dictionary::{Entry, entries, skin_entries};

/// Returns the chapter of the handbook: each table with its columns.
#[must_use]
pub fn chapter() -> String {
    let mut text = INTRODUCTION.to_owned();
    let mut section = |name: &str, row: &str, entries: &[Entry]| {
        let _ = write!(
            text,
            "\n## {name}\nA row for each {row}.\n\n| column | type | unit | meaning |\n| --- | --- | --- | --- |\n"
        );
        for entry in entries {
            let Entry {
                column,
                type_name,
                unit,
                ..
            } = entry;
            let meaning = entry.meaning.replace('|', "\\|");
            let _ = writeln!(text, "| `{column}` | {type_name} | {unit} | {meaning} |");
        }
    };
    each_table(|table| section(table.name, table.row, &entries(table)));
    section(
        "skin",
        "parameter of a recording, a participant or the study; identified by level, participant, recording, parameter",
        &skin_entries(),
    );
    text
}

const INTRODUCTION: &str = "# Columns of the tables
`friction-bench analyze STUDY --tables DIR` writes the tables of this chapter as CSV and Parquet (`skin` as CSV only), and this list
as `columns.csv`; each Parquet file also has the list of its columns in its metadata, under `columns`. Values are in SI units: amplitudes
are peak values in m, a fall of friction of 0.93 is one of 93 %. Unknown numbers are empty cells in CSV and NaN in Parquet.
[Your recordings in Python, MATLAB and R](your-recordings.md) has examples.
";

/// Calls `take` with each table of an analysis without recordings.
fn each_table(mut take: impl FnMut(&Table)) {
    let analysed = Analysis::default();
    let content = Content {
        analysed: &analysed,
        series: &KeptSeries::default(),
        description: &Description::new(&analysed),
        attempts: &Attempts::default(),
        selection: &RecordingSelection::default(),
    };
    let result: Result<(), SeriesError> = content.tables(|table| {
        take(table);
        Ok(())
    });
    debug_assert!(result.is_ok(), "no recording has series to read");
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Units that the end of a column's name states.
    const UNITS: [(&str, &str); 12] = [
        ("_n_s_per_m", "N·s/m"),
        ("_rad_per_m", "rad/m"),
        ("_n_per_m", "N/m"),
        ("_rad", "rad"),
        ("_m2", "m²"),
        ("_hz", "Hz"),
        ("_pa", "Pa"),
        ("_m_per_s", "m/s"),
        ("_s", "s"),
        ("_m", "m"),
        ("_w", "W"),
        ("_v", "V"),
    ];

    fn all_entries() -> Vec<Entry> {
        let mut list = Vec::new();
        each_table(|table| list.extend(entries(table)));
        list.extend(skin_entries());
        list
    }

    #[test]
    fn each_column_has_a_meaning_once_and_the_unit_of_its_name() {
        let mut names = BTreeSet::new();
        for entry in all_entries() {
            let (table, column) = (entry.table, &entry.column);
            assert!(
                names.insert((table, column.clone())),
                "{table}.{column} twice"
            );
            assert!(!entry.meaning.is_empty(), "{table}.{column} has no meaning");
            let mut units = UNITS.iter();
            let stated = units.find(|(ending, _)| column.ends_with(ending));
            if let ("real", Some((_, unit))) = (entry.type_name, stated) {
                assert_eq!(entry.unit, *unit, "{table}.{column}");
            }
            if entry.type_name == "real" {
                assert!(!entry.unit.is_empty(), "{table}.{column} has no unit");
            }
        }
    }

    /// Columns by which a researcher groups or merges must mean the same in every table.
    #[test]
    fn a_name_means_the_same_quantity_in_every_table() {
        let mut known: Vec<Entry> = Vec::new();
        for entry in all_entries() {
            if let Some(first) = known.iter().find(|known| known.column == entry.column) {
                let (table, column) = (entry.table, &entry.column);
                assert_eq!(
                    first.unit, entry.unit,
                    "{column} of {} and {table}",
                    first.table
                );
                assert_eq!(first.type_name, entry.type_name, "{column} of {table}");
            }
            known.push(entry);
        }
    }
}
