//! The dataset's table of participants: that of the study, in the words of BIDS.

use serde_json::{Map, Value, json};
use text_tables::{TabTable, TableFault};

use recording::study::ID_COLUMN;

use crate::bids::rows::{NO_VALUE, cell};
use crate::bids::sidecars::to_text;

/// Columns of which BIDS states the content: a number of years, or one of these words.
const AGE: &str = "age";
const SEX: (&str, [&str; 3]) = ("sex", ["female", "male", "other"]);
const HANDEDNESS: (&str, [&str; 3]) = ("handedness", ["left", "right", "ambidextrous"]);
/// End of the name of a column with the cells that BIDS does not allow.
const AS_STATED: &str = "_as_stated";

/// Table of the exported participants.
#[derive(Debug, PartialEq)]
pub(crate) struct ParticipantTable {
    columns: Vec<String>,
    /// Participants without a row in the study's table, if it has one.
    absentees: Vec<String>,
    /// Identifiers of its rows that are of none of these participants.
    others: Vec<String>,
    /// Participants with several rows.
    repeated: Vec<String>,
    /// Rows of cells, by the columns.
    rows: Vec<Vec<String>>,
}

impl ParticipantTable {
    /// Takes the rows of these participants from the study's table; one that is not in it has a row without values.
    ///
    /// # Errors
    /// The study's table has no column of participants, or other separators.
    pub(crate) fn new(
        study_table: Option<String>,
        participants: &[String],
    ) -> Result<Self, TableFault> {
        let has_table = study_table.is_some();
        let text = study_table.unwrap_or_else(|| format!("{ID_COLUMN}\n"));
        let table = TabTable::parse(text, ID_COLUMN)?;
        let id_column = table.column(ID_COLUMN).unwrap_or_default();
        let others = (0..table.columns().len()).filter(|column| *column != id_column);
        let order: Vec<usize> = others.collect();
        let names = order.iter().map(|column| table.columns()[*column].clone());
        let row = |participant: &String| {
            let mut rows = table.rows().iter();
            rows.find(|row| row.cells.get(id_column) == Some(participant))
        };
        let absentees = participants
            .iter()
            .filter(|participant| has_table && row(participant).is_none());
        let absentees = absentees.cloned().collect();
        let ids = table
            .rows()
            .iter()
            .filter_map(|row| row.cells.get(id_column));
        let others = ids.clone().filter(|id| !participants.contains(id));
        let others = others.cloned().collect();
        let is_repeated =
            |participant: &&String| ids.clone().filter(|id| id == participant).count() > 1;
        let repeated = participants.iter().filter(is_repeated).cloned().collect();
        let rows = participants.iter().map(|participant| {
            let row = row(participant);
            let value = |column: &usize| {
                let text = row.and_then(|row| row.cells.get(*column));
                cell(text.map_or("", String::as_str))
            };
            let cells = order.iter().map(value);
            std::iter::once(participant.clone()).chain(cells).collect()
        });
        let mut table = Self {
            columns: std::iter::once(ID_COLUMN.to_owned()).chain(names).collect(),
            rows: rows.collect(),
            absentees,
            others,
            repeated,
        };
        table.translate(AGE, &age);
        for (column, words) in [SEX, HANDEDNESS] {
            table.translate(column, &|text| word(text, &words));
        }
        Ok(table)
    }

    /// Returns the sentences about participants whose particulars are not in the study's table, or there more than once.
    pub(crate) fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if !self.absentees.is_empty() {
            let others = match self.others.as_slice() {
                [] => String::new(),
                others => format!(
                    "; it has rows of {}, which are not in the export",
                    others.join(", ")
                ),
            };
            remarks.push(format!(
                "particulars of {}: participants.tsv has no row with this {ID_COLUMN}, and the export says n/a{others}",
                self.absentees.join(", ")
            ));
        }
        if !self.repeated.is_empty() {
            remarks.push(format!(
                "particulars of {}: participants.tsv has several rows with this {ID_COLUMN}, and the export takes the first; delete the others",
                self.repeated.join(", ")
            ));
        }
        remarks
    }

    /// Translates the cells of a column into words that BIDS allows, or `n/a`; if any changes, another column has them as stated.
    fn translate(&mut self, column: &str, translation: &dyn Fn(&str) -> Option<String>) {
        let Some(index) = self.columns.iter().position(|name| name == column) else {
            return;
        };
        let translated = self.rows.iter().map(|row| match row[index].as_str() {
            NO_VALUE => NO_VALUE.to_owned(),
            stated => translation(stated).unwrap_or_else(|| NO_VALUE.to_owned()),
        });
        let translated: Vec<String> = translated.collect();
        if self
            .rows
            .iter()
            .zip(&translated)
            .all(|(row, cell)| row[index] == *cell)
        {
            return;
        }
        self.columns.push(format!("{column}{AS_STATED}"));
        for (row, cell) in self.rows.iter_mut().zip(translated) {
            let stated = std::mem::replace(&mut row[index], cell);
            row.push(stated);
        }
    }

    /// Returns the text of the table.
    pub(crate) fn to_text(&self) -> String {
        let rows = std::iter::once(&self.columns).chain(&self.rows);
        rows.map(|row| row.join("\t") + "\n").collect()
    }

    /// Returns the descriptions of its columns.
    pub(crate) fn sidecar(&self) -> String {
        let others = self.columns.iter().skip(1);
        let words: Map<String, Value> = others
            .map(|column| (column.clone(), description(column)))
            .collect();
        to_text(&words.into())
    }
}

