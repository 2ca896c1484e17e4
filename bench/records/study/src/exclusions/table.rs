//! Table of exclusions: a line for each, with tabs between cells.
//!
//! Tabs, line ends and backslashes within a cell are written `\t`, `\n`, `\r`, `\\`.

use std::path::{Path, PathBuf};

use recording::disk::{self, OnPath};
use recording::storage::Storage;
use recording::study::{EXCLUSIONS_FILE, ID_COLUMN};
use text_tables::{Separator, TabTable, TableFault, TableLine, tab_cell};

use crate::exclusions::exclusion::{ALL, AllOrOne, Exclusion, number};
use crate::exclusions::exclusions_error::ExclusionsError;
use crate::exclusions::known;

const COLUMNS: [&str; 6] = ["participant_id", "session", "trial", "reason", "by", "date"];
/// Columns that a table may omit.
const OPTIONAL: [&str; 2] = ["session", "date"];
const NOT_STATED: &str = "n/a";
/// Extensions of tables and of their copies.
const TABLES: [&str; 10] = [
    "tsv", "csv", "txt", "xlsx", "xls", "ods", "numbers", "bak", "old", "tmp",
];

/// Exclusions of a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exclusions {
    /// Folder of the study.
    pub study: PathBuf,
    /// Exclusions in the order of their lines.
    pub list: Vec<Exclusion>,
    /// Line number of each exclusion.
    lines: Vec<usize>,
}

impl Exclusions {
    /// Returns the exclusions of a study without any.
    fn empty(study: &Path) -> Self {
        Self {
            study: study.to_owned(),
            list: Vec::new(),
            lines: Vec::new(),
        }
    }

    /// Requires every named participant, session and trial to be in the study.
    ///
    /// # Errors
    /// [`ExclusionsError::Unknown`] names the line, and the most similar name.
    pub fn require_known(&self) -> Result<(), ExclusionsError> {
        for (exclusion, line) in self.list.iter().zip(&self.lines) {
            if let Some(part) = known::missing_part(&self.study, exclusion)? {
                return Err(ExclusionsError::Unknown {
                    path: self.study.join(EXCLUSIONS_FILE),
                    line: Some(*line),
                    part,
                });
            }
        }
        Ok(())
    }
}

/// Reads the exclusions of the study in `folder`; a missing table means no exclusions.
///
/// # Errors
/// The table cannot be read; the error names line, column and cell.
pub fn read(folder: &Path) -> Result<Exclusions, ExclusionsError> {
    let path = folder.join(EXCLUSIONS_FILE);
    match bounded_files::read(&path, bounded_files::TEXT_LIMIT_BYTES) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Exclusions::empty(folder)),
        bytes => parse(&bytes.with_path("read", &path)?, folder),
    }
}

/// Returns the files of a study that are named as if they held its exclusions, which nothing reads: copies of a sync program, or
/// a table saved under another name.
#[must_use]
pub fn unread(study: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(study).into_iter().flatten().flatten();
    let is_unread = |name: &str| {
        let name = name.to_lowercase();
        let is_named = name
            .trim_start_matches(['.', '~', '_'])
            .starts_with("exclusions");
        let extension = Path::new(&name)
            .extension()
            .and_then(|extension| extension.to_str());
        let is_table = extension.is_none_or(|extension| TABLES.contains(&extension));
        is_named && is_table
    };
    let is_unread = |name: &str| name != EXCLUSIONS_FILE && is_unread(name);
    let files = entries.filter(|entry| entry.file_name().to_str().is_some_and(is_unread));
    let mut paths: Vec<PathBuf> = files.map(|entry| entry.path()).collect();
    paths.retain(|path| path.is_file());
    paths.sort_unstable();
    paths
}

fn parse(bytes: &[u8], folder: &Path) -> Result<Exclusions, ExclusionsError> {
    let path = || folder.join(EXCLUSIONS_FILE);
    let table_error = |fault| ExclusionsError::Table {
        path: path(),
        fault,
    };
    let text = bounded_files::as_text(bytes).map_err(|refusal| ExclusionsError::NoText {
        path: path(),
        refusal,
    })?;
    let mut exclusions = Exclusions::empty(folder);
    // An emptied table is a lost one.
    let table = TabTable::parse(text.to_owned(), ID_COLUMN).map_err(table_error)?;
    let places = places(table.columns(), &path)?;
    if let Some(fault) = table.uneven_row() {
        return Err(table_error(fault));
    }
    for TableLine {
        number: line,
        cells,
        ..
    } in table.rows()
    {
        let line = *line;
        let cell = |column: usize| places[column].map_or("", |index| cells[index].as_str());
        let exclusion = exclusion(cell).map_err(|(column, why)| ExclusionsError::Cell {
            path: path(),
            line,
            column: COLUMNS[column],
            value: cell(column).to_owned(),
            why,
        })?;
        exclusions.list.push(exclusion);
        exclusions.lines.push(line);
    }
    Ok(exclusions)
}

