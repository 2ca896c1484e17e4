//! Operator's dashboard and participant's screen.
//!
#![doc = include_str!("../README.md")]

pub mod action;
mod asked_keys;
mod bench_facts;
mod calibration_keys;
pub mod calibration_page;
mod contact_view;
mod dashboard;
pub mod display;
pub mod drill_view;
pub mod event;
mod frozen;
mod impedance_value;
mod key_table;
mod keyboard;
mod line_states;
mod outlook;
mod page;
mod pages;
mod panels;
pub mod participant_screen;
mod session_keys;
pub mod shell;
mod state;
mod strip;
mod view_keys;

pub use action::Action;
pub use dashboard::{TWO_COLUMNS, view};
pub use display::ParticipantTerminal;
pub use drawing::chosen_theme::{choose_theme, chosen_theme};
pub use drawing::picture;
pub use drawing::theme::{NoSuchTheme, Theme};
pub use event::Event;
pub use frozen::Frozen;
pub use keyboard::{Reaction, key};
pub use operator_terminal::{
    TerminalError, install_panic_hook, is_dumb as terminal_is_dumb, restore, size as terminal_size,
};
pub use page::{HISTORY_S, Page, Window};
pub use participant_screen::ScreenView;
pub use shell::run_operator;
pub use state::{LogLine, STALE_AFTER_S, State, TrialLine, Ui};
