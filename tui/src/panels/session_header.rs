//! The participant, the protocol, the study and the calibration, in one line.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use crate::state::State;
use crate::words::render_line;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let session = &state.session;
    let mut spans = vec![Span::styled(
        session
            .participant
            .as_deref()
            .unwrap_or("no participant")
            .to_owned(),
        theme.strong(),
    )];
    let also = [
        session.protocol.as_deref(),
        session.study.as_deref(),
        session.calibration_label.as_deref(),
    ];
    for words in also.into_iter().flatten() {
        spans.push(Span::styled(" · ", theme.faint()));
        spans.push(Span::raw(words.to_owned()));
    }
    render_line(Line::from(spans), area, buf);
}
