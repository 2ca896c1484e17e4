//! The help: the keys that work on the current page.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Widget};

use super::panel::rows;
use crate::keyboard::active_rows;
use crate::state::State;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let keys: Vec<(&str, &str)> = active_rows(state)
        .map(|(row, meaning)| (row.label, meaning.help))
        .chain([("esc", "dismiss a question or this help")])
        .collect();
    let row_count = u16::try_from(keys.len()).unwrap_or(u16::MAX) + 2;
    let area = area.centered(
        ratatui::layout::Constraint::Max(58),
        ratatui::layout::Constraint::Max(row_count),
    );
    Clear.render(area, buf);
    let block = Block::bordered().title(Line::styled(" keys ", theme.strong()));
    let inner = block.inner(area);
    block.render(area, buf);
    let lines = keys.into_iter().map(|(key, help)| {
        Line::from(vec![
            Span::styled(format!(" {key:<8}"), theme.strong()),
            Span::raw(help),
        ])
    });
    rows(lines.collect(), inner, buf);
}