/// Returns the index of each of [`COLUMNS`] in the header.
fn places(
    columns: &[String],
    path: &impl Fn() -> PathBuf,
) -> Result<[Option<usize>; 6], ExclusionsError> {
    let mut places = [None; 6];
    for (index, name) in columns.iter().enumerate() {
        let column = COLUMNS.iter().position(|column| column == name);
        match column {
            Some(column) if places[column].is_none() => places[column] = Some(index),
            _ => {
                return Err(ExclusionsError::UnknownColumn {
                    path: path(),
                    column: name.clone(),
                    nearest: strict_toml::nearest(name, &COLUMNS).filter(|nearest| nearest != name),
                });
            }
        }
    }
    for (column, place) in COLUMNS.into_iter().zip(places) {
        if place.is_none() && !OPTIONAL.contains(&column) {
            return Err(ExclusionsError::Table {
                path: path(),
                fault: TableFault::MissingColumn {
                    column: column.to_owned(),
                    header: columns.join(" "),
                    separator: Separator::Tab,
                    nearest: None,
                },
            });
        }
    }
    Ok(places)
}

/// Parses the exclusion of a line; an error carries the index of its column.
fn exclusion<'a>(cell: impl Fn(usize) -> &'a str) -> Result<Exclusion, (usize, String)> {
    let participant = cell(0)
        .parse()
        .map_err(|error: protocols::ParticipantIdError| (0, error.to_string()))?;
    let session = match cell(1) {
        "" | ALL | NOT_STATED => AllOrOne::All,
        text => AllOrOne::One(number(text).ok_or_else(|| {
            let why = format!("a session is its number from 1, or `{ALL}`");
            (1, why)
        })?),
    };
    let trial = match cell(2) {
        ALL => AllOrOne::All,
        text => AllOrOne::One(
            text.parse()
                .map_err(|why| (2, format!("{why}, or `{ALL}`")))?,
        ),
    };
    let optional_text = |column: usize| {
        let text = unescape(escaping::from_cell(cell(column)));
        (!text.is_empty() && text != NOT_STATED).then_some(text)
    };
    let required_text = |column: usize, what: &str| {
        optional_text(column).ok_or_else(|| (column, format!("{what} is needed")))
    };
    Ok(Exclusion {
        participant,
        session,
        trial,
        reason: required_text(3, "a reason")?,
        by: required_text(4, "who decided it")?,
        date: optional_text(5),
    })
}

/// Returns the table of `list`, with its header.
#[must_use]
pub fn to_tsv<'a>(list: impl IntoIterator<Item = &'a Exclusion>) -> String {
    let mut text = COLUMNS.join("\t") + "\n";
    for exclusion in list {
        let cells = cells(exclusion);
        let cells: Vec<_> = cells.iter().map(|cell| tab_cell(cell)).collect();
        text += &(cells.join("\t") + "\n");
    }
    text
}

/// Returns the cells of an exclusion, in the order of [`COLUMNS`].
fn cells(exclusion: &Exclusion) -> [String; 6] {
    [
        exclusion.participant.to_string(),
        exclusion.session.to_string(),
        exclusion.trial.to_string(),
        cell(&exclusion.reason),
        cell(&exclusion.by),
        exclusion
            .date
            .as_deref()
            .map_or_else(|| NOT_STATED.to_owned(), cell),
    ]
}

/// Returns the text of a table with a further exclusion; every other byte is kept.
fn with_exclusion(text: &str, exclusion: &Exclusion) -> String {
    let Ok(mut table) = TabTable::parse(text.to_owned(), ID_COLUMN) else {
        return to_tsv([exclusion]);
    };
    for column in COLUMNS {
        // Without its column, an exclusion of one session would be one of all sessions.
        if table.column(column).is_none() {
            table.add_column(column);
        }
    }
    let cells = cells(exclusion);
    let values: Vec<_> = COLUMNS
        .into_iter()
        .zip(cells.iter().map(String::as_str))
        .collect();
    table.add_row(&values);
    table.text().to_owned()
}

