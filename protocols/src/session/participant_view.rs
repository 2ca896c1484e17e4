//! Contents of the participant's screen.

use crate::redo_reason::RedoReason;
use crate::rules::ForceBand;
use crate::trial::Direction;
use serde::{Deserialize, Serialize};

/// Instruction to the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Instruction {
    /// Wait.
    Wait,
    /// Press the button to begin.
    Welcome,
    /// Release the dead-man switch.
    ReleaseSwitch,
    /// Press the dead-man switch and hold it.
    HoldSwitch,
    /// Lift the finger: the dead-man switch was released.
    SwitchReleased,
    /// Take the finger off the plate.
    LiftFinger,
    /// Put the finger at the slider and press the button.
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

/// Progress of the participant through the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Progress {
    /// The trial, from 1, practice included.
    pub trial: u32,
    /// Number of trials, practice included.
    pub trials: u32,
    /// The exploration within the trial, from 1; 0 before the first.
    pub exploration: u32,
    /// Number of explorations in a trial.
    pub explorations: u32,
    /// Whether this is a practice trial.
    pub practice: bool,
    /// Attempt at the trial, from 1; grows when it is repeated.
    pub attempt: u32,
}

/// Contents of the participant's screen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParticipantView {
    /// Instruction shown.
    pub instruction: Instruction,
    /// Position of the slider along the plate, m; `None` if it is hidden.
    pub slider_m: Option<f64>,
    /// Direction in which the slider will move or moves.
    pub direction: Option<Direction>,
    /// Time until the slider moves, or until the button ends a break, s.
    pub countdown_s: Option<f64>,
    /// Mean normal force of the last exploration, N; only with [`Instruction::Feedback`].
    pub mean_force_n: Option<f64>,
    /// Band of the normal force asked of the participant.
    pub force_band: ForceBand,
    /// Whether the session waits for the button.
    pub button: bool,
    /// Progress through the session; `None` outside trials.
    pub progress: Option<Progress>,
    /// Why the trial just made will be repeated; `None` if it will not.
    #[serde(default)]
    pub repeat: Option<RepeatCause>,
}

/// Why a trial is repeated, as far as it concerns the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RepeatCause {
    /// The finger was slower than the slider.
    TooSlow,
    /// The finger was faster than the slider.
    TooFast,
    /// The finger pressed too little.
    TooLight,
    /// The finger pressed too much.
    TooHard,
    /// The participant was not the cause.
    Other,
}

impl From<&[RedoReason]> for RepeatCause {
    /// Gives speed priority over force: a slider is easier to follow than a force is to keep.
    fn from(reasons: &[RedoReason]) -> Self {
        let speed = reasons.iter().find_map(|reason| match reason {
            RedoReason::SpeedOutOfBand {
                speed_m_per_s,
                min_m_per_s,
                ..
            } => Some(if speed_m_per_s < min_m_per_s {
                Self::TooSlow
            } else {
                Self::TooFast
            }),
            _ => None,
        });
        let force = reasons.iter().find_map(|reason| match reason {
            RedoReason::ForceOutOfBand { mean_n, min_n, .. } => Some(if mean_n < min_n {
                Self::TooLight
            } else {
                Self::TooHard
            }),
            _ => None,
        });
        speed.or(force).unwrap_or(Self::Other)
    }
}
