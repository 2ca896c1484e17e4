//! Live processing of the samples for the operator: readings and texts for the dashboard, the fit of the participant's contact
//! after each trial, and detection of interference.

pub mod attempt_name;
pub mod attempt_record;
pub mod attempt_state;
pub mod carrier_decision;
pub mod contact_curves;
pub mod due_trial;
pub mod exploration_crop;
pub mod fit_report;
pub mod interference;
pub mod live_contact;
pub mod live_meter;
pub mod live_side;
mod live_zero;
pub mod monitor_task;
pub mod outlook;
pub mod participant_screen;
pub mod participant_skin;
pub mod past_trials;
mod period;
pub mod readiness;
pub mod refit;
pub mod resumed;
pub mod screen_words;
#[cfg(test)]
mod tests;
pub mod trial_fit;
pub mod visit;
pub mod window_screen;

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
