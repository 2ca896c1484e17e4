//! Errors at the start or resumption of a session.

use crate::trial::TrialKey;
use participants::ParticipantId;

/// Why a session cannot start or resume.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionError {
    /// A counterbalanced order needs a participant number.
    #[error(
        "participant `{participant}` has no number, which a counterbalanced order needs: end the identifier in digits, \
         for example `sub-01`"
    )]
    NoParticipantNumber {
        /// The identifier.
        participant: ParticipantId,
    },
    /// An attempt of the earlier part of the session does not belong to this session.
    #[error(
        "trial {}, attempt {} ({}) of the earlier part does not belong to this protocol, participant and seed: \
         {because}; name the protocol and the seed that the session began with, or begin another session with --new-session",
        .key.number, .key.attempt, .key.condition
    )]
    ForeignRecord {
        /// The attempt.
        key: TrialKey,
        /// The mismatch.
        because: RecordMismatch,
    },
}

/// Mismatch of an attempt of the earlier part with this session.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordMismatch {
    /// Every trial was settled before it.
    #[error("all {trials} trials were settled before it")]
    AllSettled {
        /// Number of trials, practice included.
        trials: usize,
    },
    /// Another trial was due.
    #[error("trial {number} was due")]
    Trial {
        /// The trial that was due, from 1.
        number: u32,
    },
    /// The trial has another condition, or only one of the two is a practice trial.
    #[error("the trial's condition is {condition}{}", if *.practice { " (practice)" } else { "" })]
    Condition {
        /// Name of the trial's condition in this session.
        condition: String,
        /// Whether it is a practice trial in this session.
        practice: bool,
    },
    /// The attempt occurs twice.
    #[error("attempt {next} was due")]
    Attempt {
        /// Lowest number of an attempt that may follow, from 1.
        next: u32,
    },
}
