//! Parts shared by the panels: the title on its rule, rows of lines, a remark in an empty panel.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use crate::state::State;
use drawing::words::{render_line, wrap};

/// Draws a panel's title on a thin rule and returns the area below it. The first line of `right` that fits is drawn.
pub(crate) fn titled(
    state: &State,
    left: Line,
    right: &[Line],
    area: Rect,
    buf: &mut Buffer,
) -> Rect {
    if area.is_empty() {
        return area;
    }
    let faint = state.ui.theme.faint();
    let row = Rect { height: 1, ..area };
    let rule = "─".repeat(row.width.into());
    buf.set_stringn(row.x, row.y, rule, row.width.into(), faint);
    let mut left = left;
    left.push_span(Span::raw(" "));
    let left_columns = left.width();
    blank(row, 0, left_columns, buf);
    // A line's style fills its whole area, so each line gets only its own columns.
    let start = Rect {
        width: u16::try_from(left_columns).map_or(row.width, |w| w.min(row.width)),
        ..row
    };
    left.render(start, buf);
    let right_line = right
        .iter()
        .filter(|line| line.width() > 0)
        .find(|line| left_columns + line.width() + 3 <= row.width.into());
    if let Some(line) = right_line {
        let columns = u16::try_from(line.width() + 1).unwrap_or(row.width);
        let start = row.width - columns;
        blank(row, start, columns.into(), buf);
        let end = Rect {
            x: row.x + start + 1,
            width: columns - 1,
            ..row
        };
        line.render(end, buf);
    }
    Rect {
        y: area.y + 1,
        height: area.height - 1,
        ..area
    }
}

/// Clears `columns` cells of a row.
fn blank(row: Rect, from: u16, columns: usize, buf: &mut Buffer) {
    let to = usize::from(from) + columns;
    for x in (from..row.width).take_while(|x| usize::from(*x) < to) {
        buf[(row.x + x, row.y)].reset();
    }
}

/// Draws a short text in the middle of an empty area.
pub(crate) fn note(words: &str, style: Style, area: Rect, buf: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let mut lines = wrap(words, area.width);
    lines.truncate(area.height.into());
    let height = u16::try_from(lines.len()).unwrap_or(area.height);
    let middle = Rect {
        y: area.y + (area.height - height) / 2,
        height,
        ..area
    };
    for (row, line) in middle.rows().zip(lines) {
        Line::styled(line, style).centered().render(row, buf);
    }
}

/// Draws one line per row, as many as fit.
pub(crate) fn rows(lines: Vec<Line>, area: Rect, buf: &mut Buffer) {
    for (row, line) in area.rows().zip(lines) {
        render_line(line, row, buf);
    }
}
