//! Requests of the operator to the bench, the only effects of the screen.

use std::fmt;

use crate::calibration_page::Reply;

/// The attempt named in a request, so that the request never applies to the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// One request of the operator. The bench decides whether to grant it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Start the session; in `monitor`, start the drive.
    Start,
    /// Record that the participant has given consent. Needs confirmation.
    Consent,
    /// Continue: the participant is in place. Also ends a rest, and acknowledges a drill's fault.
    Ready,
    /// Pause: at once if no attempt would be lost, else at the end of the attempt.
    Pause,
    /// Pause at once; this attempt is lost. Needs confirmation.
    PauseNow(AttemptName),
    /// Resume the paused session and reopen the participant's display if it was lost, which needs confirmation.
    Resume,
    /// Repeat the trial of this attempt. Needs confirmation while it runs.
    Redo(AttemptName),
    /// Keep this attempt although its verdict rejects it.
    AcceptAnyway(AttemptName),
    /// Abort the session. Needs confirmation.
    Abort,
    /// Reply to a calibration's question.
    Answer(Reply),
    /// Use the proposed carrier from the next trial on.
    TakeCarrier,
    /// Keep the present carrier.
    KeepCarrier,
    /// Move a replay.
    Seek {
        /// Distance in time; negative goes back, s.
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
