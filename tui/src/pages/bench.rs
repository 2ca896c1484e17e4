//! The page of the bench: calibrations, lines and sources, rates and health, limits.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};

use super::Room;
use crate::panels::bench_tables::{VALUES, calibrations, health, limits, parts};
use crate::state::State;

pub(crate) fn render(state: &State, room: Room, area: Rect, buf: &mut Buffer) {
    let facts = state.bench.as_ref();
    let calibration_rows = facts.map_or(2, |bench| bench.calibrations.len());
    let calibration_rows = u16::try_from(calibration_rows)
        .unwrap_or(u16::MAX)
        .saturating_add(1);
    if room == Room::Small {
        let [top, bottom] =
            Layout::vertical([Constraint::Length(calibration_rows), Constraint::Fill(1)])
                .areas(area);
        calibrations(state, top, buf);
        let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Fill(1)])
            .spacing(Spacing::Space(2))
            .areas(bottom);
        health(state, left, buf);
        let [lines, loose] =
            Layout::vertical([Constraint::Fill(3), Constraint::Fill(2)]).areas(right);
        parts(state, lines, buf);
        limits(state, loose, buf);
        return;
    }
    let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Fill(1)])
        .spacing(Spacing::Space(3))
        .areas(area);
    let [dated, loose] = Layout::vertical([
        Constraint::Length(calibration_rows + 1),
        Constraint::Fill(1),
    ])
    .areas(left);
    calibrations(state, dated, buf);
    limits(state, loose, buf);
    let rows = if right.width >= 76 {
        VALUES.div_ceil(2)
    } else {
        VALUES
    };
    let [well, lines] =
        Layout::vertical([Constraint::Length(rows + 2), Constraint::Fill(1)]).areas(right);
    health(state, well, buf);
    parts(state, lines, buf);
}
