//! Calibrations of a bench, and surveys of its plate.
//!
//! | module | contents |
//! | --- | --- |
//! | [`channels`] | input channels against each other: gain, phase, noise |
//! | [`pickup`] | the pickup against a known amplitude |
//! | [`plate_procedure`] | the unloaded plate: resonance, damping, constants |
//! | [`swept_plate`] | the same from a sweep measured elsewhere |
//! | [`volts`] | the bench's volts against an independent meter |
//! | [`masses`] | the force sensor against known masses |
//! | [`survey`] | the plate under a finger and along its length |
//!
//! Each is a [`calibration_rig::procedure::Procedure`], which [`calibration_rig::rig::run`] plays on the bench.

pub mod channel_match;
pub mod channels;
mod instrument_mean;
pub mod masses;
pub mod pickup;
mod plate_limits;
pub mod plate_look;
pub mod plate_procedure;
mod rejected_result;
pub mod survey;
pub mod swept_plate;
pub mod volts;
