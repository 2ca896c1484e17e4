//! The panels, one file each; each draws its part of the state into a given area.

pub(crate) mod bench_tables;
pub(crate) mod calibration_layout;
mod calibration_points;
mod calibration_values;
pub(crate) mod complex_plane;
pub(crate) mod contact_numbers;
pub(crate) mod detail_question;
pub(crate) mod drill;
pub(crate) mod fit_results;
pub(crate) mod friction_curve;
pub(crate) mod help;
pub(crate) mod key_hints;
pub(crate) mod live_values;
pub(crate) mod log;
pub(crate) mod new_carrier;
pub(crate) mod panel;
pub(crate) mod plate_drawing;
pub(crate) mod readings;
pub(crate) mod safety_line;
pub(crate) mod session_phase;
pub(crate) mod stage;
pub(crate) mod strips;
pub(crate) mod summary;
pub(crate) mod tabs;
pub(crate) mod trial_crop;
pub(crate) mod trial_list;
