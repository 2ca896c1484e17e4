//! The page of the impedance: the complex plane, its numbers, friction against amplitude, and their strips.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};

use super::Room;
use crate::panels::{complex_plane, contact_numbers, fit_results, friction_curve, strips};
use crate::state::State;
use crate::strip::Strip;

/// Draws one panel enlarged, numbered from 1.
pub(crate) fn enlarge(state: &State, panel: u8, area: Rect, buf: &mut Buffer) {
    match panel {
        1 => complex_plane::render(state, area, buf),
        _ => friction_curve::render(state, area, buf),
    }
}

pub(crate) fn render(state: &State, room: Room, area: Rect, buf: &mut Buffer) {
    let gap = if room == Room::Small { 2 } else { 3 };
    let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Fill(1)])
        .spacing(Spacing::Space(gap))
        .areas(area);
    let strip_rows = if room == Room::Small {
        5
    } else {
        left.height / 4
    };
    let [plane, impedance] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(strip_rows)]).areas(left);
    complex_plane::render(state, plane, buf);
    strips::render(state, Strip::Impedance, impedance, buf);
    let [numbers, fit, friction, amplitude] = Layout::vertical([
        Constraint::Length(contact_numbers::ROWS),
        Constraint::Length(fit_results::height(state).min(right.height / 3)),
        Constraint::Fill(1),
        Constraint::Length(if room == Room::Small { 0 } else { strip_rows }),
    ])
    .areas(right);
    contact_numbers::render(state, numbers, buf);
    fit_results::render(state, fit, buf);
    friction_curve::render(state, friction, buf);
    strips::render(state, Strip::Amplitude, amplitude, buf);
}
