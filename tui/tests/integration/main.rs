//! Tests of the operator's dashboard and the participant's screen.

mod calibration_page;
mod dashboard;
mod display;
mod keys;
mod lost_device;
mod operator_terminal;
mod pages;
mod participant_screen;
mod picture;
#[cfg(unix)]
mod pty;
mod redraw;
mod rig;
mod state;
#[path = "../../examples/dashboard/synthetic.rs"]
mod synthetic;
