//! Participant identifiers, which become folder names.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A participant's identifier in the BIDS form `sub-<label>`, the label 1 to 32 ASCII letters or digits.
///
/// It is safe as a folder name: separators, dots and spaces are rejected.
///
/// ```
/// use participants::ParticipantId;
///
/// let participant: ParticipantId = "sub-07".parse()?;
/// assert_eq!(participant.number(), Some(7));
/// assert!("../sub-07".parse::<ParticipantId>().is_err());
/// # Ok::<(), participants::ParticipantIdError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ParticipantId(String);

/// Maximum length of a label, after `sub-`.
const MAX_LABEL: usize = 32;
const PREFIX: &str = "sub-";

/// Why a text is not a participant's identifier.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "participant `{}` is not allowed: {fault}; the form is `sub-` and 1 to {MAX_LABEL} of A-Z, a-z, 0-9{}",
    .text.chars().take(40).collect::<String>().escape_debug(),
    suggestion(.text)
)]
pub struct ParticipantIdError {
    /// The text as given.
    pub text: String,
    /// The fault.
    pub fault: &'static str,
}

/// Returns the end of the message: the identifier that was probably meant, or an example.
fn suggestion(text: &str) -> String {
    match intended_id(text) {
        Some(id) => format!("; did you mean `{id}`?"),
        None => ", for example `sub-01`".to_owned(),
    }
}

/// Returns the identifier with the letters and digits of `text`; `None` if it has other characters than these and separators, or no
/// digit: it may be a name.
fn intended_id(text: &str) -> Option<String> {
    let is_separator = |c: char| matches!(c, '-' | '_' | '.' | ' ');
    let text = text.trim();
    let label = match text.get(..3) {
        Some(start) if start.eq_ignore_ascii_case("sub") => &text[3..],
        _ => text,
    };
    let label: String = label.chars().filter(|c| !is_separator(*c)).collect();
    let is_label = label.bytes().all(|b| b.is_ascii_alphanumeric());
    let is_code = is_label && label.bytes().any(|b| b.is_ascii_digit());
    (is_code && (1..=MAX_LABEL).contains(&label.len())).then(|| format!("{PREFIX}{label}"))
}

impl ParticipantId {
    /// Returns the identifier with its prefix, `sub-01`.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Returns the number that ends the label (`sub-01` and `sub-P01` give 1), which places the participant in a
    /// counterbalanced design. `None` if the label does not end in a digit or the number exceeds `u32`.
    pub fn number(&self) -> Option<u32> {
        let digits_from = self
            .0
            .rfind(|c: char| !c.is_ascii_digit())
            .map_or(0, |i| i + 1);
        self.0[digits_from..].parse().ok()
    }
}

impl FromStr for ParticipantId {
    type Err = ParticipantIdError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let fault = match text.strip_prefix(PREFIX) {
            None => "it does not begin with `sub-`",
            Some("") => "nothing follows `sub-`",
            Some(label) if !label.bytes().all(|b| b.is_ascii_alphanumeric()) => {
                "the label has other characters than letters and digits"
            }
            Some(label) if label.len() > MAX_LABEL => "the label is too long",
            Some(_) => return Ok(Self(text.to_owned())),
        };
        Err(ParticipantIdError {
            text: text.to_owned(),
            fault,
        })
    }
}

impl TryFrom<String> for ParticipantId {
    type Error = ParticipantIdError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.parse()
    }
}

impl From<ParticipantId> for String {
    fn from(id: ParticipantId) -> Self {
        id.0
    }
}

impl fmt::Display for ParticipantId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accepts_the_allowed_form() {
        for ok in [
            "sub-01",
            "sub-A",
            "sub-P07b",
            &format!("sub-{}", "x".repeat(32)),
        ] {
            assert_eq!(ok.parse::<ParticipantId>().unwrap().as_str(), ok);
        }
    }

    /// Fault 32.
    #[test]
    fn rejects_everything_else_and_names_the_form() {
        let long = format!("sub-{}", "x".repeat(300));
        for bad in [
            "", "../x", "sub-", "sub-../x", "sub-é1", "sub-01/", "sub-0 1", "sub-01\n", "SUB-01",
            "01", "sub-01.", "sub-\0", &long,
        ] {
            let message = bad.parse::<ParticipantId>().unwrap_err().to_string();
            assert!(message.contains("`sub-` and 1 to 32"), "{message}");
            assert!(message.len() < 250, "{message}");
        }
    }

    #[test]
    fn the_identifier_that_was_meant_is_suggested() {
        for (text, meant) in [
            ("P07", "sub-P07"),
            ("07", "sub-07"),
            ("SUB-01", "sub-01"),
            ("sub_VP_3", "sub-VP3"),
            ("sub-VP-03", "sub-VP03"),
            ("sub01", "sub-01"),
        ] {
            let message = text.parse::<ParticipantId>().unwrap_err().to_string();
            let end = format!("did you mean `{meant}`?");
            assert!(message.ends_with(&end), "{message}");
            assert_eq!(meant.parse::<ParticipantId>().unwrap().as_str(), meant);
        }
        for text in ["../x", "sub-", "sub-é1", "", "Anna Smith", "anna"] {
            let message = text.parse::<ParticipantId>().unwrap_err().to_string();
            assert!(message.ends_with("for example `sub-01`"), "{message}");
        }
    }

    #[test]
    fn the_number_is_the_trailing_digits() {
        let number = |s: &str| s.parse::<ParticipantId>().unwrap().number();
        assert_eq!(number("sub-01"), Some(1));
        assert_eq!(number("sub-2P014"), Some(14));
        assert_eq!(number("sub-anna"), None);
        assert_eq!(number("sub-99999999999"), None);
    }
}
