//! What is made of the samples while they come, for the operator: readings and words for the dashboard, the participant's
//! contact fitted after each trial, interference that disturbs the bench.

pub mod carrier_decision;
pub mod contact_curves;
pub mod exploration_crop;
pub mod fit_report;
pub mod interference;
pub mod live_meter;
pub mod live_side;
pub mod outlook;
pub mod participant_screen;
pub mod participant_skin;
pub mod past_trials;
mod period;
pub mod readiness;
pub mod refit;
pub mod resumed;
pub mod screen_words;
pub mod visit;
pub mod window_screen;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
