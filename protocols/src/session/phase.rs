//! The phases of a session.

use serde::{Deserialize, Serialize};

/// Phase of a session, for the operator's screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// The session waits for the consent; nothing is driven before it is recorded.
    Consent,
    /// The participant is welcomed.
    Welcome,
    /// The dead-man switch is to be released and held; nothing is driven.
    Hold,
    /// The plate is driven without a finger.
    Baseline,
    /// The session waits for the finger on the plate and the button.
    Ready,
    /// The slider is about to move.
    Countdown,
    /// The slider moves.
    Exploration,
    /// The finger should leave the plate.
    Lift,
    /// The mean force is shown.
    Feedback,
    /// The bench analyses the trial.
    Analysing,
    /// The operator can overrule the verdict.
    Verdict,
    /// The session waits until the recording is saved, before it settles the trial or begins the next.
    Saving,
    /// The participant has a break.
    Rest,
    /// The operator paused, or the session timed out waiting for the participant.
    Paused,
    /// A safety device tripped.
    Fault,
    /// Every trial is settled.
    Finished,
    /// The operator ended the session.
    Aborted,
}
