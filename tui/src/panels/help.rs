//! The keys, explained.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Widget};

use super::panel::rows;
use crate::state::State;

const KEYS: [(&str, &str); 12] = [
    ("e", "stop the drive at once, without a question"),
    ("space", "start; the participant is ready; end a rest"),
    ("c", "record the participant's consent"),
    ("p", "pause and resume"),
    ("r", "do the present trial again"),
    ("a", "abort the session"),
    ("x", "re-arm after a trip"),
    ("tab", "what the participant sees, and back"),
    ("+ -", "shorter or longer strip charts"),
    ("q", "quit"),
    ("Ctrl-C", "stop in good order and leave"),
    ("esc", "close a question or this help"),
];

const CALIBRATION_KEYS: [(&str, &str); 8] = [
    ("e", "stop the drive at once, without a question"),
    ("enter", "it is done; take the number; keep the points"),
    ("0–9 .", "type the number that is asked for"),
    ("bksp", "correct it"),
    ("↑ ↓", "choose a point"),
    ("r", "measure the chosen point again"),
    ("q", "leave; nothing is written"),
    ("Ctrl-C", "stop in good order and leave"),
];

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let keys: &[(&str, &str)] = if state.calibration.is_some() {
        &CALIBRATION_KEYS
    } else {
        &KEYS
    };
    let rows_wanted = u16::try_from(keys.len()).unwrap_or(u16::MAX) + 2;
    let area = area.centered(
        ratatui::layout::Constraint::Max(58),
        ratatui::layout::Constraint::Max(rows_wanted),
    );
    Clear.render(area, buf);
    let block = Block::bordered().title(Line::styled(" keys ", theme.strong()));
    let inner = block.inner(area);
    block.render(area, buf);
    let lines = keys.iter().map(|(key, does)| {
        Line::from(vec![
            Span::styled(format!(" {key:<8}"), theme.strong()),
            Span::raw(*does),
        ])
    });
    rows(lines.collect(), inner, buf);
}
