//! Participant protocols: files, session state machine, crop and selection, verdicts.
//!
//! Everything here is a pure function of its arguments: no clock, no thread, no file, no device.
//! Times are seconds of the audio clock, positions metres along the plate, forces newtons (positive when the
//! finger presses), amplitudes peak metres, drive amplitudes peak volts across the actuators.
//!
//! - [`Protocol`] is a validated protocol file.
//! - [`Session`] turns [`Observation`]s into [`Action`]s.
//! - [`selection`] finds the rising stretches of an exploration and the instances in them.
//! - [`verdict`] accepts a trial or says why it must be repeated.

mod order;
mod participant;
mod protocol;
pub mod selection;
mod session;
mod trial;
pub mod verdict;

pub use participant::{ParticipantId, ParticipantIdError};
pub use protocol::{
    BUILT_IN, Carrier, Condition, Drive, Exploration, ForceBand, Order, Protocol, ProtocolError,
    Quality, RedoLimits, Rest, Selection, Slider, Timeouts, Timing, Trials, built_in,
};
pub use selection::{ExplorationSeries, Instance, Rejection, SelectionRules, Stretch, Validity};
pub use session::{
    Action, Cue, DriveRequest, Instruction, Observation, OperatorCommand, ParticipantView, Phase,
    Progress, Safety, Session, SessionError, SessionEvent, SessionEventKind, SessionOutcome,
    records_from_events,
};
pub use trial::{
    Direction, Interruption, Interval, IntervalKind, TrialEnd, TrialKey, TrialOutcome, TrialRecord,
};
pub use verdict::{
    ExplorationAnalysis, RedoReason, SessionSummary, TrialAnalysis, Verdict, VerdictRules,
};
