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

/// Draws the whole log, scrolled up from the newest line.
pub(crate) fn whole(state: &State, area: Rect, buf: &mut Buffer) {
    let title = Line::styled("log", state.ui.theme.strong());
    let shown = usize::from(area.height.saturating_sub(1));
    let most = state.log.len().saturating_sub(shown);
    let first = most.saturating_sub(state.ui.scroll.into());
    let below = most - first;
    let count = match below {
        0 => format!("{} lines", state.log.len()),
        _ => format!("{below} newer lines below: j"),
    };
    let count = Line::styled(count, state.ui.theme.faint());
    let body = titled(state, title, &[count], area, buf);
    let mut lines = Vec::new();
    for line in state.log.iter().skip(first).take(shown) {
        lines.extend(wrapped(state, line, body.width));
    }
    // Wrapped lines push out the oldest ones.
    let over = lines.len().saturating_sub(body.height.into());
    rows(lines.split_off(over), body, buf);
}

/// Returns a line broken at `columns`, with its symbol before the first part.
fn wrapped<'a>(state: &State, line: &'a LogLine, columns: u16) -> Vec<Line<'a>> {
    let whole = entry(state, line);
    if whole.width() <= columns.into() {
        return vec![whole];
    }
    let style = whole.spans.first().map_or(Style::new(), |span| span.style);
    let symbol = whole
        .spans
        .first()
        .map_or("  ".to_owned(), |span| span.content.to_string());
    let count = if line.count > 1 {
        format!("{} ×{}", line.text, line.count)
    } else {
        line.text.clone()
    };
    let parts = crate::words::wrap(&count, columns.saturating_sub(2)).into_iter();
    let parts = parts.enumerate().map(|(i, part)| {
        let head = if i == 0 {
            symbol.clone()
        } else {
            "  ".to_owned()
        };
        Line::from(vec![Span::styled(head, style), Span::styled(part, style)])
    });
    parts.collect()
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
