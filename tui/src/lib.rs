//! Operator's dashboard and participant's screen.
//!
#![doc = include_str!("../README.md")]

pub mod action;
mod asked_keys;
mod calibration_keys;
pub mod calibration_page;
mod dashboard;
mod digits;
pub mod display;
pub mod drill_view;
mod escape;
pub mod event;
mod key_table;
mod keyboard;
mod panels;
pub mod participant_screen;
pub mod picture;
mod plot;
mod session_keys;
pub mod shell;
mod state;
mod terminal_keys;
mod theme;
mod words;

pub use action::Action;
pub use dashboard::{TWO_COLUMNS, view};
pub use display::ParticipantDisplay;
pub use escape::{escaped, escaped_line};
pub use event::Event;
pub use keyboard::{Reaction, key};
pub use participant_screen::{Instruction, ParticipantView, Repeat};
pub use shell::{ShellError, install_panic_hook, restore, run_operator};
pub use state::{HISTORY_S, LogLine, Page, STALE_AFTER_S, State, TrialLine, Ui, Window};
pub use theme::Theme;
