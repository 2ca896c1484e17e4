//! Layouts of the operator's screen.

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::Line;

use crate::page::Page;
use crate::pages::{self, Room};
use crate::panels::panel::{note, rows};
use crate::panels::{
    bench_tables, calibration_layout, detail_question, drill, help, key_hints, log, new_carrier,
    readings, safety_line, session_phase, stage, strips, summary, tabs,
};
use crate::participant_screen;
use crate::state::State;
use crate::strip::Strip;
use drawing::escape::clean;
use drawing::plain_signs::plain_signs;

/// Minimum columns and rows for two columns of panels; a smaller screen shows a list.
pub const TWO_COLUMNS: (u16, u16) = (78, 22);

/// Draws the operator's screen, a pure function of `state`.
///
/// The first row always shows the safety state, at any size with at least one row.
///
/// ```
/// use ratatui::{Terminal, backend::TestBackend};
/// use tui::{State, Theme, view};
///
/// let state = State::new(Theme::Mono);
/// let mut terminal = Terminal::new(TestBackend::new(40, 10))?;
/// terminal.draw(|frame| view(&state, frame))?;
/// let first: String = (0..40).map(|x| terminal.backend().buffer()[(x, 0)].symbol()).collect();
/// assert_eq!(first.trim(), "UNKNOWN");
/// # Ok::<(), std::convert::Infallible>(())
/// ```
pub fn view(state: &State, frame: &mut Frame) {
    let area = frame.area();
    draw(state, area, frame.buffer_mut());
    clean(frame.buffer_mut());
    if state.ui.ascii {
        plain_signs(frame.buffer_mut());
    }
}

/// Draws the screen into `area`.
fn draw(state: &State, area: Rect, buf: &mut Buffer) {
    let [top, rest] = Layout::vertical([Constraint::Length(1), Constraint::Fill(1)]).areas(area);
    safety_line::render(state, top, buf);
    if rest.is_empty() {
        return;
    }
    let keys_rows = u16::from(rest.height >= 3 || state.ui.confirm.is_some());
    let [body, bottom] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(keys_rows)]).areas(rest);
    key_hints::render(state, bottom, buf);
    match (state.ui.page, state.shown_calibration()) {
        (_, Some(calibrated)) => calibration_layout::render(state, calibrated, body, buf),
        (Page::Participant, _) if state.asked.is_none() && state.new_carrier.is_none() => {
            preview(state, body, buf);
        }
        _ if area.width >= TWO_COLUMNS.0 && area.height >= TWO_COLUMNS.1 => {
            page(state, area, body, buf);
        }
        (Page::Log, _) if state.calibration.is_none() => log::page(state, body, buf),
        _ if state.calibration.is_some() => log_or_health(state, body, buf),
        _ => list(state, body, buf),
    }
    if state.ui.help {
        help::render(state, body, buf);
    }
}

/// Draws a preview of the participant's screen.
fn preview(state: &State, body: Rect, buf: &mut Buffer) {
    match &state.participant {
        Some(participant) => participant_screen::view(participant, state.ui.theme, body, buf),
        None => {
            let style = state.ui.theme.faint();
            note("nothing is shown to the participant yet", style, body, buf);
        }
    }
}

/// Draws the selected page: its tabs, the session's progress and its panels.
fn page(state: &State, area: Rect, body: Rect, buf: &mut Buffer) {
    let room = Room::from_size(area.width, area.height);
    let air = u16::from(room != Room::Small);
    let min_rows = match room {
        Room::Small => stage::ROWS.0,
        Room::Medium | Room::Large => stage::ROWS.1,
    };
    // The progress is shown only with a participant.
    let has_stage = state.session.protocol.is_some() || state.outlook.is_some();
    let stage_rows = match phase_substitute(state, body.width) {
        Some(lines) => u16::try_from(lines.len())
            .unwrap_or(min_rows)
            .clamp(1, min_rows.max(3)),
        None if has_stage => min_rows,
        None => 1,
    };
    let [head, stand, _, panels] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(stage_rows),
        Constraint::Length(air),
        Constraint::Fill(1),
    ])
    .areas(body);
    tabs::render(state, head, buf);
    match phase_substitute(state, stand.width) {
        Some(lines) => rows(lines, stand, buf),
        None => stage::render(state, stand, buf),
    }
    let zoom = state.ui.zoom;
    match state.ui.page {
        Page::Run if zoom > 0 => pages::run::enlarge(state, zoom, panels, buf),
        Page::Impedance if zoom > 0 => pages::impedance::enlarge(state, zoom, panels, buf),
        Page::Trials if zoom > 0 => crate::panels::trial_crop::render(state, panels, buf),
        Page::Run | Page::Participant => pages::run::render(state, room, panels, buf),
        Page::Impedance => pages::impedance::render(state, room, panels, buf),
        Page::Trials => pages::trials::render(state, room, panels, buf),
        Page::Bench => pages::bench::render(state, room, panels, buf),
        Page::Log => log_page(state, panels, buf),
    }
}

