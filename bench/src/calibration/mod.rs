//! Volts become micrometres and newtons: what the `calibrate` commands measure, the file that keeps it, and who may use it.

pub mod channel_match;
pub mod channels;
pub mod clear;
pub mod command;
pub mod file;
pub mod force;
pub mod guided;
pub mod heard;
pub mod held;
pub mod identity;
pub mod judged;
pub mod known;
pub mod operator;
pub mod pickup;
pub mod plate;
pub mod rig;
mod table;
pub mod unattended;

pub use file::{Calibration, FileError};
pub use held::Held;
pub use identity::Identity;
