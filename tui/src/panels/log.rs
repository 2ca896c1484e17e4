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
    let newest = state.log.iter().skip(first);
    let lines = newest.flat_map(|line| wrap_entry(state, line, body.width));
    rows(newest_rows(lines.collect(), body.height), body, buf);
}

/// Draws the whole log, scrolled up from the newest line.
pub(crate) fn page(state: &State, area: Rect, buf: &mut Buffer) {
    let title = Line::styled("log", state.ui.theme.strong());
    let row_count = usize::from(area.height.saturating_sub(1));
    let max_first = state.log.len().saturating_sub(row_count);
    let first = max_first.saturating_sub(state.ui.scroll.into());
    let newer = max_first - first;
    let count = match newer {
        0 => format!("{} lines", state.log.len()),
        _ => format!("{newer} newer lines below: j"),
    };
    let count = Line::styled(count, state.ui.theme.faint());
    let body = titled(state, title, &[count], area, buf);
    let mut lines = Vec::new();
    for line in state.log.iter().skip(first).take(row_count) {
        lines.extend(wrap_entry(state, line, body.width));
    }
    rows(newest_rows(lines, body.height), body, buf);
}

/// Returns the last `count` rows: wrapped lines push out the oldest ones.
fn newest_rows(mut lines: Vec<Line>, count: u16) -> Vec<Line> {
    let excess = lines.len().saturating_sub(count.into());
    lines.split_off(excess)
}

/// Returns a line broken at `columns`, with its symbol before the first part.
fn wrap_entry<'a>(state: &State, line: &'a LogLine, columns: u16) -> Vec<Line<'a>> {
    let single = entry(state, line);
    if single.width() <= columns.into() {
        return vec![single];
    }
    let style = single.spans.first().map_or(Style::new(), |span| span.style);
    let symbol = single
        .spans
        .first()
        .map_or("  ".to_owned(), |span| span.content.to_string());
    let count = if line.count > 1 {
        format!("{} ×{}", line.text, line.count)
    } else {
        line.text.clone()
    };
    let parts = drawing::words::wrap(&count, columns.saturating_sub(2)).into_iter();
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
