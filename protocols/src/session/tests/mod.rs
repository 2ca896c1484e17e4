//! Whole sessions with a scripted participant, and invariants over arbitrary observations.

mod any_observation;
mod before_trial;
mod course;
mod interruptions;
mod repetitions;
mod resuming;
mod rig;
mod saving;
