//! Labels of attempts at trials, which name the recording folders within a session.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

use crate::trial::TrialKey;

/// Part of a session: practice or experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum TrialBlock {
    /// Trials to practise the task, which are not analysed.
    Practice,
    /// Trials of the experiment.
    Main,
}

/// Identity of an attempt at a trial; ordered as recorded: practice first, then by number and attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TrialLabel {
    /// Part of the session.
    pub block: TrialBlock,
    /// Number within its part of the session, from 1.
    pub number: u32,
    /// Attempt, from 1.
    pub attempt: u32,
}

impl TrialLabel {
    /// Creates the label of an attempt in a session that begins with `practice_trials` practice trials; each part of the
    /// session is counted from 1.
    #[must_use]
    pub fn new(key: &TrialKey, practice_trials: u32) -> Self {
        let earlier_trials = if key.practice { 0 } else { practice_trials };
        let number = key.number.saturating_sub(earlier_trials);
        Self::of_block(key.practice, number, key.attempt)
    }

    /// Creates the label of the trial with this number within its part of the session.
    #[must_use]
    pub fn of_block(is_practice: bool, number: u32, attempt: u32) -> Self {
        let block = if is_practice {
            TrialBlock::Practice
        } else {
            TrialBlock::Main
        };
        Self {
            block,
            number,
            attempt,
        }
    }

    /// Returns whether the trial is a practice trial.
    #[must_use]
    pub fn is_practice(&self) -> bool {
        self.block == TrialBlock::Practice
    }

    /// Returns the name of the trial for people, without the attempt: `practice 1` or `trial 3`.
    #[must_use]
    pub fn trial_name(&self) -> String {
        let block = match self.block {
            TrialBlock::Practice => "practice",
            TrialBlock::Main => "trial",
        };
        format!("{block} {}", self.number)
    }

    /// Returns the number among all trials of the session, practice first: [`TrialKey::number`].
    #[must_use]
    pub fn number_in_session(&self, practice_trials: u32) -> u32 {
        match self.block {
            TrialBlock::Practice => self.number,
            TrialBlock::Main => self.number.saturating_add(practice_trials),
        }
    }
}

impl fmt::Display for TrialLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            block,
            number,
            attempt,
        } = self;
        match block {
            TrialBlock::Practice => write!(f, "practice-{number:02}_attempt-{attempt}"),
            TrialBlock::Main => write!(f, "trial-{number:03}_attempt-{attempt}"),
        }
    }
}

/// Name that is not a trial's.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{name:?} names no trial; such names are `trial-003_attempt-1` and `practice-01_attempt-1`"
)]
pub struct NoTrialLabel {
    /// The name.
    pub name: String,
}

impl FromStr for TrialLabel {
    type Err = NoTrialLabel;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let parse = || {
            let (block, rest) = if let Some(rest) = name.strip_prefix("practice-") {
                (TrialBlock::Practice, rest)
            } else {
                (TrialBlock::Main, name.strip_prefix("trial-")?)
            };
            let (number, attempt) = rest.split_once("_attempt-")?;
            let label = Self {
                block,
                number: number.parse().ok()?,
                attempt: attempt.parse().ok()?,
            };
            // Only the canonical spelling: no `+1`, no other padding.
            (label.number >= 1 && label.attempt >= 1 && label.to_string() == name).then_some(label)
        };
        parse().ok_or_else(|| NoTrialLabel {
            name: name.to_owned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn labels_match_the_names_of_folders() {
        let label = |block, number, attempt| TrialLabel {
            block,
            number,
            attempt,
        };
        assert_eq!(
            label(TrialBlock::Main, 3, 1).to_string(),
            "trial-003_attempt-1"
        );
        assert_eq!(
            label(TrialBlock::Practice, 1, 2).to_string(),
            "practice-01_attempt-2"
        );
    }

    #[test]
    fn other_names_are_refused() {
        for name in [
            "",
            "trial-003",
            "trial-3_attempt-1",
            "trial-003_attempt-01",
            "trial-000_attempt-1",
            "trial-003_attempt-+1",
            "trial-003_attempt-1 ",
            "practice-99999999999_attempt-1",
        ] {
            assert!(name.parse::<TrialLabel>().is_err(), "{name}");
        }
    }

    #[test]
    fn a_trial_has_a_name_and_a_number_in_the_session() {
        let (practice, main) = (
            TrialLabel::of_block(true, 2, 1),
            TrialLabel::of_block(false, 3, 2),
        );
        assert_eq!(
            (practice.trial_name(), practice.number_in_session(2)),
            ("practice 2".to_owned(), 2)
        );
        assert_eq!(
            (main.trial_name(), main.number_in_session(2)),
            ("trial 3".to_owned(), 5)
        );
        let key = TrialKey {
            number: 5,
            attempt: 2,
            practice: false,
            condition: "c".to_owned(),
        };
        assert_eq!(TrialLabel::new(&key, 2), main);
    }

    proptest! {
        #[test]
        fn a_label_reads_back(is_practice: bool, number in 1u32.., attempt in 1u32..) {
            let label = TrialLabel::of_block(is_practice, number, attempt);
            prop_assert_eq!(label.to_string().parse(), Ok(label));
        }

        #[test]
        fn no_text_panics(name in "\\PC*") {
            let _ = name.parse::<TrialLabel>();
        }
    }
}
