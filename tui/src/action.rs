//! Requests of the operator to the bench: the screen's only effects.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::calibration_page::Reply;

/// The attempt that a request is about, so that it never falls on the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct AttemptName {
    /// Number of the trial, from 1. Practice trials are numbered separately.
    pub trial: u32,
    /// Whether the trial is practice.
    pub practice: bool,
    /// Number of the attempt, from 1.
    pub attempt: u32,
}

impl fmt::Display for AttemptName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sort = if self.practice { "practice" } else { "trial" };
        write!(f, "{sort} {}", self.trial)?;
        if self.attempt > 1 {
            write!(f, ", attempt {}", self.attempt)?;
        }
        Ok(())
    }
}

/// One request of the operator. The bench decides whether it is granted.
///
/// ```
/// use tui::Action;
/// use tui::calibration_page::Reply;
///
/// let typed = Action::Answer(Reply::Number(1.25));
/// assert_eq!(serde_json::to_string(&typed)?, r#"{"answer":{"number":1.25}}"#);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Start the session; in `monitor`, start the drive.
    Start,
    /// Record that the participant has given consent. Needs confirmation.
    Consent,
    /// Continue: the participant is in place. Also ends a rest, and says that a drill's fault was seen.
    Ready,
    /// Pause: at once where no attempt would be lost, else at the end of the attempt.
    Pause,
    /// Pause at once; this attempt is lost. Needs confirmation.
    PauseNow(AttemptName),
    /// Resume the paused session, with the participant's display if it was lost; that needs confirmation.
    Resume,
    /// Repeat the trial of this attempt. Needs confirmation while it runs.
    Redo(AttemptName),
    /// Keep this attempt although its verdict rejects it.
    AcceptAnyway(AttemptName),
    /// Abort the session. Needs confirmation.
    Abort,
    /// Reply to a calibration's question.
    Answer(Reply),
    /// Take the proposed carrier from the next trial on.
    TakeCarrier,
    /// Keep the present carrier.
    KeepCarrier,
    /// Move a replay.
    Seek {
        /// By how much; negative goes back, s.
        by_s: f64,
    },
    /// Stop the drive at once, without confirmation.
    EmergencyStop,
    /// Re-arm after a trip. Needs confirmation.
    Rearm,
    /// Quit. Needs confirmation while a session or a calibration runs.
    Quit,
    /// Stop in an orderly way without confirmation, as on SIGINT (Ctrl-C).
    Interrupt,
}
