//! The session as a state machine: observations in, actions out.

mod event;
mod interface;
mod machine;
#[cfg(test)]
mod tests;

pub use event::{SessionEvent, SessionEventKind, records_from_events};
pub use interface::{
    Action, Cue, DriveRequest, Instruction, Observation, OperatorCommand, ParticipantView, Phase,
    Progress, Safety, SessionOutcome,
};
pub use machine::{Session, SessionError};
