//! Limits of a text, and the numbers inserted into it.

use crate::table::{OwnTexts, Texts};

/// Maximum number of characters in a text: a screen shows as many large enough to be read from a chair.
pub const LONGEST_TEXT: usize = 120;

/// A text that cannot be shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {text:?}: {fault}")]
pub struct RefusedText {
    /// Dotted path of the text in a protocol.
    pub key: String,
    /// The text.
    pub text: String,
    /// The fault, and the allowed form.
    pub fault: &'static str,
}

impl OwnTexts {
    /// Requires that a screen can show every text.
    ///
    /// # Errors
    /// [`RefusedText`] for the first text that cannot be shown.
    pub fn require_showable(&self) -> Result<(), RefusedText> {
        for (key, text) in self.replacements() {
            if let Some(fault) = fault(key, text) {
                return Err(RefusedText {
                    key: format!("texts.{key}"),
                    text: text.to_owned(),
                    fault,
                });
            }
        }
        Ok(())
    }
}

fn fault(key: &str, text: &str) -> Option<&'static str> {
    let counts = matches!(key, "trial" | "practice");
    let is_timed = key == "say_rest";
    let without_numbers = text.replacen("{number}", "", 1).replacen("{total}", "", 1);
    let without_time = text.replacen("{seconds}", "", 1);
    if text.trim().is_empty() {
        Some("a text has at least one character")
    } else if text.chars().count() > LONGEST_TEXT {
        Some("a text has at most 120 characters")
    } else if text.chars().any(char::is_control) {
        Some("a text is one line without control characters; long ones are wrapped")
    } else if key == "decimal_mark" && text.chars().count() != 1 {
        Some("a decimal mark is one character")
    } else if counts && !text.contains("{number}") {
        Some("this text needs {number}, and may have {total}")
    } else if counts && without_numbers.contains(['{', '}']) {
        Some("in braces there may be number and total, once each")
    } else if is_timed && without_time.contains(['{', '}']) {
        Some("in braces there may be seconds, once")
    } else if !counts && !is_timed && text.contains(['{', '}']) {
        Some("this text has no number to put into braces")
    } else {
        None
    }
}

impl Texts {
    /// Returns `value` with `decimals` decimals and this language's decimal mark.
    #[must_use]
    pub fn number(&self, value: f64, decimals: usize) -> String {
        format!("{value:.decimals$}").replace('.', &self.decimal_mark)
    }

    /// Returns the operator's words at the beginning of a break of `left_s`.
    #[must_use]
    pub fn say_rest_text(&self, left_s: f64) -> String {
        self.say_rest
            .replacen("{seconds}", &format!("{left_s:.0}"), 1)
    }

    /// Returns the number of this trial, or practice trial, and of all.
    #[must_use]
    pub fn trial_text(&self, practice: bool, number: u32, total: u32) -> String {
        let text = if practice {
            &self.practice
        } else {
            &self.trial
        };
        text.replacen("{number}", &number.to_string(), 1)
            .replacen("{total}", &total.to_string(), 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::language::Language;

    #[test]
    fn every_text_can_be_replaced() {
        for language in Language::ALL {
            for (key, text) in Texts::in_language(language).all() {
                assert_eq!(fault(key, text), None, "{language:?} {key} = {text:?}");
            }
        }
    }

    #[test]
    fn no_text_of_a_language_was_left_in_english() {
        let english = Texts::in_language(Language::En);
        for language in [Language::Fr, Language::De, Language::Nl] {
            for ((key, text), (_, same)) in Texts::in_language(language).all().zip(english.all()) {
                let may_agree = ["start", "decimal_mark"].contains(&key);
                assert!(may_agree || text != same, "{language:?} {key} = {text:?}");
            }
        }
    }

    #[test]
    fn a_text_that_no_screen_shows_is_refused_with_its_name() {
        let long = "x".repeat(LONGEST_TEXT + 1);
        for (key, text) in [
            ("wait", ""),
            ("wait", "  "),
            ("wait", "two\nlines"),
            ("wait", "\u{1b}[2J"),
            ("wait", long.as_str()),
            ("wait", "{number}"),
            ("trial", "trial"),
            ("trial", "{number} {number}"),
            ("trial", "{number} {of}"),
            ("decimal_mark", ".."),
            ("say_rest", "{seconds} {seconds}"),
            ("say_rest", "{minutes}"),
            ("say_wait", "{seconds}"),
        ] {
            let texts: OwnTexts =
                toml::from_str(&format!("{key} = {}", toml::Value::from(text))).unwrap();
            let error = texts.require_showable().unwrap_err();
            assert_eq!(error.key, format!("texts.{key}"), "{text:?}");
        }
        let replacements: OwnTexts = toml::from_str("trial = \"n° {number}\"").unwrap();
        assert_eq!(replacements.require_showable(), Ok(()));
        let texts = Texts::in_language(Language::Fr).replaced_by(&replacements);
        assert_eq!(texts.trial_text(false, 3, 10), "n° 3");
        assert_eq!(texts.trial_text(true, 1, 2), "entraînement 1 sur 2");
        let rest_text = texts.say_rest_text(59.6);
        assert_eq!(
            rest_text,
            "Reposez-vous. Nous pourrons continuer dans 60 s."
        );
    }

    #[test]
    fn an_unknown_text_is_refused() {
        assert!(toml::from_str::<OwnTexts>("wiat = \"…\"").is_err());
    }
}
