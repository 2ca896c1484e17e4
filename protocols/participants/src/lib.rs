//! Participants: pseudonyms, and the details that participants state about themselves.

mod participant;
mod person;

pub use participant::{ParticipantId, ParticipantIdError};
pub use person::{
    AskedOfParticipant, Handedness, MAX_AGE_YEARS, MIN_AGE_YEARS, NOT_STATED, Person, PersonDetail,
    PersonError, Sex,
};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
