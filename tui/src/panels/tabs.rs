//! The second row: the pages with their keys, the participant and the protocol.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::calibration_layout;
use crate::page::Page;
use crate::state::State;
use drawing::words::{LinePart, fit_parts, render_line};

const PAGES: [(Page, &str); 5] = [
    (Page::Run, "1 Run"),
    (Page::Impedance, "2 Impedance"),
    (Page::Trials, "3 Trials"),
    (Page::Bench, "4 Bench"),
    (Page::Log, "5 Log"),
];

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    // While a question waits, the run page is shown in place of the participant's screen.
    let current = match state.ui.page {
        Page::Participant => Page::Run,
        page => page,
    };
    let mut spans = Vec::new();
    for (page, name) in PAGES {
        let name = match (page, &state.calibration) {
            (Page::Run, Some(_)) => "1 Calibration",
            (Page::Impedance | Page::Trials, Some(_)) => continue,
            _ => name,
        };
        let style = if page == current {
            theme.selection()
        } else {
            theme.faint()
        };
        spans.push(Span::styled(format!(" {name} "), style));
    }
    let pages = Line::from(spans);
    let room = usize::from(area.width).saturating_sub(pages.width() + 2);
    let subject = match &state.calibration {
        Some(calibration) => calibration_layout::title(state, calibration),
        None => participant(state, room),
    };
    render_line(pages, area, buf);
    if room < 8 {
        return;
    }
    // Text that does not fit is cut off at its end; text that fits is aligned to the right.
    let columns = u16::try_from(subject.width().min(room)).unwrap_or(0);
    let end = Rect {
        x: area.right() - columns,
        width: columns,
        ..area
    };
    render_line(subject, end, buf);
}

/// Returns the participant, the protocol and further details, as far as they fit into `columns`.
fn participant(state: &State, columns: usize) -> Line<'static> {
    let theme = state.ui.theme;
    let session = &state.session;
    let participant = session.participant.as_deref();
    let participant = participant.unwrap_or("no participant");
    let mut parts = vec![LinePart::new(0, participant, theme.strong())];
    let details = [
        session.protocol.as_deref(),
        session.study.as_deref(),
        session.calibration_label.as_deref(),
    ];
    for (rank, words) in (1..)
        .zip(details)
        .filter_map(|(rank, words)| Some((rank, words?)))
    {
        parts.push(LinePart::new(rank, words, Style::new()));
    }
    fit_parts(parts, columns, theme.faint())
}
