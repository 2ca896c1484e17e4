//! Contents of the participant's screen.

use crate::redo_reason::RedoReason;
use crate::rules::ForceBand;
use crate::trial::Direction;
use participant_texts::{Instruction, RepeatCause};

/// Progress of the participant through the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
#[derive(Clone, Debug, PartialEq)]
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
    pub repeat: Option<RepeatCause>,
}

/// Returns the cause of a repetition that the participant can act on. A lifted finger has priority over speed, and speed over force: a
/// slider is easier to follow than a force is to keep.
#[must_use]
pub fn repeat_cause(reasons: &[RedoReason]) -> RepeatCause {
    let speed = reasons.iter().find_map(|reason| match reason {
        RedoReason::SpeedOutOfBand {
            speed_m_per_s,
            min_m_per_s,
            ..
        } => Some(if speed_m_per_s < min_m_per_s {
            RepeatCause::TooSlow
        } else {
            RepeatCause::TooFast
        }),
        _ => None,
    });
    let force = reasons.iter().find_map(|reason| match reason {
        RedoReason::ForceOutOfBand { mean_n, min_n, .. } => Some(if mean_n < min_n {
            RepeatCause::TooLight
        } else {
            RepeatCause::TooHard
        }),
        _ => None,
    });
    let is_lift = |reason: &RedoReason| matches!(reason, RedoReason::FingerLifted { .. });
    let lift = reasons.iter().any(is_lift).then_some(RepeatCause::Lifted);
    lift.or(speed).or(force).unwrap_or(RepeatCause::Other)
}
