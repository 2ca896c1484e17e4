//! `participants.tsv`: a line for each participant, with the day of the first session and the personal data stated.
//!
//! Columns are found by name: a table of an earlier version lacks some, and a laboratory may have added others.

use std::path::Path;

use protocols::{NOT_STATED, ParticipantId, Person, PersonDetail};

use super::study_error::{PARTICIPANTS_FILE, StudyError};
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
        let bytes = disk::read_on(storage, path, files::TEXT_LIMIT_BYTES)?;
        let broken = |reason: &str| StudyError::Table {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        let text = String::from_utf8(bytes).map_err(|_| broken("it is not UTF-8 text"))?;
        // Spreadsheets begin UTF-8 files with this mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let cells = |line: &str| line.split('\t').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines().map(|line| line.trim_end_matches('\r'));
        let columns = cells(lines.next().unwrap_or_default());
        if columns[0] != ID {
            return Err(broken("its first column is not participant_id"));
        }
        let rows = lines.filter(|line| !line.is_empty()).map(cells).collect();
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
    pub(super) fn in_other_case(&self, participant: &ParticipantId) -> Option<&str> {
        let wanted = participant.as_str();
        let mut known = self.rows.iter().map(|row| row[0].as_str());
        known.find(|known| *known != wanted && known.eq_ignore_ascii_case(wanted))
    }

    fn row(&self, participant: &ParticipantId) -> Option<usize> {
        let is = |row: &Vec<String>| row[0] == participant.as_str();
        self.rows.iter().position(is)
    }

    /// Returns the index of a column, which is added to every row if it is missing.
    fn column(&mut self, name: &str) -> usize {
        let at = self.columns.iter().position(|column| column == name);
        at.unwrap_or_else(|| {
            self.columns.push(name.to_owned());
            self.columns.len() - 1
        })
    }

    /// Makes every row as long as the header.
    fn square(&mut self) {
        for row in &mut self.rows {
            row.resize(self.columns.len().max(row.len()), NOT_STATED.to_owned());
        }
    }

    /// Returns the data of a participant; a cell with an unknown value counts as not stated.
    pub(super) fn person(&self, participant: &ParticipantId) -> Person {
        let mut person = Person::default();
        if let Some(row) = self.row(participant) {
            for detail in PersonDetail::ALL {
                let at = self.columns.iter().position(|c| c == detail.column());
                let cell = at.and_then(|at| self.rows[row].get(at));
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
    let (date_at, protocol_at) = (table.column(DATE), table.column(PROTOCOL));
    for detail in PersonDetail::ALL {
        table.column(detail.column());
    }
    let mut row = vec![NOT_STATED.to_owned(); table.columns.len()];
    row[0] = participant.as_str().to_owned();
    (row[date_at], row[protocol_at]) = (date.to_owned(), files::to_cell(protocol));
    table.rows.push(row);
    table.square();
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
    let (Some(row), known) = (table.row(participant), table.person(participant)) else {
        return Ok(());
    };
    let new = |detail: &PersonDetail| {
        known.text(*detail) == NOT_STATED && person.text(*detail) != NOT_STATED
    };
    let details: Vec<_> = PersonDetail::ALL.into_iter().filter(new).collect();
    if details.is_empty() {
        return Ok(());
    }
    for detail in details {
        let at = table.column(detail.column());
        table.square();
        table.rows[row][at] = person.text(detail);
    }
    Ok(table.write(storage, path)?)
}
