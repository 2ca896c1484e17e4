//! Calibrations of a bench: the measurements, their steps, and the verdicts on their results.
//!
//! A [`procedure::Procedure`] decides one step at a time; [`rig::run`] plays it on the bench and asks the
//! [`operator::Operator`], who is [`guided::Guided`] by the dashboard or [`unattended::Unattended`]; [`judged::Calibrates`]
//! judges the result.

mod admission;
mod broken_off;
pub mod calibration_figures;
pub mod capture;
pub mod clear;
pub mod constant_change;
mod drop_outs;
pub mod existing_file;
pub mod guided;
pub mod instrument_line;
pub mod judged;
pub mod known;
mod meter;
pub mod operator;
pub mod points;
pub mod procedure;
mod recent;
pub mod reference;
pub mod reference_options;
pub mod review;
pub mod rig;
mod rig_step;
pub mod side_files;
pub mod typed_table;
pub mod unattended;
mod watched_inputs;

pub use broken_off::EndedEarly;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
