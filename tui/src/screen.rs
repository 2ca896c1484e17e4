//! The dashboard's layouts.

use ratatui::Frame;

use crate::panels;
use crate::state::State;

/// Draws the operator's screen: a pure function of `state`.
///
/// The first row always tells the safety state, at any size that has a row.
pub fn view(state: &State, frame: &mut Frame) {
    let area = frame.area();
    panels::safety::render(state, area, frame.buffer_mut());
}
