//! The commands of the test bench controller. The binary composes them with real or simulated hardware; this library does
//! not distinguish the two.

pub mod analyze;
mod analyze_options;
pub mod apparatus;
pub mod archiving;
pub mod calibrate;
pub mod calibration_report;
pub mod cli;
mod confirmation;
pub mod dates;
pub mod drilling;
pub mod ending;
pub mod estop;
pub mod exclude;
pub mod export;
pub mod forget;
mod hardware_options;
mod import_options;
pub mod importing;
mod list_options;
pub mod listing;
pub mod monitor;
mod outcome;
pub mod privacy;
mod protocol_options;
pub mod protocol_outlook;
pub mod run;
pub mod session;
pub mod verbosity;
pub mod verify;
