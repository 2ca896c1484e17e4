//! A drill: the request to the operator, and the results of the exercises so far.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::panel::{note, rows, titled};
use crate::drill_view::{DrillResult, DrillStep, DrillView};
use crate::state::State;
use drawing::words::wrap;
use escaping::escaped_line;

/// Returns the lines of the instruction and its note, broken at `columns`.
pub(crate) fn instruction<'a>(state: &State, drill: &DrillView, columns: u16) -> Vec<Line<'a>> {
    let theme = state.ui.theme;
    let style = match drill.asked {
        DrillStep::Watch => theme.strong(),
        _ => theme.driving(),
    };
    let count = if drill.exercise > 0 {
        format!("{}/{} ", drill.exercise, drill.exercises)
    } else {
        String::new()
    };
    let words = format!("drill {count}· {}", escaped_line(&drill.instruction));
    let remark = drill.note.as_deref().map(escaped_line).unwrap_or_default();
    // A remark is short and concerns the last key: it comes first so that it is not cut off.
    let remarks = wrap(&remark, columns).into_iter();
    let remarks = remarks.map(|line| Line::styled(line, theme.warning()));
    let words = wrap(&words, columns).into_iter();
    remarks
        .chain(words.map(|line| Line::styled(line, style)))
        .collect()
}

/// Draws the finished exercises, the latest at the bottom.
pub(crate) fn render(state: &State, drill: &DrillView, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let met = drill.results.iter().filter(|result| result.met).count();
    let missed_count = drill.results.len() - met;
    let count = Line::raw(match missed_count {
        0 => format!("{met} met"),
        _ => format!("{met} met, {missed_count} missed"),
    });
    let title = Line::styled("drill", theme.strong());
    let body = titled(state, title, &[count], area, buf);
    if drill.results.is_empty() {
        note("no exercise completed yet", theme.faint(), body, buf);
        return;
    }
    let first = drill.results.len().saturating_sub(body.height.into());
    let lines = drill.results[first..].iter();
    rows(
        lines.map(|result| entry(state, result)).collect(),
        body,
        buf,
    );
}

fn entry<'a>(state: &State, result: &DrillResult) -> Line<'a> {
    let theme = state.ui.theme;
    let mark = if result.met {
        Span::styled("✓", theme.good())
    } else {
        Span::styled("✗", theme.bad())
    };
    let (fault, words) = (escaped_line(&result.fault), escaped_line(&result.words));
    Line::from(vec![
        mark,
        Span::raw(format!(" {fault}")),
        Span::styled(format!("  {words}"), theme.faint()),
    ])
}
