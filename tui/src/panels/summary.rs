//! The summary of a finished session.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;

use super::panel::{rows, titled};
use crate::state::State;
use drawing::words::wrap;

pub(crate) fn render(state: &State, summary: &[String], area: Rect, buf: &mut Buffer) {
    let title = Line::styled(
        if state.drill.is_some() {
            "drill finished"
        } else {
            "session finished"
        },
        state.ui.theme.strong(),
    );
    let body = titled(state, title, &[], area, buf);
    let lines = summary
        .iter()
        .flat_map(|line| wrap(line, body.width))
        .map(Line::from);
    rows(lines.collect(), body, buf);
}
