//! The session as a state machine: observations in, actions out.
//!
//! Each file depends only on earlier ones: [`observation`], [`event`] and [`action`] are the machine's input and output,
//! [`plan`] the order of trials, [`attempts`] the attempts at them, [`state`] and [`machine`] the state,
//! [`trial_steps`] and [`settling`] its transitions, [`commands`] the transitions by the operator, [`show`] the
//! participant's view, and [`step`] one complete step.

mod action;
mod attempts;
mod commands;
mod error;
mod event;
mod machine;
mod observation;
mod participant_view;
mod phase;
mod plan;
mod settling;
mod show;
mod state;
mod step;
#[cfg(test)]
mod tests;
mod trial_steps;

pub use action::{Cue, DriveRequest, SessionAction};
pub use error::{RecordMismatch, SessionError};
pub use event::{
    AttemptRecords, SessionEvent, SessionEventKind, SessionOutcome, records_from_events,
};
pub use machine::Session;
pub use observation::{DeadManAction, Observation, OperatorCommand, RecordingOutcome, SafetyChain};
pub use participant_view::{ParticipantView, Progress, repeat_cause};
pub use phase::Phase;
