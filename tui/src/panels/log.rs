//! The last lines of the log.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::panel::{rows, titled};
use crate::event::LogLevel;
use crate::state::{LogLine, State};

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let title = Line::styled("log", state.ui.theme.strong());
    let body = titled(state, title, &[], area, buf);
    let first = state.log.len().saturating_sub(body.height.into());
    let lines = state.log.iter().skip(first).map(|line| entry(state, line));
    rows(lines.collect(), body, buf);
}

/// Returns one line with its symbol and count.
pub(crate) fn entry<'a>(state: &State, line: &'a LogLine) -> Line<'a> {
    let theme = state.ui.theme;
    let (symbol, style) = match line.level {
        LogLevel::Info => ("  ", Style::new()),
        LogLevel::Warning => ("! ", theme.warning()),
        LogLevel::Error => ("✗ ", theme.bad()),
    };
    let mut spans = vec![
        Span::styled(symbol, style),
        Span::styled(line.text.as_str(), style),
    ];
    if line.count > 1 {
        spans.push(Span::styled(format!("  ×{}", line.count), theme.faint()));
    }
    Line::from(spans)
}
