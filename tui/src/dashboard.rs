//! The layouts of the operator's screen.

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};
use ratatui::text::Line;

use crate::escape::clean;
use crate::panels::impedance::ImpedancePart;
use crate::panels::panel::{note, rows};
use crate::panels::{
    amplitude, asked_detail, calibration_layout, crop, drill, estimates, forces, help, impedance,
    key_hints, log, new_carrier, plate_drawing, readings, safety_line, session_header,
    session_phase, summary, system_health, trials,
};
use crate::participant_screen;
use crate::state::{Page, State};

/// Smallest columns and rows for two columns of panels; a smaller screen shows a list.
pub const TWO_COLUMNS: (u16, u16) = (78, 22);
/// Smallest columns and rows for spaced panels.
const WIDE: (u16, u16) = (120, 35);

/// Draws the operator's screen, a pure function of `state`.
///
/// The first row always shows the safety state, at any size that has a row.
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
    match (state.ui.page, &state.calibration) {
        (_, Some(calibrated)) => calibration_layout::render(state, calibrated, body, buf),
        (Page::Participant, _) if state.asked.is_none() && state.new_carrier.is_none() => {
            preview(state, body, buf);
        }
        _ if area.width >= TWO_COLUMNS.0 && area.height >= TWO_COLUMNS.1 => {
            two_columns(state, area, body, buf);
        }
        _ => list(state, body, buf),
    }
    if state.ui.help {
        help::render(state, body, buf);
    }
}

/// Draws what the participant sees.
fn preview(state: &State, body: Rect, buf: &mut Buffer) {
    match &state.participant {
        Some(shown) => participant_screen::view(shown, state.ui.theme, body, buf),
        None => {
            let style = state.ui.theme.faint();
            note("nothing is shown to the participant yet", style, body, buf);
        }
    }
}

/// Draws the dashboard in two columns of panels.
fn two_columns(state: &State, area: Rect, body: Rect, buf: &mut Buffer) {
    let wide = area.width >= WIDE.0 && area.height >= WIDE.1;
    let phase_rows = phase_rows(state, body.width, 3);
    let [head, stand, estimated, _, body] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(phase_rows),
        Constraint::Length(1),
        Constraint::Length(u16::from(wide)),
        Constraint::Fill(1),
    ])
    .areas(body);
    session_header::render(state, head, buf);
    phase(state, stand, buf);
    estimates::render(state, estimated, buf);
    let (gap, shares) = if wide { (3, (3, 2)) } else { (2, (5, 4)) };
    let [left, right] =
        Layout::horizontal([Constraint::Fill(shares.0), Constraint::Fill(shares.1)])
            .spacing(Spacing::Space(gap))
            .areas(body);

    if let Some(lines) = &state.summary {
        summary::render(state, lines, left, buf);
    } else {
        curves(state, wide, left, buf);
    }
    let (air, log_rows) = if wide {
        (1, Constraint::Fill(2))
    } else {
        (0, Constraint::Length(3))
    };
    let [list, last, machinery, lines] = Layout::vertical([
        Constraint::Fill(3),
        Constraint::Fill(6),
        Constraint::Length(system_health::height(right.width) + air),
        log_rows,
    ])
    .areas(right);
    match &state.drill {
        Some(drilled) => drill::render(state, drilled, list, buf),
        None => trials::render(state, list, buf),
    }
    crop::render(state, last, buf);
    system_health::render(state, machinery, buf);
    log::render(state, lines, buf);
}

/// Returns the rows of the phase: one, or as many of `most` as a drill's instruction or a question takes.
fn phase_rows(state: &State, columns: u16, most: u16) -> u16 {
    let lines = in_place_of_phase(state, columns).map_or(1, |lines| lines.len());
    u16::try_from(lines).unwrap_or(most).max(1).min(most)
}

/// Draws the phase, or what is in its place.
fn phase(state: &State, area: Rect, buf: &mut Buffer) {
    match in_place_of_phase(state, area.width) {
        Some(lines) => rows(lines, area, buf),
        None => session_phase::render(state, area, buf),
    }
}

/// Returns a drill's instruction, a question or a proposal, which are shown in place of the phase.
fn in_place_of_phase(state: &State, columns: u16) -> Option<Vec<Line<'_>>> {
    match (&state.drill, &state.asked, &state.new_carrier) {
        (Some(drilled), ..) => Some(drill::instruction(state, drilled, columns)),
        (None, Some(asked), _) => Some(asked_detail::question(state, asked, columns)),
        (None, None, Some(proposal)) => Some(new_carrier::lines(state, proposal, columns)),
        (None, None, None) => None,
    }
}

/// Draws the left column: strip charts above the plate.
fn curves(state: &State, wide: bool, area: Rect, buf: &mut Buffer) {
    let plate_rows = if wide { 5 } else { 3 };
    let [re, im, vibration, forces, drawing] = Layout::vertical([
        Constraint::Fill(5),
        Constraint::Fill(4),
        Constraint::Fill(4),
        Constraint::Fill(4),
        Constraint::Length(plate_rows),
    ])
    .areas(area);
    impedance::render(state, ImpedancePart::Re, re, buf);
    impedance::render(state, ImpedancePart::Im, im, buf);
    amplitude::render(state, vibration, buf);
    forces::render(state, forces, buf);
    plate_drawing::render(state, drawing, buf);
}

/// Draws the dashboard as a list, the most important first; what does not fit is left out.
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
    impedance::render(state, ImpedancePart::Re, strip, buf);
    session_header::render(state, head, buf);
}
