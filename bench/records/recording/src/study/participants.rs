//! `participants.tsv`: a line for each participant, with the day of the first session and the personal data stated.
//!
//! Columns are found by name: a table of an earlier version lacks some, and a laboratory may have added others.

use std::path::Path;

use protocols::{NOT_STATED, ParticipantId, Person, PersonDetail};
use text_tables::{TabTable, TableLine, without_lines};

use super::study_error::{PARTICIPANTS_FILE, StudyError};
use crate::disk::{self, DiskError};
use crate::storage::Storage;

const DATE: &str = "first_session_date";
const PROTOCOL: &str = "protocol";
const HEADER: &str = "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness\n";

/// Protocol of a participant who was imported.
const IMPORTED: &str = "imported";

/// Column with the participants' identifiers, as in BIDS.
pub const ID_COLUMN: &str = "participant_id";

/// Table in memory.
pub(super) struct Table {
    table: TabTable,
    id_column: usize,
}

impl Table {
    /// Reads the table, which can be continued without damage: each row has an identifier, and no more cells than the
    /// header.
    pub(super) fn read(storage: &dyn Storage, path: &Path) -> Result<Self, StudyError> {
        let bytes = disk::read_on(storage, path, bounded_files::TEXT_LIMIT_BYTES)?;
        let table_error = |reason: String| StudyError::Table {
            path: path.to_owned(),
            reason,
        };
        let text =
            bounded_files::as_text(&bytes).map_err(|error| table_error(error.to_string()))?;
        let table = TabTable::parse(text.to_owned(), ID_COLUMN)
            .map_err(|fault| table_error(fault.to_string()))?;
        let id_column = table.column(ID_COLUMN).unwrap_or_default();
        let table = Self { table, id_column };
        let is_row = |row: &TableLine| {
            let id = table.id(row);
            row.cells.len() <= table.table.columns().len() && id.parse::<ParticipantId>().is_ok()
        };
        if !table.table.rows().iter().all(is_row)
            && let Some(fault) = table.table.uneven_row()
        {
            return Err(table_error(fault.to_string()));
        }
        Ok(table)
    }

    fn id<'a>(&self, row: &'a TableLine) -> &'a str {
        row.cells.get(self.id_column).map_or("", String::as_str)
    }

    fn write(&self, storage: &dyn Storage, path: &Path) -> Result<(), DiskError> {
        disk::replace_file_on(storage, path, self.table.text().as_bytes())
    }

    /// Returns the participant with an identifier that differs from this one only in case.
    pub(super) fn case_variant(&self, participant: &ParticipantId) -> Option<&str> {
        let name = participant.as_str();
        let mut ids = self.table.rows().iter().map(|row| self.id(row));
        ids.find(|id| *id != name && id.eq_ignore_ascii_case(name))
    }

    /// Returns the participant with an identifier that differs from this one, which is not in the table, only in the zeros before its
    /// number.
    pub(super) fn other_zeros(&self, participant: &ParticipantId) -> Option<&str> {
        if self.row(participant).is_some() {
            return None;
        }
        let parts = number_parts(participant.as_str())?;
        let mut ids = self.table.rows().iter().map(|row| self.id(row));
        ids.find(|id| number_parts(id) == Some(parts))
    }

    fn row(&self, participant: &ParticipantId) -> Option<usize> {
        let is_participant = |row: &TableLine| self.id(row) == participant.as_str();
        self.table.rows().iter().position(is_participant)
    }

    /// Returns the cell of a row; an absent one has no value.
    fn cell(&self, row: usize, column: &str) -> &str {
        let index = self.table.column(column);
        let cell = index.and_then(|index| self.table.rows()[row].cells.get(index));
        cell.map_or(NOT_STATED, String::as_str)
    }

    /// Returns the data of a participant; a cell with an unknown value counts as not stated.
    pub(super) fn person(&self, participant: &ParticipantId) -> Person {
        let mut person = Person::default();
        if let Some(row) = self.row(participant) {
            for detail in PersonDetail::ALL {
                let _ = person.set(detail, self.cell(row, detail.column()));
            }
        }
        person
    }
}