/// Adds an exclusion to the table of the study in `folder`; every other byte of the table is kept.
///
/// # Errors
/// The study does not have the named participant, session or trial, the exclusion exists already, or the disk
/// refused; the table is then unchanged.
pub fn add(
    storage: &dyn Storage,
    folder: &Path,
    exclusion: &Exclusion,
) -> Result<(), ExclusionsError> {
    let path = folder.join(EXCLUSIONS_FILE);
    let (bytes, exclusions) = if disk::exists(storage, &path)? {
        let bytes = disk::read_on(storage, &path, bounded_files::TEXT_LIMIT_BYTES)?;
        let exclusions = parse(&bytes, folder)?;
        (bytes, exclusions)
    } else {
        (Vec::new(), Exclusions::empty(folder))
    };
    if let Some(part) = known::missing_part(folder, exclusion)? {
        return Err(ExclusionsError::Unknown {
            path: folder.to_owned(),
            line: None,
            part,
        });
    }
    let is_same = |candidate: &&Exclusion| {
        let key = |exclusion: &Exclusion| {
            (
                exclusion.participant.clone(),
                exclusion.session,
                exclusion.trial,
            )
        };
        key(candidate) == key(exclusion)
    };
    if let Some(existing) = exclusions.list.iter().find(is_same) {
        return Err(ExclusionsError::Already {
            path,
            existing: existing.to_string(),
        });
    }
    let text = with_exclusion(&String::from_utf8_lossy(&bytes), exclusion);
    Ok(disk::replace_file_on(storage, &path, text.as_bytes())?)
}

/// Returns a text as one cell, which a spreadsheet does not read as a formula.
pub fn cell(text: &str) -> String {
    escaping::to_cell(&escape(text))
}

/// Escapes the characters that would end a cell.
fn escape(text: &str) -> String {
    let mut cell = String::new();
    for c in text.trim().chars() {
        match c {
            '\\' => cell.push_str("\\\\"),
            '\t' => cell.push_str("\\t"),
            '\n' => cell.push_str("\\n"),
            '\r' => cell.push_str("\\r"),
            c => cell.push(printable_char(c)),
        }
    }
    cell
}

/// Replaces a character that a cell cannot show with a space: control characters and Unicode line ends.
fn printable_char(c: char) -> char {
    if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
        ' '
    } else {
        c
    }
}

