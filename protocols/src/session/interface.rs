//! What the session sees and what it asks for.

use super::event::SessionEvent;
use crate::protocol::{Drive, ForceBand};
use crate::trial::{Direction, Interval, TrialEnd, TrialKey};
use crate::verdict::{SessionSummary, TrialAnalysis, Verdict};
use serde::{Deserialize, Serialize};

/// What the bench knows at one moment; what it does not know is `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Observation {
    /// Time on the audio clock, s. A time before an earlier one, or not finite, counts as that earlier one.
    pub t_s: f64,
    /// Latest normal force, N; `None` (or NaN) when there is no recent one: then the finger counts as neither on
    /// nor off the plate, and no baseline passes.
    pub normal_n: Option<f64>,
    /// The participant's button went down since the last observation.
    pub button_pressed: bool,
    /// What the operator asked for since the last observation.
    pub command: Option<OperatorCommand>,
    /// State of the safety chain.
    pub safety: Safety,
    /// The answer to [`Action::AnalyseTrial`].
    pub analysis: Option<TrialAnalysis>,
}

/// State of the safety chain.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Safety {
    /// Armed, or able to be.
    #[default]
    Ok,
    /// Tripped and latched, with the reason.
    Tripped(String),
}

/// What the operator can ask for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OperatorCommand {
    /// The participant has consented.
    ConsentGiven {
        /// Who recorded it.
        by: String,
    },
    /// Go on where the participant's button would: welcome, ready, end of rest (even before its time).
    Continue,
    /// Stop; an open trial is cut short and repeated later.
    Pause,
    /// Go on after a pause, or after a fault once the safety chain is armed again.
    Resume,
    /// Repeat the trial that runs, or the one just judged.
    Redo,
    /// Keep the trial just judged although its verdict is redo.
    AcceptAnyway,
    /// End the session.
    Abort,
}

/// What the session asks of the bench, in this order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Open a recording.
    BeginTrial {
        /// Which attempt.
        key: TrialKey,
        /// What will be driven in it.
        drive: Drive,
        /// Now, s.
        at_s: f64,
    },
    /// Ramp the drive in or out. In only within a trial.
    Drive(DriveRequest),
    /// Mark an interval of the open recording; it has just ended.
    Mark(Interval),
    /// Close the recording.
    EndTrial {
        /// Which attempt.
        key: TrialKey,
        /// Completed, or why not.
        end: TrialEnd,
        /// Now, s.
        at_s: f64,
    },
    /// Analyse a completed attempt and answer by [`Observation::analysis`].
    AnalyseTrial {
        /// Which attempt.
        key: TrialKey,
        /// What was marked in it.
        intervals: Vec<Interval>,
    },
    /// A trial was judged; the operator may overrule it until the session goes on.
    Verdict {
        /// Which attempt.
        key: TrialKey,
        /// The judgement.
        verdict: Verdict,
    },
    /// Play a sound.
    Cue(Cue),
    /// Keep an event.
    Log(SessionEvent),
    /// What the participant sees from now on. Last in every step.
    Show(ParticipantView),
    /// The session is over. Comes once.
    Finished(SessionOutcome),
}

/// What the drive should do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveRequest {
    /// Ramp in.
    On(Drive),
    /// Ramp out.
    Off,
}

/// A sound for the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cue {
    /// The slider starts.
    Start,
    /// The slider has stopped.
    End,
}

/// How a session ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum SessionOutcome {
    /// Every trial was settled.
    Completed {
        /// The session in numbers.
        summary: SessionSummary,
    },
    /// The operator ended it.
    Aborted {
        /// The session in numbers.
        summary: SessionSummary,
    },
}

/// Where the session stands, for the operator's screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Nothing may be driven before the consent is recorded.
    Consent,
    /// The participant is welcomed.
    Welcome,
    /// Drive on, no finger.
    Baseline,
    /// Finger and button are awaited.
    Ready,
    /// Before the slider moves.
    Countdown,
    /// The slider moves.
    Exploration,
    /// The finger should leave the plate.
    Lift,
    /// The mean force is shown.
    Feedback,
    /// The bench analyses the trial.
    Analysing,
    /// The verdict can be overruled.
    Verdict,
    /// A break.
    Rest,
    /// The operator stopped, or the participant did not do as told in time.
    Paused,
    /// Safety tripped.
    Fault,
    /// Every trial is settled.
    Finished,
    /// The operator ended the session.
    Aborted,
}

/// What the participant is told to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Instruction {
    /// Nothing.
    Wait,
    /// Press the button to begin.
    Welcome,
    /// Take the finger off the plate.
    LiftFinger,
    /// Put the finger where the slider stands and press the button.
    PlaceFinger,
    /// The slider is about to move.
    GetReady,
    /// Follow the slider.
    FollowSlider,
    /// See how hard you pressed.
    Feedback,
    /// Have a break.
    Rest,
    /// The session is paused.
    Paused,
    /// The session is over.
    Finished,
}

/// Where in the session the participant is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// The trial, from 1, practice included.
    pub trial: u32,
    /// All trials, practice included.
    pub trials: u32,
    /// The exploration within it, from 1; 0 before the first.
    pub exploration: u32,
    /// Explorations of a trial.
    pub explorations: u32,
    /// Whether this is a practice trial.
    pub practice: bool,
    /// From 1; more when the trial is repeated.
    pub attempt: u32,
}

/// All that the participant's screen draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParticipantView {
    /// What to do.
    pub instruction: Instruction,
    /// Where the slider stands along the plate, m; `None` when it is not shown.
    pub slider_m: Option<f64>,
    /// Which way it will go or goes.
    pub direction: Option<Direction>,
    /// Seconds until the slider moves, or until the button ends a break.
    pub countdown_s: Option<f64>,
    /// Mean normal force of the exploration just made, N; only with [`Instruction::Feedback`].
    pub mean_force_n: Option<f64>,
    /// The forces asked for.
    pub force_band: ForceBand,
    /// Whether pressing the button does something now.
    pub button: bool,
    /// Where in the session; `None` outside trials.
    pub progress: Option<Progress>,
}
