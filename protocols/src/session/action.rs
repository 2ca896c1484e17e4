//! Requests of a session to the bench.

use super::event::{SessionEvent, SessionEventKind, SessionOutcome};
use super::participant_view::ParticipantView;
use crate::protocol::Drive;
use crate::trial::{Interval, TrialEnd, TrialKey};
use crate::verdict::Verdict;

/// Request of the session to the bench. The actions of a step are carried out in order.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionAction {
    /// Open a recording.
    BeginTrial {
        /// The attempt.
        key: TrialKey,
        /// The drive of its condition.
        drive: Drive,
        /// Time on the audio clock, s.
        at_s: f64,
    },
    /// Ramp the drive in or out; ramp in only within a trial.
    Drive(DriveRequest),
    /// Mark an interval of the open recording that has just ended.
    Mark(Interval),
    /// Close the recording.
    EndTrial {
        /// The attempt.
        key: TrialKey,
        /// Whether it was completed, or the cause of its interruption.
        end: TrialEnd,
        /// Time on the audio clock, s.
        at_s: f64,
    },
    /// Analyse a completed attempt and answer by [`Observation::analysis`](crate::Observation::analysis).
    AnalyseTrial {
        /// The attempt.
        key: TrialKey,
        /// The intervals marked in it.
        intervals: Vec<Interval>,
    },
    /// Announce a verdict, which the operator may overrule until the session moves on.
    Verdict {
        /// The attempt.
        key: TrialKey,
        /// The verdict.
        verdict: Verdict,
    },
    /// Play a sound.
    Cue(Cue),
    /// Write an event to the log.
    Log(SessionEvent),
    /// Show this view to the participant. Last in every step.
    Show(ParticipantView),
    /// End the session. Occurs once.
    Finished(SessionOutcome),
}

/// Request to the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveRequest {
    /// Ramp in.
    On(Drive),
    /// Ramp out.
    Off,
}

/// A sound for the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cue {
    /// The slider starts.
    Start,
    /// The slider has stopped.
    End,
}

/// The actions of one step so far.
pub(super) struct StepActions {
    pub(super) actions: Vec<SessionAction>,
    /// Time of the step on the audio clock, s.
    pub(super) t_s: f64,
}

impl StepActions {
    /// Begins the actions of a step at `t_s`.
    pub(super) fn at(t_s: f64) -> Self {
        Self {
            actions: Vec::new(),
            t_s,
        }
    }

    /// Adds an action.
    pub(super) fn push(&mut self, action: SessionAction) {
        self.actions.push(action);
    }

    /// Adds an event for the log.
    pub(super) fn log(&mut self, kind: SessionEventKind) {
        self.push(SessionAction::Log(SessionEvent {
            t_s: self.t_s,
            kind,
        }));
    }
}