/// Reverses `escape`; a backslash before any other character stands for itself.
fn unescape(cell: &str) -> String {
    let mut text = String::new();
    let mut chars = cell.chars();
    while let Some(c) = chars.next() {
        if c != '\\' {
            text.push(printable_char(c));
            continue;
        }
        match chars.next() {
            Some('t') => text.push('\t'),
            Some('n') => text.push('\n'),
            Some('r') => text.push('\r'),
            Some('\\') => text.push('\\'),
            Some(other) => text.extend(['\\', printable_char(other)]),
            None => text.push('\\'),
        }
    }
    text.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exclusions::exclusion::SessionTrial;
    use crate::exclusions::exclusions_error::Unknown;
    use proptest::prelude::*;
    use recording::storage::FileSystem;
    use recording::study::TrialBlock;

    fn parse_text(text: &str) -> Result<Exclusions, ExclusionsError> {
        parse(text.as_bytes(), Path::new("study"))
    }

    fn exclusion_of(participant: &str, trial: AllOrOne<SessionTrial>) -> Exclusion {
        Exclusion {
            participant: participant.parse().unwrap(),
            session: AllOrOne::All,
            trial,
            reason: "why".to_owned(),
            by: "N. H.".to_owned(),
            date: None,
        }
    }

    fn main(number: u32) -> AllOrOne<SessionTrial> {
        AllOrOne::One(SessionTrial {
            block: TrialBlock::Main,
            number,
        })
    }

    #[test]
    fn a_handwritten_table_needs_four_columns_in_any_order() {
        let text = "\u{feff}trial\tby\tparticipant_id\treason\r\nall\tN. H.\tsub-07\tbroken\r\n\r\npractice-2\tN. H.\tsub-08\tx\r\n";
        let exclusions = parse_text(text).unwrap();
        assert_eq!(exclusions.list[0].trial, AllOrOne::All);
        assert_eq!(exclusions.list[0].to_string(), "sub-07: broken (N. H.)");
        let practice = SessionTrial {
            block: TrialBlock::Practice,
            number: 2,
        };
        assert_eq!(exclusions.list[1].trial, AllOrOne::One(practice));
        assert_eq!(exclusions.lines, [2, 4]);
        let header = text.lines().next().unwrap();
        assert!(parse_text(header).unwrap().list.is_empty());
    }

    #[test]
    fn an_emptied_table_is_refused_and_a_renamed_one_is_named() {
        for text in ["", "\n\n"] {
            let error = parse_text(text).unwrap_err().to_string();
            assert!(error.contains("it is empty"), "{error}");
        }
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path();
        assert!(read(study).unwrap().list.is_empty() && unread(study).is_empty());
        let others = [
            "Exclusions.tsv",
            "exclusions (conflicted copy).tsv",
            "exclusions.csv",
            "exclusions.tsv.txt",
        ];
        let texts = [
            "exclusions.md",
            "exclusion_criteria.pdf",
            "participants.tsv",
        ];
        for name in others.iter().chain(&texts).chain(&[EXCLUSIONS_FILE]) {
            std::fs::write(study.join(name), "").unwrap();
        }
        let found = unread(study);
        assert_eq!(found.len(), others.len(), "{found:?}");
        assert!(
            others.iter().all(|name| found.contains(&study.join(name))),
            "{found:?}"
        );
    }

    #[test]
    fn faults_are_named_by_line_and_column() {
        let header = "participant_id\tsession\ttrial\treason\tby\tdate\n";
        let error_in = |line: &str| parse_text(&format!("{header}{line}\n")).unwrap_err();
        for (line, column) in [
            ("sub 7\tall\tall\tx\ty\tn/a", "participant_id"),
            ("../sub-07\tall\tall\tx\ty\tn/a", "participant_id"),
            ("sub-07\t0\tall\tx\ty\tn/a", "session"),
            ("sub-07\tses-01\tall\tx\ty\tn/a", "session"),
            ("sub-07\tall\t\tx\ty\tn/a", "trial"),
            ("sub-07\tall\t0\tx\ty\tn/a", "trial"),
            ("sub-07\tall\t+3\tx\ty\tn/a", "trial"),
            ("sub-07\tall\t99999999999\tx\ty\tn/a", "trial"),
            ("sub-07\tall\t3\tn/a\ty\tn/a", "reason"),
            ("sub-07\tall\t3\tx\t \tn/a", "by"),
        ] {
            let error = error_in(line);
            assert!(
                matches!(&error, ExclusionsError::Cell { line: 2, column: named, .. } if *named == column),
                "{line:?}: {error}"
            );
        }
        let error = error_in("sub-07\tall\t3");
        assert!(matches!(
            error,
            ExclusionsError::Table {
                fault: TableFault::Cells {
                    line: 2,
                    cells: 3,
                    columns: 6,
                    ..
                },
                ..
            }
        ));
        let error = parse_text("participant_id\ttrial\treson\tby\n").unwrap_err();
        assert!(
            matches!(&error, ExclusionsError::UnknownColumn { nearest: Some(name), .. } if name == "reason"),
            "{error}"
        );
        let error = parse_text("participant_id\ttrial\ttrial\tby\n").unwrap_err();
        assert!(
            matches!(error, ExclusionsError::UnknownColumn { .. }),
            "{error}"
        );
        let error = parse_text("participant_id\ttrial\tby\n").unwrap_err();
        assert!(matches!(
            error,
            ExclusionsError::Table { fault: TableFault::MissingColumn { column, .. }, .. } if column == "reason"
        ));
        for separator in [',', ';'] {
            let text = format!("{header}sub-07\tall\tall\tx\ty\tn/a\n")
                .replace('\t', &separator.to_string());
            let error = parse_text(&text).unwrap_err();
            assert!(
                matches!(
                    error,
                    ExclusionsError::Table {
                        fault: TableFault::NotTabs { line: 1, .. },
                        ..
                    }
                ),
                "{error}"
            );
        }
        assert!(matches!(
            parse(b"\xff", Path::new("study")),
            Err(ExclusionsError::NoText { .. })
        ));
    }

    #[test]
    fn an_exclusion_exists_in_the_study_and_is_added_once() {
        let study = tempfile::tempdir().unwrap();
        let session = study.path().join("sub-07/ses-01");
        std::fs::create_dir_all(session.join("trial-003_attempt-2")).unwrap();
        let add = |exclusion: &Exclusion| add(&FileSystem, study.path(), exclusion);
        let missing_part = |exclusion: &Exclusion| match add(exclusion).unwrap_err() {
            ExclusionsError::Unknown {
                part, line: None, ..
            } => part,
            other => panic!("{other}"),
        };
        assert!(matches!(
            missing_part(&exclusion_of("sub-70", AllOrOne::All)),
            Unknown::Participant { nearest: Some(name), .. } if name == "sub-07"
        ));
        let mut second_session = exclusion_of("sub-07", AllOrOne::All);
        second_session.session = AllOrOne::One(2);
        assert!(
            matches!(missing_part(&second_session), Unknown::Session { existing, .. } if existing == [1])
        );
        assert!(
            matches!(missing_part(&exclusion_of("sub-07", main(4))), Unknown::Trial { existing, .. } if existing == ["3"])
        );
        assert!(!study.path().join(EXCLUSIONS_FILE).exists());

        add(&exclusion_of("sub-07", main(3))).unwrap();
        let error = add(&exclusion_of("sub-07", main(3))).unwrap_err();
        assert!(matches!(error, ExclusionsError::Already { .. }), "{error}");
        let mut whole_participant = exclusion_of("sub-07", AllOrOne::All);
        whole_participant.reason = "a tab\tand\nlines, C:\\temp".to_owned();
        add(&whole_participant).unwrap();
        let exclusions = read(study.path()).unwrap();
        assert_eq!(
            exclusions.list,
            [exclusion_of("sub-07", main(3)), whole_participant]
        );
        exclusions.require_known().unwrap();
        std::fs::remove_dir_all(session.join("trial-003_attempt-2")).unwrap();
        assert!(matches!(
            exclusions.require_known(),
            Err(ExclusionsError::Unknown { line: Some(2), .. })
        ));
    }

    #[test]
    fn an_added_exclusion_keeps_the_rest_of_the_table() {
        let mut added = exclusion_of("sub-08", AllOrOne::All);
        added.session = AllOrOne::One(2);
        added.reason = "\"hot\" plate".to_owned();
        let text =
            "\u{feff}by\ttrial\treason\tparticipant_id\r\nN. H.\t1\t\"a \"\"b\"\"\"\tsub-07\r\n";
        let text = with_exclusion(text, &added);
        assert_eq!(
            text,
            "\u{feff}by\ttrial\treason\tparticipant_id\tsession\tdate\r\n\
             N. H.\t1\t\"a \"\"b\"\"\"\tsub-07\tn/a\tn/a\r\n\
             N. H.\tall\t\"\"\"hot\"\" plate\"\tsub-08\t2\tn/a\r\n"
        );
        let list = parse_text(&text).unwrap().list;
        assert_eq!(list[0].reason, "a \"b\"");
        assert_eq!(list[1], added);
        assert_eq!(with_exclusion("", &added), to_tsv([&added]));
    }

    /// A reason that begins with `=` must not become a formula in a spreadsheet.
    #[test]
    fn no_cell_is_a_formula_and_each_reads_back() {
        for text in [
            "=HYPERLINK(\"http://x\")",
            "@SUM(1+1)",
            "+cmd",
            "- he coughed",
            "'=1",
        ] {
            let mut exclusion = exclusion_of("sub-07", AllOrOne::All);
            (exclusion.reason, exclusion.by) = (text.to_owned(), text.to_owned());
            let table = to_tsv([&exclusion]);
            let line = table.lines().nth(1).unwrap();
            let is_formula = |cell: &str| cell.starts_with(['=', '+', '-', '@']);
            assert!(!line.split('\t').any(is_formula), "{line}");
            assert_eq!(parse_text(&table).unwrap().list, [exclusion]);
        }
        // Edited by hand.
        let manual = parse_text("participant_id\ttrial\treason\tby\nsub-07\tall\t=1+1\t'N. H.'\n");
        let exclusion = manual.unwrap().list.remove(0);
        assert_eq!(
            (exclusion.reason.as_str(), exclusion.by.as_str()),
            ("=1+1", "'N. H.'")
        );
    }

    proptest! {
        #[test]
        fn every_reason_reads_back(reason in "[^\\p{Cc}\\u{2028}\\u{2029}\\s][\\PC\\t\\n\\r\\\\]*") {
            prop_assume!(reason.trim() != NOT_STATED);
            let mut exclusion = exclusion_of("sub-07", AllOrOne::All);
            exclusion.reason = reason.trim().replace(['\u{2028}', '\u{2029}'], " ");
            let exclusions = parse_text(&to_tsv([&exclusion])).unwrap();
            prop_assert_eq!(exclusions.list, [exclusion]);
        }

        #[test]
        fn no_text_panics(text in "\\PC*") {
            let _ = parse_text(&text);
            let _ = parse_text(&format!("participant_id\ttrial\treason\tby\n{text}"));
        }
    }
}
