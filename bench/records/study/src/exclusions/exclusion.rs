//! One exclusion: its recordings, the reason and the author.

use std::fmt;
use std::str::FromStr;

use protocols::ParticipantId;
use recording::study::{TrialBlock, TrialLabel};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// All of something, or the one with this number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AllOrOne<T: Copy + fmt::Display> {
    /// All.
    All,
    /// This one.
    One(T),
}

/// Trial of a session, with all attempts at it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct SessionTrial {
    /// Part of the session.
    pub block: TrialBlock,
    /// Number within its part, from 1.
    pub number: u32,
}

/// Recordings that are excluded, and the reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Exclusion {
    /// Participant.
    pub participant: ParticipantId,
    /// Session.
    pub session: AllOrOne<u32>,
    /// Trials.
    pub trial: AllOrOne<SessionTrial>,
    /// Reason.
    pub reason: String,
    /// Person who decided it.
    pub by: String,
    /// Date; `None` if it is not stated.
    pub date: Option<String>,
}

impl Exclusion {
    /// Returns whether the exclusion covers this trial.
    #[must_use]
    pub fn covers(
        &self,
        participant: &str,
        session: Option<u32>,
        trial: Option<SessionTrial>,
    ) -> bool {
        let session_matches = match self.session {
            AllOrOne::All => true,
            AllOrOne::One(number) => session == Some(number),
        };
        let trial_matches = match self.trial {
            AllOrOne::All => true,
            AllOrOne::One(number) => trial == Some(number),
        };
        self.participant.as_str() == participant && session_matches && trial_matches
    }
}

impl fmt::Display for Exclusion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.participant)?;
        if let AllOrOne::One(session) = self.session {
            write!(f, ", session {session}")?;
        }
        match self.trial {
            AllOrOne::One(trial) if trial.block == TrialBlock::Main => {
                write!(f, ", trial {trial}")?
            }
            AllOrOne::One(trial) => write!(f, ", {trial}")?,
            AllOrOne::All => {}
        }
        write!(f, ": {} ({}", self.reason, self.by)?;
        if let Some(date) = &self.date {
            write!(f, ", {date}")?;
        }
        f.write_str(")")
    }
}

/// Cell that stands for all sessions or trials.
pub(crate) const ALL: &str = "all";
const PRACTICE: &str = "practice-";

impl<T: Copy + fmt::Display> fmt::Display for AllOrOne<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str(ALL),
            Self::One(value) => value.fmt(f),
        }
    }
}

impl<T: Copy + fmt::Display> Serialize for AllOrOne<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de, T: Copy + fmt::Display + FromStr> Deserialize<'de> for AllOrOne<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        if text == ALL {
            return Ok(Self::All);
        }
        let one = text.parse();
        one.map(Self::One)
            .map_err(|_| D::Error::custom(format!("`{text}` is neither `{ALL}` nor a number")))
    }
}

impl fmt::Display for SessionTrial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.block {
            TrialBlock::Main => write!(f, "{}", self.number),
            TrialBlock::Practice => write!(f, "{PRACTICE}{}", self.number),
        }
    }
}

impl From<TrialLabel> for SessionTrial {
    fn from(label: TrialLabel) -> Self {
        Self {
            block: label.block,
            number: label.number,
        }
    }
}

/// Parses a number from 1 that consists of digits only.
pub(crate) fn number(text: &str) -> Option<u32> {
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|number| digits && *number >= 1)
}

impl FromStr for SessionTrial {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (block, digits) = match text.strip_prefix(PRACTICE) {
            Some(rest) => (TrialBlock::Practice, rest),
            None => (TrialBlock::Main, text),
        };
        match number(digits) {
            Some(number) => Ok(Self { block, number }),
            None => Err("a trial is its number from 1, or practice-1 for practice".to_owned()),
        }
    }
}
