//! Tests that prove each row of FAULTS.md and HAZARDS.md: docs/traces.md and its gaps.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::tags::{Row, Test};

/// The command that renews docs/traces.md.
pub const RENEW: &str = "FRICTION_BENCH_WRITE_TRACES=1 cargo test --workspace --test architecture";

/// A row that requires tests.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// The row.
    pub row: Row,
    /// Title of the row.
    pub title: String,
    /// The document's reason if the row has no test: `planned` or `none`.
    pub untested: Option<&'static str>,
}

/// A disagreement between the documents and the tests.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Gap {
    /// No test proves a row.
    #[error(
        "no test is tagged with {row} ({title}): write `/// Fault N.` or `/// Hazard N.` above one that proves it"
    )]
    NoTest {
        /// The row.
        row: Row,
        /// Title of the row.
        title: String,
    },
    /// A test names a row that its document does not have.
    #[error("{test} is tagged with {row}, which does not exist")]
    NoSuchRow {
        /// The test.
        test: String,
        /// The row.
        row: Row,
    },
    /// A test proves a row that its document declares untested.
    #[error("{test} is tagged with {row}, of which its document says: {untested}")]
    SaidToBeUntested {
        /// The test.
        test: String,
        /// The row.
        row: Row,
        /// The reason in the document.
        untested: &'static str,
    },
    /// A document names a test that does not exist.
    #[error("HAZARDS.md names `{test}`, which does not exist")]
    NoSuchTest {
        /// The test.
        test: String,
    },
    /// docs/traces.md differs from the documents and the tests.
    #[error("docs/traces.md is out of date from line {line} on; renew it: {RENEW}")]
    Stale {
        /// The first line that differs.
        line: usize,
    },
}

/// Reads the table of FAULTS.md.
pub fn faults(document: &str) -> Vec<Entry> {
    let rows = document
        .lines()
        .skip_while(|line| !line.starts_with("| ---"))
        .skip(1)
        .take_while(|line| line.starts_with('|'));
    let entry = |line: &str| {
        let mut cells = line.split('|').skip(1).map(str::trim);
        let number = cells.next()?;
        let (number, reason) = match number.strip_suffix(", planned") {
            Some(number) => (number, Some("planned")),
            None => (number, None),
        };
        Some(Entry {
            row: Row::Fault(number.parse().ok()?),
            title: beginning(cells.next()?).to_owned(),
            untested: reason,
        })
    };
    rows.filter_map(entry).collect()
}

/// Returns a sentence up to its first punctuation mark other than a comma: commas separate kinds of one fault.
fn beginning(sentence: &str) -> &str {
    let marks = [": ", "; ", " (", ", e.g. "];
    let end = marks.iter().filter_map(|mark| sentence.find(mark)).min();
    &sentence[..end.unwrap_or(sentence.len())]
}

/// Reads the numbered sections of HAZARDS.md.
pub fn hazards(document: &str) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut is_hazard = false;
    for line in document.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            let title_parts = heading.split_once(". ");
            let title_parts =
                title_parts.and_then(|(number, title)| Some((number.parse().ok()?, title)));
            is_hazard = title_parts.is_some();
            entries.extend(title_parts.map(|(number, title)| Entry {
                row: Row::Hazard(number),
                title: title.to_owned(),
                untested: None,
            }));
        } else if is_hazard
            && line.starts_with("- **Tests:** none")
            && let Some(entry) = entries.last_mut()
        {
            entry.untested = Some("none");
        }
    }
    entries
}

/// Returns the names of the tests of each row that has any.
pub fn traces(tests: &[Test]) -> BTreeMap<Row, BTreeSet<&str>> {
    let mut traces = BTreeMap::<_, BTreeSet<_>>::new();
    for test in tests {
        for &row in &test.proves {
            traces.entry(row).or_default().insert(test.name.as_str());
        }
    }
    traces
}

/// Returns the rows without a test, and the tags of rows that do not exist.
pub fn gaps(entries: &[Entry], tests: &[Test]) -> Vec<Gap> {
    let traces = traces(tests);
    let mut gaps = Vec::new();
    for Entry {
        row,
        title,
        untested,
    } in entries
    {
        if untested.is_none() && !traces.contains_key(row) {
            let (row, title) = (*row, title.clone());
            gaps.push(Gap::NoTest { row, title });
        }
    }
    for (row, names) in traces {
        let entry = entries.iter().find(|entry| entry.row == row);
        for test in names.into_iter().map(str::to_owned) {
            match entry.map(|entry| entry.untested) {
                None => gaps.push(Gap::NoSuchRow { test, row }),
                Some(Some(untested)) => gaps.push(Gap::SaidToBeUntested {
                    test,
                    row,
                    untested,
                }),
                Some(None) => {}
            }
        }
    }
    gaps
}

/// Returns the tests that a document names between backquotes, as `package::function`, but that do not exist.
pub fn names_without_a_test(document: &str, tests: &[Test]) -> Vec<Gap> {
    let known: BTreeSet<&str> = tests.iter().map(|test| test.name.as_str()).collect();
    let name = |c: char| c.is_ascii_alphanumeric() || "_-:".contains(c);
    let spans = document.split('`').skip(1).step_by(2);
    let names = spans.filter(|text| text.contains("::") && text.chars().all(name));
    let gaps = names.filter(|name| !known.contains(name));
    let gaps = gaps.map(|test| Gap::NoSuchTest {
        test: test.to_owned(),
    });
    gaps.collect()
}

/// Returns the text of docs/traces.md.
pub fn document(faults: &[Entry], hazards: &[Entry], tests: &[Test]) -> String {
    let mut text = format!(
        "# Traces\n\
         The tests that prove each row of [FAULTS.md](FAULTS.md) and each hazard of [HAZARDS.md](HAZARDS.md), as\n\
         `package::function`. A test names its rows in its doc comment: `/// Fault 16.`, `/// Hazards 3, 10.` This\n\
         page is generated. A row without a test, and a page that is out of date, fail the architecture test. To\n\
         renew the page:\n\n\
         ```sh\n{RENEW}\n```\n"
    );
    let traces = traces(tests);
    for (heading, columns, entries) in [
        ("Faults", "| row | fault | tests |", faults),
        ("Hazards", "| no. | hazard | tests |", hazards),
    ] {
        let _ = write!(text, "\n## {heading}\n{columns}\n| --- | --- | --- |\n");
        for Entry {
            row,
            title,
            untested,
        } in entries
        {
            let (Row::Fault(number) | Row::Hazard(number)) = row;
            let names = traces.get(row).into_iter().flatten();
            let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
            let tests = match untested {
                Some(untested) if names.is_empty() => (*untested).to_owned(),
                _ => names.join(", "),
            };
            let _ = writeln!(text, "| {number} | {title} | {tests} |");
        }
    }
    text
}

/// Compares `text`, the content of docs/traces.md, with its `expected` text.
pub fn stale(text: &str, expected: &str) -> Option<Gap> {
    if text == expected {
        return None;
    }
    let common_lines = text.lines().zip(expected.lines());
    let common_lines = common_lines.take_while(|(text, expected)| text == expected);
    Some(Gap::Stale {
        line: common_lines.count() + 1,
    })
}
