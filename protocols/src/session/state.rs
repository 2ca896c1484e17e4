//! The states of a session.

use super::phase::Phase;
use crate::analysis::TrialAnalysis;
use crate::record::TrialOutcome;
use crate::redo_reason::RedoReason;
use crate::trial::{Interval, TrialKey};

/// State of a session; `since_s` is the time at which it was entered, s.
#[derive(Clone, Debug)]
pub(super) enum State {
    Consent,
    Welcome,
    /// The session waits for the dead-man switch before the next trial.
    Hold {
        since_s: f64,
    },
    Trial {
        open: OpenTrial,
        step: TrialStep,
        since_s: f64,
    },
    Analysing {
        key: TrialKey,
        since_s: f64,
    },
    Judged {
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        /// Why the verdict rejected the trial; empty if it accepted it.
        reasons: Vec<RedoReason>,
        since_s: f64,
    },
    /// The attempt is settled as soon as its recording is saved.
    Saving {
        key: TrialKey,
        analysis: Option<TrialAnalysis>,
        outcome: TrialOutcome,
        since_s: f64,
    },
    /// The session waits for the recorder before the next trial.
    Behind {
        since_s: f64,
        /// Whether the operator was informed.
        is_reported: bool,
    },
    Rest {
        since_s: f64,
    },
    Halted {
        /// Whether a safety device tripped; otherwise the session is paused.
        fault: bool,
        sequel: AfterHalt,
    },
    Finished {
        aborted: bool,
    },
}

/// A trial with an open recording.
#[derive(Clone, Debug)]
pub(super) struct OpenTrial {
    pub(super) key: TrialKey,
    /// Intervals marked so far.
    pub(super) intervals: Vec<Interval>,
}

/// Step of a trial; explorations count from 0.
#[derive(Clone, Debug)]
pub(super) enum TrialStep {
    Baseline {
        /// Time since which the drive has settled and the finger has been off, s.
        off_since_s: Option<f64>,
    },
    Ready {
        exploration: usize,
    },
    Countdown {
        exploration: usize,
    },
    Exploration {
        exploration: usize,
        /// Normal force while the finger is on the plate, N.
        force: Mean,
    },
    Lift {
        exploration: usize,
        /// Mean normal force of the exploration, N.
        mean_n: Option<f64>,
    },
    Feedback {
        exploration: usize,
        /// Mean normal force of the exploration, N.
        mean_n: Option<f64>,
    },
}

/// Continuation of a session after a halt.
#[derive(Clone, Debug)]
pub(super) enum AfterHalt {
    /// A new attempt at the trial.
    Trial,
    /// The halted state.
    State(Box<State>),
}

/// A running mean.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mean {
    sum: f64,
    n: u32,
}

impl Mean {
    /// Adds a value.
    pub(super) fn push(&mut self, x: f64) {
        self.sum += x;
        self.n += 1;
    }

    /// Returns the mean of the values added, `None` without any.
    pub(super) fn value(self) -> Option<f64> {
        (self.n > 0).then(|| self.sum / f64::from(self.n))
    }
}

impl State {
    /// Returns the attempt that runs, is analysed, judged or saved, also of a halted state.
    pub(super) fn current(&self) -> Option<&TrialKey> {
        match self {
            Self::Trial { open, .. } => Some(&open.key),
            Self::Analysing { key, .. } | Self::Judged { key, .. } | Self::Saving { key, .. } => {
                Some(key)
            }
            Self::Halted {
                sequel: AfterHalt::State(state),
                ..
            } => state.current(),
            _ => None,
        }
    }

    /// Returns the halted state, or this one if it is not halted.
    pub(super) fn running(&self) -> &Self {
        match self {
            Self::Halted {
                sequel: AfterHalt::State(state),
                ..
            } => state.running(),
            state => state,
        }
    }

    /// Returns the attempt that is judged and not settled, also of a halted state.
    pub(super) fn judged_key(&self) -> Option<&TrialKey> {
        self.reasons().and(self.current())
    }

    /// Returns the reasons for which the open verdict rejects its attempt, also of a halted state; empty if it accepts it.
    pub(super) fn reasons(&self) -> Option<&[RedoReason]> {
        match self {
            Self::Judged { reasons, .. } => Some(reasons),
            Self::Halted {
                sequel: AfterHalt::State(state),
                ..
            } => state.reasons(),
            _ => None,
        }
    }

    /// Returns the phase for the operator's screen.
    pub(super) fn phase(&self) -> Phase {
        match self {
            Self::Consent => Phase::Consent,
            Self::Welcome => Phase::Welcome,
            Self::Hold { .. } => Phase::Hold,
            Self::Trial { step, .. } => match step {
                TrialStep::Baseline { .. } => Phase::Baseline,
                TrialStep::Ready { .. } => Phase::Ready,
                TrialStep::Countdown { .. } => Phase::Countdown,
                TrialStep::Exploration { .. } => Phase::Exploration,
                TrialStep::Lift { .. } => Phase::Lift,
                TrialStep::Feedback { .. } => Phase::Feedback,
            },
            Self::Analysing { .. } => Phase::Analysing,
            Self::Judged { .. } => Phase::Verdict,
            Self::Saving { .. } | Self::Behind { .. } => Phase::Saving,
            Self::Rest { .. } => Phase::Rest,
            Self::Halted { fault: true, .. } => Phase::Fault,
            Self::Halted { fault: false, .. } => Phase::Paused,
            Self::Finished { aborted: false } => Phase::Finished,
            Self::Finished { aborted: true } => Phase::Aborted,
        }
    }
}
