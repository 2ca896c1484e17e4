//! The page of the experiment at a glance.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};

use super::Room;
use crate::panels::{
    bench_tables, complex_plane, contact_numbers, drill, friction_curve, log, plate_drawing,
    strips, summary, trial_crop, trial_list,
};
use crate::state::State;
use crate::strip::Strip;

/// Draws one panel enlarged, numbered from 1.
pub(crate) fn enlarge(state: &State, panel: u8, area: Rect, buf: &mut Buffer) {
    match Strip::ALL.get(usize::from(panel.saturating_sub(1))) {
        Some(strip) => strips::render(state, *strip, area, buf),
        None if panel == 6 => plate_drawing::render(state, area, buf),
        None => trial_crop::render(state, area, buf),
    }
}

pub(crate) fn render(state: &State, room: Room, area: Rect, buf: &mut Buffer) {
    match room {
        Room::Small => small(state, area, buf),
        Room::Medium => medium(state, area, buf),
        Room::Large => large(state, area, buf),
    }
}

fn columns<const N: usize>(area: Rect, gap: u16, shares: [u16; N]) -> [Rect; N] {
    Layout::horizontal(shares.map(Constraint::Fill))
        .spacing(Spacing::Space(gap))
        .areas(area)
}

/// Draws the strips, or the summary of a finished session.
fn curves(state: &State, plate_rows: u16, area: Rect, buf: &mut Buffer) {
    if let Some(lines) = &state.summary {
        summary::render(state, lines, area, buf);
        return;
    }
    let [strips, plate] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(plate_rows)]).areas(area);
    strips::render_all(state, strips, buf);
    plate_drawing::render(state, plate, buf);
}

/// Draws the trials, or a drill's exercises.
fn list(state: &State, area: Rect, buf: &mut Buffer) {
    match &state.drill {
        Some(drill) => drill::render(state, drill, area, buf),
        None => trial_list::render(state, false, area, buf),
    }
}

fn small(state: &State, area: Rect, buf: &mut Buffer) {
    let [left, right] = columns(area, 2, [17, 10]);
    curves(state, 3, left, buf);
    if is_contact_only(state) {
        contact(state, right, buf);
        return;
    }
    let [trials, lines, health] = Layout::vertical([
        Constraint::Fill(3),
        Constraint::Fill(2),
        Constraint::Length(1),
    ])
    .areas(right);
    list(state, trials, buf);
    log::render(state, lines, buf);
    bench_tables::one_line(state, health, buf);
}

/// Whether there is neither a participant nor a trial to show.
fn is_contact_only(state: &State) -> bool {
    state.session.protocol.is_none() && state.trials.is_empty() && state.drill.is_none()
}

/// Draws the contact in place of the list of trials, which is empty.
fn contact(state: &State, area: Rect, buf: &mut Buffer) {
    let [numbers, plane, lines, health] = Layout::vertical([
        Constraint::Length(contact_numbers::ROWS + 1),
        Constraint::Fill(2),
        Constraint::Fill(1),
        Constraint::Length(1),
    ])
    .areas(area);
    contact_numbers::render(state, numbers, buf);
    complex_plane::render(state, plane, buf);
    log::render(state, lines, buf);
    bench_tables::one_line(state, health, buf);
}

fn medium(state: &State, area: Rect, buf: &mut Buffer) {
    let [left, right] = columns(area, 3, [4, 3]);
    curves(state, 4, left, buf);
    if is_contact_only(state) {
        contact(state, right, buf);
        return;
    }
    let [trials, crop, lines, health] = Layout::vertical([
        Constraint::Fill(5),
        Constraint::Fill(8),
        Constraint::Fill(4),
        Constraint::Length(1),
    ])
    .areas(right);
    list(state, trials, buf);
    newest(state, crop, buf);
    log::render(state, lines, buf);
    bench_tables::one_line(state, health, buf);
}

fn large(state: &State, area: Rect, buf: &mut Buffer) {
    let [left, right] = columns(area, 3, [5, 4]);
    curves(state, 5, left, buf);
    if is_contact_only(state) {
        contact(state, right, buf);
        return;
    }
    let [upper, crop, lines, health] = Layout::vertical([
        Constraint::Fill(5),
        Constraint::Fill(7),
        Constraint::Fill(3),
        Constraint::Length(1),
    ])
    .areas(right);
    let [trials, contact] = columns(upper, 2, [4, 3]);
    list(state, trials, buf);
    let [plane, friction] =
        Layout::vertical([Constraint::Fill(1), Constraint::Fill(1)]).areas(contact);
    complex_plane::render(state, plane, buf);
    friction_curve::render(state, friction, buf);
    newest(state, crop, buf);
    log::render(state, lines, buf);
    bench_tables::one_line(state, health, buf);
}

/// Draws the newest crop, and the trial's other crops if there is room.
fn newest(state: &State, area: Rect, buf: &mut Buffer) {
    match state.crops.back() {
        Some(crop) => trial_crop::exploration(state, crop, area, buf),
        None => trial_crop::render(state, area, buf),
    }
}