/// Returns an identifier's letters and the digits of its number without zeros before them; `None` without a number.
fn number_parts(id: &str) -> Option<(&str, &str)> {
    let letters = id.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = id[letters.len()..].trim_start_matches('0');
    (letters.len() < id.len()).then_some((letters, number))
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

/// Adds the participant's line if it is missing, in the columns that the table has.
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
    let protocol = escaping::to_cell(protocol);
    table.table.add_row(&[
        (ID_COLUMN, participant.as_str()),
        (DATE, date),
        (PROTOCOL, &protocol),
    ]);
    Ok(table.write(storage, path)?)
}

/// Fills in missing data of a participant. Existing data are kept, also those of other programs that are not understood: an
/// age is the one at the first session. A column is added only for data that were stated.
pub(super) fn describe(
    storage: &dyn Storage,
    folder: &Path,
    participant: &ParticipantId,
    person: &Person,
) -> Result<(), StudyError> {
    let path = &folder.join(PARTICIPANTS_FILE);
    let mut table = Table::read(storage, path)?;
    let Some(row) = table.row(participant) else {
        return Ok(());
    };
    let is_new = |detail: &PersonDetail| {
        let cell = table.cell(row, detail.column());
        (cell.is_empty() || cell == NOT_STATED) && person.text(*detail) != NOT_STATED
    };
    let details: Vec<_> = PersonDetail::ALL.into_iter().filter(is_new).collect();
    if details.is_empty() {
        return Ok(());
    }
    for detail in details {
        let name = detail.column();
        let column = table.table.column(name);
        let column = column.unwrap_or_else(|| table.table.add_column(name));
        table.table.set(row, column, &person.text(detail));
    }
    Ok(table.write(storage, path)?)
}

/// Adds an imported participant's line if it is missing, and fills in cells without a value.
pub(super) fn list_imported(
    storage: &dyn Storage,
    folder: &Path,
    participant: &ParticipantId,
    cells: &[(&str, &str)],
) -> Result<(), StudyError> {
    let path = &folder.join(PARTICIPANTS_FILE);
    let mut table = Table::read(storage, path)?;
    let before = table.table.text().to_owned();
    if table.row(participant).is_none() {
        table
            .table
            .add_row(&[(ID_COLUMN, participant.as_str()), (PROTOCOL, IMPORTED)]);
    }
    let Some(row) = table.row(participant) else {
        return Ok(());
    };
    for (name, value) in cells {
        let value = value.trim();
        let is_free = |cell: &str| cell.is_empty() || cell == NOT_STATED;
        if is_free(value) || !is_free(table.cell(row, name)) {
            continue;
        }
        let column = table.table.column(name);
        let column = column.unwrap_or_else(|| table.table.add_column(&escaping::to_cell(name)));
        table.table.set(row, column, &escaping::to_cell(value));
    }
    if table.table.text() != before {
        table.write(storage, path)?;
    }
    Ok(())
}

/// Removes the line of a participant whom an import listed.
pub(super) fn unlist_imported(
    storage: &dyn Storage,
    folder: &Path,
    participant: &ParticipantId,
) -> Result<(), StudyError> {
    let path = &folder.join(PARTICIPANTS_FILE);
    let table = Table::read(storage, path)?;
    let is_imported = |row: usize| table.cell(row, PROTOCOL) == IMPORTED;
    if !table.row(participant).is_some_and(is_imported) {
        return Ok(());
    }
    let is_row = |line: &TableLine| table.id(line) == participant.as_str();
    let rest = without_lines(table.table.text(), is_row);
    Ok(disk::replace_file_on(storage, path, rest.as_bytes())?)
}
