//! One file per panel; each draws its part of the state into the area that it is given.

pub(crate) mod amplitude;
pub(crate) mod asked_detail;
pub(crate) mod calibration_layout;
mod calibration_points;
mod calibration_values;
pub(crate) mod crop;
pub(crate) mod drill;
pub(crate) mod estimates;
pub(crate) mod forces;
pub(crate) mod help;
pub(crate) mod impedance;
pub(crate) mod key_hints;
mod live_values;
pub(crate) mod log;
pub(crate) mod new_carrier;
pub(crate) mod panel;
pub(crate) mod plate_drawing;
pub(crate) mod readings;
pub(crate) mod safety_line;
pub(crate) mod session_header;
pub(crate) mod session_phase;
mod strip_chart;
pub(crate) mod summary;
pub(crate) mod system_health;
pub(crate) mod trials;
