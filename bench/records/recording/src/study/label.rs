//! Labels of trials, which name the recording folders within a session.

use std::fmt;
use std::str::FromStr;

/// Part of a session: practice or experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TrialBlock {
    /// Trials to practise the task, which are not analysed.
    Practice,
    /// Trials of the experiment.
    Main,
}

/// Attempt at a trial; ordered as recorded: practice first, then by number and attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
    pub fn new(key: &protocols::TrialKey, practice_trials: u32) -> Self {
        let (block, number) = if key.practice {
            (TrialBlock::Practice, key.number)
        } else {
            (TrialBlock::Main, key.number.saturating_sub(practice_trials))
        };
        Self {
            block,
            number,
            attempt: key.attempt,
        }
    }

    /// Returns the number among all trials of the session, practice first:
    /// [`TrialKey::number`](protocols::TrialKey::number).
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

    proptest! {
        #[test]
        fn a_label_reads_back(practice: bool, number in 1u32.., attempt in 1u32..) {
            let block = if practice { TrialBlock::Practice } else { TrialBlock::Main };
            let label = TrialLabel { block, number, attempt };
            prop_assert_eq!(label.to_string().parse(), Ok(label));
        }

        #[test]
        fn no_text_panics(name in "\\PC*") {
            let _ = name.parse::<TrialLabel>();
        }
    }
}
