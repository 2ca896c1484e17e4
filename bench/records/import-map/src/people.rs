//! Table of participants.

use std::collections::BTreeSet;

use protocols::ParticipantId;
use text_tables::{Separator, cells, stated_separator};

/// Names of the column of participants.
const ID_COLUMNS: [&str; 2] = ["participant_id", "participant"];

/// Table of participants, with any further columns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct People {
    columns: Vec<String>,
    rows: Vec<(String, Vec<String>)>,
}

impl People {
    /// Reads a table with commas, semicolons or tabs between its cells and the column `participant` or `participant_id`.
    ///
    /// # Errors
    /// The reason in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = (1..)
            .zip(text.split(['\n', '\r']))
            .filter(|(_, line)| !line.trim().is_empty());
        let mut header = lines.next().map(|(_, line)| line);
        let stated = header.and_then(stated_separator);
        if stated.is_some() {
            header = lines.next().map(|(_, line)| line);
        }
        let header = header.ok_or_else(|| "the table is empty".to_owned())?;
        let place = |separator: Separator| {
            let names = cells(header, separator);
            ID_COLUMNS
                .into_iter()
                .find_map(|id| names.iter().position(|name| name.eq_ignore_ascii_case(id)))
        };
        let candidates = stated.map_or(Separator::ALL.to_vec(), |separator| vec![separator]);
        let found = candidates
            .into_iter()
            .find_map(|separator| Some((separator, place(separator)?)));
        let (separator, id) = found.ok_or_else(|| {
            let shown: String = header.chars().take(80).collect();
            format!("no column is named participant or participant_id in `{shown}`: name the column with the participants so")
        })?;
        let names: Vec<String> = cells(header, separator)
            .into_iter()
            .map(String::from)
            .collect();
        let kept: Vec<usize> = (0..names.len())
            .filter(|column| *column != id && !names[*column].is_empty())
            .collect();
        let mut rows: Vec<(String, Vec<String>)> = Vec::new();
        for (_, line) in lines {
            let cells = cells(line, separator);
            let cell = |column: usize| {
                cells
                    .get(column)
                    .map_or(String::new(), |cell| cell.to_string())
            };
            let name = cell(id);
            if name.is_empty() {
                continue;
            }
            let Some(label) = label(&name) else {
                return Err(format!("participant `{name}` has no letter and no digit"));
            };
            if rows.iter().any(|(other, _)| *other == label) {
                return Err(format!("participant `{name}` is there twice: delete a row"));
            }
            rows.push((label, kept.iter().map(|column| cell(*column)).collect()));
        }
        Ok(Self {
            columns: kept.iter().map(|column| names[*column].clone()).collect(),
            rows,
        })
    }

    /// Returns the index of a participant's row. Numbers match with and without zeros before them.
    fn place(&self, participant: &ParticipantId) -> Option<usize> {
        let wanted = label(participant.as_str())?;
        let place = |exact: bool| {
            self.rows.iter().position(|(name, _)| match exact {
                true => *name == wanted,
                false => name.trim_start_matches('0') == wanted.trim_start_matches('0'),
            })
        };
        place(true).or_else(|| place(false))
    }

    /// Returns the rows that are of none of the participants, by their names, and the participants without a row.
    #[must_use]
    pub fn unmatched<'a>(
        &self,
        participants: &BTreeSet<&'a ParticipantId>,
    ) -> (Vec<&str>, Vec<&'a ParticipantId>) {
        let places = participants
            .iter()
            .filter_map(|participant| self.place(participant));
        let places: BTreeSet<usize> = places.collect();
        let rows = self.rows.iter().enumerate();
        let rows = rows.filter(|(index, _)| !places.contains(index));
        let absentees = participants.iter().copied();
        let absentees = absentees.filter(|participant| self.place(participant).is_none());
        (
            rows.map(|(_, (name, _))| name.as_str()).collect(),
            absentees.collect(),
        )
    }

    /// Returns the cells of a participant by the names of their columns; `None` if the table lacks the participant.
    #[must_use]
    pub fn row(&self, participant: &ParticipantId) -> Option<Vec<(&str, &str)>> {
        let (_, cells) = &self.rows[self.place(participant)?];
        let names = self.columns.iter().map(String::as_str);
        Some(names.zip(cells.iter().map(String::as_str)).collect())
    }
}

/// Returns the label of a participant's name: its letters and digits without `sub-`.
fn label(name: &str) -> Option<String> {
    let name = name.trim();
    let name = name.strip_prefix("sub-").unwrap_or(name);
    let label: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
    (!label.is_empty()).then_some(label)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_found_by_the_participants_name() {
        let id = |text: &str| text.parse::<ParticipantId>().unwrap();
        for text in [
            "participant,age,note\n01,30,\"a, b\"\nP-2,41,\n",
            "\u{feff}age;participant_id;note\r\n30;sub-01;a, b\r\n41;P2;\r\n",
            "sep=;\nparticipant;age;note\n1;30;a, b\nP2;41\n",
        ] {
            let people = People::parse(text).unwrap();
            assert_eq!(
                people.row(&id("sub-01")),
                Some(vec![("age", "30"), ("note", "a, b")]),
                "{text:?}"
            );
            assert_eq!(people.row(&id("sub-P2")).unwrap()[0], ("age", "41"));
            assert_eq!(people.row(&id("sub-03")), None);
            let (one, three) = (id("sub-001"), id("sub-03"));
            let (rows, participants) = people.unmatched(&BTreeSet::from([&one, &three]));
            assert_eq!((rows, participants), (vec!["P2"], vec![&three]));
        }
        for wrong in ["", "name,age\n1,2\n", "participant\n1\n1\n"] {
            assert!(People::parse(wrong).is_err(), "{wrong:?}");
        }
    }
}