/// Draws the log, and the summary of a finished session.
fn log_page(state: &State, area: Rect, buf: &mut Buffer) {
    let summary = state.summary.as_ref();
    let summary_rows = summary
        .map_or(0, |lines| lines.len() as u16 + 2)
        .min(area.height / 2);
    let [lines, end] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(summary_rows)]).areas(area);
    log::page(state, lines, buf);
    if let Some(summary) = summary {
        summary::render(state, summary, end, buf);
    }
}

/// Returns the height of the phase: one row, or up to `max_rows` for a drill's instruction or a question.
fn phase_rows(state: &State, columns: u16, max_rows: u16) -> u16 {
    let lines = phase_substitute(state, columns).map_or(1, |lines| lines.len());
    u16::try_from(lines)
        .unwrap_or(max_rows)
        .max(1)
        .min(max_rows)
}

/// Draws the phase, or the text shown in its place.
fn phase(state: &State, area: Rect, buf: &mut Buffer) {
    match phase_substitute(state, area.width) {
        Some(lines) => rows(lines, area, buf),
        None => session_phase::render(state, area, buf),
    }
}

/// Returns the text shown in place of the phase: a calibration's or a drill's instruction, a question or a proposal.
fn phase_substitute(state: &State, columns: u16) -> Option<Vec<Line<'_>>> {
    if let Some(calibrated) = &state.calibration {
        return Some(calibration_layout::request(state, calibrated, columns));
    }
    match (&state.drill, &state.asked, &state.new_carrier) {
        (Some(drill), ..) => Some(drill::instruction(state, drill, columns)),
        (None, Some(detail), _) => Some(detail_question::question(state, detail, columns)),
        (None, None, Some(proposal)) => Some(new_carrier::lines(state, proposal, columns)),
        (None, None, None) => None,
    }
}

/// Draws the log or the bench's health below the calibration's request.
fn log_or_health(state: &State, body: Rect, buf: &mut Buffer) {
    let phase_rows = phase_rows(state, body.width, body.height.min(4));
    let [stand, rest] =
        Layout::vertical([Constraint::Length(phase_rows), Constraint::Fill(1)]).areas(body);
    phase(state, stand, buf);
    match state.ui.page {
        Page::Log => log::page(state, rest, buf),
        _ => bench_tables::health(state, rest, buf),
    }
}

/// Draws the dashboard as a list, the most important first, as far as it fits.
fn list(state: &State, body: Rect, buf: &mut Buffer) {
    let phase_rows = phase_rows(state, body.width, body.height.min(4));
    let strip_rows = if body.width >= 30 && body.height > phase_rows + readings::ROWS + 4 {
        body.height - 1 - phase_rows - readings::ROWS
    } else {
        0
    };
    let [stand, values, strip, head] = Layout::vertical([
        Constraint::Length(phase_rows),
        Constraint::Max(readings::ROWS),
        Constraint::Length(strip_rows),
        Constraint::Length(u16::from(body.height > phase_rows + readings::ROWS)),
    ])
    .areas(body);
    phase(state, stand, buf);
    if let Some(lines) = &state.summary {
        let rest = Rect {
            height: body.height - stand.height,
            y: body.y + stand.height,
            ..body
        };
        summary::render(state, lines, rest, buf);
        return;
    }
    readings::render(state, values, buf);
    let index = usize::from(state.ui.zoom.saturating_sub(1));
    let kind = Strip::ALL.get(index).copied().unwrap_or(Strip::Amplitude);
    let kind = if state.ui.zoom == 0 {
        Strip::Impedance
    } else {
        kind
    };
    strips::render(state, kind, strip, buf);
    tabs::render(state, head, buf);
}
