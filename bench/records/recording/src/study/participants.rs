//! `participants.tsv`: a line for each participant, with the day of the first session and the personal data stated.
//!
//! Columns are found by name: a table of an earlier version lacks some, and a laboratory may have added others.

use std::path::Path;

use protocols::{NOT_STATED, ParticipantId, Person, PersonDetail};

use super::study_error::{PARTICIPANTS_FILE, StudyError};
use super::table_lines::table_lines;
use crate::disk::{self, DiskError};
use crate::storage::Storage;

const ID: &str = "participant_id";
const DATE: &str = "first_session_date";
const PROTOCOL: &str = "protocol";
const HEADER: &str = "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness\n";

/// Table in memory.
pub(super) struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(super) fn read(storage: &dyn Storage, path: &Path) -> Result<Self, StudyError> {
        let bytes = disk::read_on(storage, path, bounded_files::TEXT_LIMIT_BYTES)?;
        let table_error = |reason: &str| StudyError::Table {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        let text = String::from_utf8(bytes).map_err(|_| table_error("it is not UTF-8 text"))?;
        let mut lines = table_lines(&text).into_iter().map(|line| line.cells);
        let columns = lines.next().unwrap_or_default();
        if columns.first().is_none_or(|column| column != ID) {
            return Err(table_error("its first column is not participant_id"));
        }
        let rows = lines.collect();
        Ok(Self { columns, rows })
    }

    /// Replaces the file as a whole, so that lines are never torn.
    fn write(&self, storage: &dyn Storage, path: &Path) -> Result<(), DiskError> {
        let mut text = self.columns.join("\t") + "\n";
        for row in &self.rows {
            text += &(row.join("\t") + "\n");
        }
        disk::replace_file_on(storage, path, text.as_bytes())
    }

    /// Returns the participant with an identifier that differs from this one only in case.
    pub(super) fn case_variant(&self, participant: &ParticipantId) -> Option<&str> {
        let name = participant.as_str();
        let mut ids = self.rows.iter().map(|row| row[0].as_str());
        ids.find(|id| *id != name && id.eq_ignore_ascii_case(name))
    }

    fn row(&self, participant: &ParticipantId) -> Option<usize> {
        let is_participant = |row: &Vec<String>| row[0] == participant.as_str();
        self.rows.iter().position(is_participant)
    }

    /// Returns the index of a column, which is added to every row if it is missing.
    fn column(&mut self, name: &str) -> usize {
        let index = self.columns.iter().position(|column| column == name);
        index.unwrap_or_else(|| {
            self.columns.push(name.to_owned());
            self.columns.len() - 1
        })
    }

    /// Makes every row as long as the header.
    fn pad(&mut self) {
        for row in &mut self.rows {
            row.resize(self.columns.len().max(row.len()), NOT_STATED.to_owned());
        }
    }

    /// Returns the data of a participant; a cell with an unknown value counts as not stated.
    pub(super) fn person(&self, participant: &ParticipantId) -> Person {
        let mut person = Person::default();
        if let Some(row) = self.row(participant) {
            for detail in PersonDetail::ALL {
                let index = self.columns.iter().position(|c| c == detail.column());
                let cell = index.and_then(|index| self.rows[row].get(index));
                let _ = cell.map(|cell| person.set(detail, cell));
            }
        }
        person
    }
}

/// Creates an empty table if it is missing.
pub(super) fn require_table(storage: &dyn Storage, path: &Path) -> Result<(), DiskError> {
    if disk::exists(storage, path)? {
        return Ok(());
    }
    disk::replace_file_on(storage, path, HEADER.as_bytes())
}

/// Requires texts that fit into cells.
pub(super) fn require_cells(date: &str, protocol: &str) -> Result<(), StudyError> {
    for (field, value) in [(DATE, date), (PROTOCOL, protocol)] {
        if value.contains(['\t', '\n', '\r']) {
            return Err(StudyError::Tsv {
                field,
                value: value.to_owned(),
            });
        }
    }
    Ok(())
}

/// Adds the participant's line if it is missing.
pub(super) fn register(
    storage: &dyn Storage,
    folder: &Path,
    participant: &ParticipantId,
    date: &str,
    protocol: &str,
) -> Result<(), StudyError> {
    let path = &folder.join(PARTICIPANTS_FILE);
    let mut table = Table::read(storage, path)?;
    if table.row(participant).is_some() {
        // This also syncs a file that an earlier attempt left unsynced.
        return Ok(disk::sync_parent(storage, path)?);
    }
    let (date_column, protocol_column) = (table.column(DATE), table.column(PROTOCOL));
    for detail in PersonDetail::ALL {
        table.column(detail.column());
    }
    let mut row = vec![NOT_STATED.to_owned(); table.columns.len()];
    row[0] = participant.as_str().to_owned();
    (row[date_column], row[protocol_column]) = (date.to_owned(), escaping::to_cell(protocol));
    table.rows.push(row);
    table.pad();
    Ok(table.write(storage, path)?)
}

/// Fills in missing data of a participant. Existing data are kept: an age is the one at the first session.
pub(super) fn describe(
    storage: &dyn Storage,
    folder: &Path,
    participant: &ParticipantId,
    person: &Person,
) -> Result<(), StudyError> {
    let path = &folder.join(PARTICIPANTS_FILE);
    let mut table = Table::read(storage, path)?;
    let (Some(row), existing) = (table.row(participant), table.person(participant)) else {
        return Ok(());
    };
    let is_new = |detail: &PersonDetail| {
        existing.text(*detail) == NOT_STATED && person.text(*detail) != NOT_STATED
    };
    let details: Vec<_> = PersonDetail::ALL.into_iter().filter(is_new).collect();
    if details.is_empty() {
        return Ok(());
    }
    for detail in details {
        let index = table.column(detail.column());
        table.pad();
        table.rows[row][index] = person.text(detail);
    }
    Ok(table.write(storage, path)?)
}
