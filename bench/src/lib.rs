//! The commands of the test bench controller. The binary composes them with hardware, real or simulated; nothing in
//! here knows which.

pub mod analyze;
mod analyze_options;
pub mod apparatus;
pub mod calibrate;
pub mod cli;
mod dates;
pub mod drilling;
pub mod ending;
pub mod estop;
pub mod exclude;
pub mod fault_option;
pub mod forget;
pub mod interference;
pub mod inventory;
pub mod journal;
pub mod live_meter;
pub mod monitor;
mod outcome;
pub mod privacy;
pub mod readiness;
pub mod refit;
pub mod rehearsed;
pub mod replay;
pub mod run;
pub mod screen_words;
pub mod session;
pub mod shell_words;
pub mod verbosity;
pub mod verify;
