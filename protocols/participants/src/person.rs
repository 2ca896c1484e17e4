//! Details that a protocol may ask of a participant: age, sex, handedness. Each may stay unstated.
//!
//! Columns and words are those of BIDS (`participants.tsv` of the Brain Imaging Data Structure).

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Text of an unstated detail in tables, as in BIDS.
pub const NOT_STATED: &str = "n/a";
/// Youngest participant, years: the bench is not for children (docs/HAZARDS.md).
pub const MIN_AGE_YEARS: u8 = 18;
/// Oldest participant, years; a higher number is more likely a typing error.
pub const MAX_AGE_YEARS: u8 = 120;

/// Detail that a protocol asks about a participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PersonDetail {
    /// Age in whole years.
    Age,
    /// Sex.
    Sex,
    /// Writing hand.
    Handedness,
}

/// Details that a protocol asks about each participant.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AskedOfParticipant {
    /// Details asked for; empty by default.
    pub ask: Vec<PersonDetail>,
}

/// A participant's sex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sex {
    /// Female.
    Female,
    /// Male.
    Male,
    /// Another.
    Other,
}

/// The hand that a participant writes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handedness {
    /// The right one.
    Right,
    /// The left one.
    Left,
    /// Either.
    Ambidextrous,
}

/// Details of a participant; `None` is not stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Person {
    /// Age, whole years.
    pub age_years: Option<u8>,
    /// Sex.
    pub sex: Option<Sex>,
    /// Handedness.
    pub handedness: Option<Handedness>,
}

/// Why a text is not a valid detail of a participant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PersonError {
    /// The text is not a whole number of years in the range.
    #[error(
        "{text:?} is not an age; give {MIN_AGE_YEARS} to {MAX_AGE_YEARS} whole years, or `{NOT_STATED}` for not \
         stated (the bench is not for children)"
    )]
    Age {
        /// The text as given, shortened.
        text: String,
    },
    /// The text is not one of the allowed words.
    #[error(
        "{text:?} is not a valid {}; give {}, or `{NOT_STATED}` for not stated",
        .detail.column(), .detail.words().join(", ")
    )]
    Word {
        /// Detail asked for.
        detail: PersonDetail,
        /// The text as given, shortened.
        text: String,
    },
}

impl PersonDetail {
    /// All details, in the order of the columns.
    pub const ALL: [Self; 3] = [Self::Age, Self::Sex, Self::Handedness];

    /// Returns the name of the column of `participants.tsv`.
    pub fn column(self) -> &'static str {
        match self {
            Self::Age => "age",
            Self::Sex => "sex",
            Self::Handedness => "handedness",
        }
    }

    /// Returns the allowed words; empty for a number.
    pub fn words(self) -> &'static [&'static str] {
        match self {
            Self::Age => &[],
            Self::Sex => &["female", "male", "other"],
            Self::Handedness => &["right", "left", "ambidextrous"],
        }
    }
}

impl fmt::Display for PersonDetail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.column())
    }
}

impl Person {
    /// Sets one detail from its text. [`NOT_STATED`], `not stated` and an empty text leave it unstated.
    ///
    /// # Errors
    /// [`PersonError`], which names the allowed values.
    ///
    /// ```
    /// use participants::{Person, PersonDetail};
    ///
    /// let mut person = Person::default();
    /// person.set(PersonDetail::Age, "31")?;
    /// person.set(PersonDetail::Sex, "n/a")?;
    /// assert_eq!((person.text(PersonDetail::Age), person.text(PersonDetail::Sex)), ("31".into(), "n/a".into()));
    /// assert!(person.set(PersonDetail::Age, "310").is_err());
    /// # Ok::<(), participants::PersonError>(())
    /// ```
    pub fn set(&mut self, detail: PersonDetail, text: &str) -> Result<(), PersonError> {
        let text = text.trim();
        let is_unstated = ["", NOT_STATED, "not stated", "not-stated"].contains(&text);
        let word = || {
            let index = detail
                .words()
                .iter()
                .position(|w| w.eq_ignore_ascii_case(text));
            index.ok_or_else(|| PersonError::Word {
                detail,
                text: short(text),
            })
        };
        match detail {
            PersonDetail::Age if is_unstated => self.age_years = None,
            PersonDetail::Sex if is_unstated => self.sex = None,
            PersonDetail::Handedness if is_unstated => self.handedness = None,
            PersonDetail::Age => self.age_years = Some(age(text)?),
            PersonDetail::Sex => {
                self.sex = Some([Sex::Female, Sex::Male, Sex::Other][word()?]);
            }
            PersonDetail::Handedness => {
                let hands = [
                    Handedness::Right,
                    Handedness::Left,
                    Handedness::Ambidextrous,
                ];
                self.handedness = Some(hands[word()?]);
            }
        }
        Ok(())
    }

    /// Returns one detail as written in tables; [`NOT_STATED`] if it is not stated.
    pub fn text(&self, detail: PersonDetail) -> String {
        let words = detail.words();
        let text = match detail {
            PersonDetail::Age => self.age_years.map(|years| years.to_string()),
            PersonDetail::Sex => self.sex.map(|sex| words[sex as usize].to_owned()),
            PersonDetail::Handedness => self.handedness.map(|hand| words[hand as usize].to_owned()),
        };
        text.unwrap_or_else(|| NOT_STATED.to_owned())
    }
}

fn age(text: &str) -> Result<u8, PersonError> {
    let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    text.parse()
        .ok()
        .filter(|years| digits && (MIN_AGE_YEARS..=MAX_AGE_YEARS).contains(years))
        .ok_or_else(|| PersonError::Age { text: short(text) })
}

fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

impl FromStr for PersonDetail {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let detail = Self::ALL.into_iter().find(|detail| detail.column() == name);
        detail.ok_or_else(|| format!("{name:?} is not age, sex or handedness"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_at_each_end_of_the_range_and_beyond_it() {
        let mut person = Person::default();
        for (text, years) in [("18", Some(18)), (" 120 ", Some(120)), ("n/a", None)] {
            person.set(PersonDetail::Age, text).unwrap();
            assert_eq!(person.age_years, years, "{text}");
        }
        for text in ["17", "121", "-3", "+20", "20.5", "1e2", "256", "twenty"] {
            let rejected_text = text.to_owned();
            assert_eq!(
                person.set(PersonDetail::Age, text),
                Err(PersonError::Age {
                    text: rejected_text
                })
            );
        }
        assert_eq!(person, Person::default());
    }

    #[test]
    fn every_word_is_written_as_it_is_read_and_any_other_is_refused() {
        for detail in [PersonDetail::Sex, PersonDetail::Handedness] {
            let mut person = Person::default();
            for word in detail.words() {
                person.set(detail, &word.to_uppercase()).unwrap();
                assert_eq!(person.text(detail), *word);
            }
            for text in ["", "n/a", "not stated", "not-stated"] {
                person.set(detail, text).unwrap();
                assert_eq!(person.text(detail), NOT_STATED);
            }
            let rejected_text = "x\ty".to_owned();
            assert_eq!(
                person.set(detail, "x\ty"),
                Err(PersonError::Word {
                    detail,
                    text: rejected_text
                })
            );
        }
    }
}
