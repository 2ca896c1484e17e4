//! Layout of a calibration's page: one instruction, the main reading, the points so far.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};
use ratatui::text::{Line, Span};

use super::live_values::stale;
use super::panel::rows;
use super::{calibration_points, calibration_values};
use crate::calibration_page::{CalibrationPage, Question};
use crate::event::SafetyView;
use crate::state::State;
use drawing::digits;
use drawing::words::{render_line, wrap};

/// Minimum width for the points and their chart side by side.
const TWO_COLUMNS: u16 = 60;
/// Minimum rows for the points below the large digits.
const LEAST_POINTS: u16 = 4;

pub(crate) fn render(state: &State, calibration: &CalibrationPage, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let (columns, air) = if area.height >= 33 {
        (area.width, 1)
    } else {
        (area.width, 0)
    };
    let words = wrap(&calibration.instruction, columns);
    let words_rows = words.len() as u16;
    let remarks = wrap(calibration.note.as_deref().unwrap_or_default(), columns);
    let remarks_rows = remarks.len() as u16;
    let typing = u16::from(calibration.asked.is_some());
    let text_rows = 1 + 2 * air + words_rows + remarks_rows + typing;
    // The results under review need the room of the digits.
    let is_review = calibration.asked == Some(Question::Review);
    let large = !is_review && area.height >= text_rows + digits::ROWS + 1 + LEAST_POINTS;
    let reading_rows = if large { digits::ROWS + 1 } else { 1 };
    let [head, _, instruction, remark, answer, _, reading, rest] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(air),
        Constraint::Length(words_rows),
        Constraint::Length(remarks_rows),
        Constraint::Length(typing),
        Constraint::Length(air),
        Constraint::Length(reading_rows),
        Constraint::Fill(1),
    ])
    .areas(area);
    let mut line = title(state, calibration);
    if state.live_stale_s().is_some() {
        line.push_span(Span::styled(" · ", theme.faint()));
        let stale = stale(state).spans.into_iter();
        line.extend(stale.map(|span| span.style(theme.warning())));
    }
    render_line(line, head, buf);
    let style = if calibration.failed {
        theme.bad()
    } else {
        theme.strong()
    };
    let lines = words.into_iter().map(|line| Line::styled(line, style));
    rows(lines.collect(), instruction, buf);
    let lines = remarks
        .into_iter()
        .map(|line| Line::styled(line, theme.warning()));
    rows(lines.collect(), remark, buf);
    if !answer.is_empty() {
        render_line(answer_line(state, calibration), answer, buf);
    }
    if large {
        let body = Rect {
            height: digits::ROWS,
            y: reading.y + u16::from(reading.height > digits::ROWS),
            ..reading
        };
        calibration_values::large(state, calibration, body, buf);
    } else {
        calibration_values::small(state, calibration, reading, buf);
    }
    let rest = calibration_points::results(state, calibration, rest, buf);
    let [left, right] = if rest.width >= TWO_COLUMNS && calibration.curve.is_some() {
        Layout::horizontal([Constraint::Fill(6), Constraint::Fill(5)])
            .spacing(Spacing::Space(2))
            .areas(rest)
    } else {
        [rest, Rect::default()]
    };
    calibration_points::list(state, calibration, left, buf);
    calibration_points::chart(state, calibration, right, buf);
}

/// Returns the calibration's name and its step.
pub(crate) fn title(state: &State, calibration: &CalibrationPage) -> Line<'static> {
    let theme = state.ui.theme;
    let mut spans = vec![Span::styled(calibration.title.clone(), theme.strong())];
    if calibration.steps > 0 {
        spans.push(Span::styled(" · ", theme.faint()));
        spans.push(Span::raw(format!(
            "step {} of {}",
            calibration.step, calibration.steps
        )));
    }
    Line::from(spans)
}

/// Returns the calibration's request or activity, for the head of another page.
pub(crate) fn request<'a>(
    state: &State,
    calibration: &CalibrationPage,
    columns: u16,
) -> Vec<Line<'a>> {
    let theme = state.ui.theme;
    let (head, style) = match (calibration.failed, &calibration.asked) {
        (true, _) => (Some("▸ failed: press 1 to return"), theme.bad()),
        (false, Some(_)) => (Some("▸ input needed: press 1 to return"), theme.driving()),
        (false, None) => (None, theme.strong()),
    };
    let words = wrap(&calibration.instruction, columns);
    let head = head.map(str::to_owned).into_iter();
    let lines = head.chain(words).map(|line| Line::styled(line, style));
    lines.collect()
}

/// Returns the line with the typed text, or the key that confirms.
fn answer_line<'a>(state: &'a State, calibration: &'a CalibrationPage) -> Line<'a> {
    let theme = state.ui.theme;
    let spans = match &calibration.asked {
        None => Vec::new(),
        Some(_) if state.safety == Some(SafetyView::Tripped) => {
            let words = match state.is_device_lost() {
                true => " a device is lost: q, y ends the calibration",
                false => " stopped: find the cause, then x re-arms; Enter afterwards",
            };
            vec![Span::styled("▸ ", theme.bad()), Span::raw(words)]
        }
        Some(Question::Done) => vec![
            Span::styled("▸ ", theme.driving()),
            Span::raw(" press Enter when done"),
        ],
        Some(Question::Review) => vec![
            Span::styled("▸ ", theme.driving()),
            Span::raw(if calibration.rejected {
                " not passed: ↑ ↓ select a point, r remeasures it; Enter ends, and asks first"
            } else {
                " Enter accepts the results; ↑ ↓ select a point, r remeasures it"
            }),
        ],
        Some(Question::Number { unit, expected, .. }) => {
            let mut spans = vec![
                Span::styled("▸ ", theme.driving()),
                Span::styled(format!(" {}", state.ui.typed), theme.strong()),
                Span::styled("▏", theme.strong()),
                Span::raw(format!(" {unit}")),
            ];
            if let Some(expected) = expected {
                spans.push(Span::styled(
                    format!("   predicted {expected:.3} {unit}"),
                    theme.faint(),
                ));
            }
            spans
        }
    };
    Line::from(spans)
}
