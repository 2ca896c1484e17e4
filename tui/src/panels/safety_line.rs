//! The safety line: the first row of every screen.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use crate::event::{PhaseKind, SafetyView};
use crate::state::State;
use drawing::words::render_line;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let row = Rect {
        height: area.height.min(1),
        ..area
    };
    if row.is_empty() {
        return;
    }
    let theme = state.ui.theme;
    let is_ready = state.phase.kind == PhaseKind::Paused && state.phase.stopped;
    let (word, style) = match state.safety {
        None => ("UNKNOWN", theme.warning()),
        Some(SafetyView::Disarmed) if is_ready => ("READY", theme.strong()),
        Some(SafetyView::Disarmed) => ("DISARMED", theme.strong()),
        Some(SafetyView::Armed) => ("ARMED", theme.warning()),
        Some(SafetyView::Driving) => ("DRIVING", theme.driving()),
        Some(SafetyView::Tripped) => ("TRIPPED", theme.alarm()),
    };
    let mut spans = vec![Span::styled(format!(" {word} "), style)];
    let faint = theme.faint();
    let flags = flags(state);
    let flags_columns = u16::try_from(flags.width()).unwrap_or(u16::MAX);
    // A line too long for the row is cut off at its end.
    if let Some(silent_s) = state.silent_s() {
        spans.push(Span::styled(
            format!(" no data from the bench for {silent_s:.0} s"),
            theme.bad(),
        ));
    } else if let Some(reason) = &state.safety_reason {
        let is_tripped = state.safety == Some(SafetyView::Tripped);
        let style = if is_tripped { theme.bad() } else { faint };
        let words = Span::styled(format!(" {reason}"), style);
        // Text other than an alarm gives way to the flags.
        let columns = spans[0].width() + words.width() + 2 + usize::from(flags_columns);
        if is_tripped || columns <= usize::from(row.width) {
            spans.push(words);
        }
    }
    let has_ended = state.phase.kind == PhaseKind::Finished;
    if state.safety == Some(SafetyView::Tripped) && state.calibration.is_none() && !has_ended {
        let remedy = match state.is_device_lost() {
            true => " · q to end",
            false => " · x to re-arm",
        };
        spans.push(Span::styled(remedy, faint));
    }
    let line = Line::from(spans);
    let line_columns = u16::try_from(line.width()).unwrap_or(u16::MAX);
    render_line(line, row, buf);
    if line_columns.saturating_add(2).saturating_add(flags_columns) <= row.width {
        let end = Rect {
            x: row.right() - flags_columns,
            width: flags_columns,
            ..row
        };
        flags.render(end, buf);
    }
    if state.safety == Some(SafetyView::Tripped) {
        // Visible across the room.
        buf.set_style(row, Style::reset().patch(theme.alarm()));
    }
}

/// Returns the marks at the right end: simulated, uncalibrated.
fn flags(state: &State) -> Line<'static> {
    let theme = state.ui.theme;
    let mut spans = Vec::new();
    if state.display_lost.is_some() {
        spans.push(Span::styled(" PARTICIPANT'S DISPLAY LOST ", theme.alarm()));
        spans.push(Span::raw("  "));
    }
    if state.session.simulated {
        spans.push(Span::styled("simulated", theme.faint()));
    }
    if state.session.uncalibrated {
        if !spans.is_empty() {
            spans.push(Span::raw("  "));
        }
        spans.push(Span::styled("UNCALIBRATED", theme.warning()));
    }
    Line::from(spans)
}