/// Returns the description of a column.
fn description(column: &str) -> Value {
    if let Some(name) = column.strip_suffix(AS_STATED) {
        let text = format!("{name} as the study's table states it");
        return json!({ "Description": text });
    }
    match column {
        "first_session_date" => {
            json!({ "Description": "day of the first session, by the laboratory's calendar" })
        }
        "protocol" => json!({ "Description": "protocol of the first session" }),
        "age" => json!({ "Description": "age at the first session", "Units": "year" }),
        "sex" => json!({
            "Description": "sex as stated",
            "Levels": { "female": "female", "male": "male", "other": "other" }
        }),
        "handedness" => json!({
            "Description": "writing hand as stated",
            "Levels": { "left": "left", "right": "right", "ambidextrous": "both" }
        }),
        _ => json!({ "Description": "column of the study's table of participants" }),
    }
}

/// Returns an age that BIDS allows; `None` for other texts.
fn age(text: &str) -> Option<String> {
    let is_number = text.parse::<f64>().is_ok_and(f64::is_finite);
    (is_number || text == "89+").then(|| text.to_owned())
}

/// Returns the word that equals a text in any case, or begins with it if it is a letter.
fn word(text: &str, words: &[&str]) -> Option<String> {
    let is_form =
        |word: &&&str| text.eq_ignore_ascii_case(word) || text.eq_ignore_ascii_case(&word[..1]);
    words.iter().find(is_form).map(|word| (*word).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str, participants: &[&str]) -> ParticipantTable {
        let participants: Vec<String> = participants.iter().map(|id| (*id).to_owned()).collect();
        ParticipantTable::new(Some(text.to_owned()), &participants).unwrap()
    }

    #[test]
    fn the_identifier_comes_first_and_other_participants_are_left_out() {
        let text = "age\tparticipant_id\tgroup\n31\tsub-01\twet\n44\tsub-02\t\n";
        assert_eq!(
            table(text, &["sub-02", "sub-03"]).to_text(),
            "participant_id\tage\tgroup\nsub-02\t44\tn/a\nsub-03\tn/a\tn/a\n"
        );
    }

    #[test]
    fn words_that_bids_does_not_know_have_a_column_of_their_own() {
        let text = "participant_id\tage\tsex\nsub-01\t18-38\tF\nsub-02\t40\tx\n";
        let table = table(text, &["sub-01", "sub-02"]);
        assert_eq!(
            table.to_text(),
            "participant_id\tage\tsex\tage_as_stated\tsex_as_stated\n\
             sub-01\tn/a\tfemale\t18-38\tF\nsub-02\t40\tn/a\t40\tx\n"
        );
        let sidecar: Value = serde_json::from_str(&table.sidecar()).unwrap();
        assert_eq!(sidecar["age"]["Units"], "year");
        assert!(sidecar["age_as_stated"]["Description"].is_string());
    }

    #[test]
    fn participants_without_a_row_are_named() {
        let found = table("participant_id\tage\nsub–01\t25\n", &["sub-01", "sub-02"]);
        let [remark] = &found.remarks()[..] else {
            panic!("{found:?}");
        };
        assert!(
            remark.contains("sub-01, sub-02") && remark.contains("it has rows of sub–01"),
            "{remark}"
        );
        let whole = table("participant_id\tage\nsub-01\t25\n", &["sub-01"]);
        assert_eq!(whole.remarks(), [""; 0]);
        let tableless = ParticipantTable::new(None, &["sub-01".to_owned()]).unwrap();
        assert_eq!(tableless.remarks(), [""; 0]);
        let twice = table("participant_id\tage\nsub-01\t25\nsub-01\t52\n", &["sub-01"]);
        let remarks = twice.remarks();
        assert!(remarks[0].contains("several rows"), "{remarks:?}");
    }

    #[test]
    fn a_study_without_a_table_has_its_participants() {
        let table = ParticipantTable::new(None, &["sub-01".to_owned()]).unwrap();
        assert_eq!(table.to_text(), "participant_id\nsub-01\n");
    }
}
