//! Participant protocols: files, session state machine, crop and selection, verdicts.
//!
//! Everything here is a pure function of its arguments: no clock, no thread, no file, no device.
//! Times are seconds of the audio clock, positions metres along the plate from its left end, forces newtons (positive
//! when the finger presses), amplitudes peak metres, drive amplitudes peak volts across the actuators.
//!
//! - [`Protocol`] is a validated protocol file.
//! - [`Session`] turns [`Observation`]s into [`SessionAction`]s.
//! - [`selection`] finds the rising stretches of an exploration and the instances in them.
//! - [`verdict`] accepts a trial, or gives the reasons to repeat it.

mod analysis;
mod order;
mod protocol;
mod record;
mod redo_reason;
mod rules;
pub mod selection;
mod session;
mod stretch;
mod summary;
mod trial;
mod trial_label;
pub mod verdict;

pub use analysis::{ExplorationAnalysis, TrialAnalysis};
pub use participant_texts::{Instruction, Language, OwnTexts, RepeatCause, Texts};
pub use participants::{
    AskedOfParticipant, Handedness, MAX_AGE_YEARS, MIN_AGE_YEARS, NOT_STATED, ParticipantId,
    ParticipantIdError, Person, PersonDetail, PersonError, Sex,
};
pub use protocol::{
    BUILT_IN, BrokenRule, Carrier, Condition, Course, CourseStep, Drive, DrivingTime, Exploration,
    LIFT_S, NewCarrier, OffPlateError, Order, PLACE_S, Protocol, ProtocolError, RedoLimits,
    ResonanceDrift, Rest, Selection, Slider, StepKind, TEMPLATE, Timeouts, Timing, Trials,
    built_in, nearest_built_in,
};
pub use record::{TrialOutcome, TrialRecord};
pub use redo_reason::{RedoReason, brief_reasons};
pub use rules::{ForceBand, Quality, SelectionRules, VerdictRules};
pub use selection::{ExplorationSeries, Validity};
pub use session::{
    AttemptRecords, Cue, DeadManAction, DriveRequest, Observation, OperatorCommand,
    ParticipantView, Phase, Progress, RecordMismatch, RecordingOutcome, SafetyChain, Session,
    SessionAction, SessionError, SessionEvent, SessionEventKind, SessionOutcome,
    records_from_events, repeat_cause,
};
pub use stretch::{Instance, Rejection, Stretch, StretchOutcome};
pub use summary::SessionSummary;
pub use trial::{Direction, Interruption, Interval, IntervalKind, TrialEnd, TrialKey};
pub use trial_label::{NoTrialLabel, TrialBlock, TrialLabel};
pub use verdict::Verdict;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
