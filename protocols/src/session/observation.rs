//! Inputs of a session: time, force, button, operator, safety and analyses.

use crate::analysis::TrialAnalysis;
use crate::trial::TrialKey;
use serde::{Deserialize, Serialize};

/// State of the bench at one moment; unknown values are `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Observation {
    /// Time on the audio clock, s. A time that is not finite or before an earlier observation counts as the earlier time.
    pub t_s: f64,
    /// Latest normal force, N; `None` (or NaN) without a recent one: the finger then counts as neither on nor off
    /// the plate, and no baseline completes.
    pub normal_n: Option<f64>,
    /// Whether the participant's button went down since the last observation.
    pub button_pressed: bool,
    /// Command that the operator gave since the last observation.
    pub command: Option<OperatorCommand>,
    /// State of the safety chain.
    pub safety: SafetyChain,
    /// The dead-man switch; `None` on a bench without one.
    pub hold: Option<DeadManAction>,
    /// Time without driving after which the hour's driving time allows another trial, s; 0 if it allows one now.
    pub drive_wait_s: f64,
    /// Whether the operator must answer a question before the next trial: a judged trial is then not settled by time.
    pub asking: bool,
    /// The lost display and the cause, if the participant cannot see the screen; `None` if all displays are seen.
    pub display_lost: Option<String>,
    /// Whether an operator watches: a verdict then stays open long enough to be overruled.
    pub attended: bool,
    /// The answer to [`SessionAction::AnalyseTrial`](crate::SessionAction::AnalyseTrial).
    pub analysis: Option<TrialAnalysis>,
    /// Outcome of an attempt's recording, if known. No attempt is accepted before its recording is saved.
    pub recording: Option<(TrialKey, RecordingOutcome)>,
    /// Audio that the recorder has neither written to the disk nor counted as lost, or time since it last answered, s.
    pub recorder_lag_s: f64,
}

/// Outcome of the recording of an attempt.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordingOutcome {
    /// It is on the disk and was read back.
    Saved,
    /// It is missing or incomplete, with the reason.
    Failed(String),
}

/// Action required at the dead-man switch before a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeadManAction {
    /// Release it: it has not been released since the last drive.
    Release,
    /// Press and hold it.
    Press,
    /// No action: it was released, and is held.
    Held,
}

/// State of the safety chain.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum SafetyChain {
    /// Armed, or ready to be armed.
    #[default]
    Ok,
    /// Tripped and latched, with the reason.
    Tripped(String),
}

/// Commands of the operator.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OperatorCommand {
    /// The participant has consented.
    ConsentGiven {
        /// Name of the person who recorded it.
        by: String,
    },
    /// Continue where the participant's button would: welcome, ready, end of rest (even before its time).
    Continue,
    /// Pause the session: at once if no attempt would be lost, else at the end of the attempt.
    Pause,
    /// Pause the session at once; this attempt, if it runs, is interrupted and repeated later.
    PauseNow {
        /// Number of the trial in the session's order, from 1.
        number: u32,
        /// Number of the attempt, from 1.
        attempt: u32,
    },
    /// Resume after a pause, or after a fault once the safety chain is armed again. Cancels a pause that waits.
    Resume,
    /// Repeat the trial of this attempt, which runs or has just been judged.
    Redo {
        /// Number of the trial in the session's order, from 1.
        number: u32,
        /// Number of the attempt, from 1.
        attempt: u32,
    },
    /// Keep this attempt, just judged, although its verdict rejects it.
    AcceptAnyway {
        /// Number of the trial in the session's order, from 1.
        number: u32,
        /// Number of the attempt, from 1.
        attempt: u32,
    },
    /// End the session.
    Abort,
}
