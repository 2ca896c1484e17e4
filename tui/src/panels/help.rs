//! The help: what each key does.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Widget};

use super::panel::rows;
use crate::state::State;

const KEYS: [(&str, &str); 21] = [
    ("e", "stop the drive at once, without confirmation"),
    ("space", "start; participant is ready; end a rest"),
    ("c", "record the participant's consent"),
    ("p", "pause, resume"),
    ("r", "repeat the current trial"),
    ("a", "abort the session"),
    ("x", "re-arm after a trip"),
    ("t n", "take the proposed carrier; keep the present one"),
    ("1 … 5", "Run, Impedance, Trials, Bench, Log"),
    ("tab", "participant's screen, and back"),
    ("z", "enlarge the next panel; after the last the page"),
    ("f", "hold the strips, with two cursors; go on"),
    ("← →", "previous or next trial; first cursor"),
    ("⇧← ⇧→", "second cursor"),
    ("j k ↕", "scroll, as the mouse's wheel does"),
    ("+ -", "shorter or longer time span of the strips"),
    ("w", "write the page as SVG and text files"),
    ("Ctrl-L", "draw the screen anew"),
    ("q", "quit"),
    ("Ctrl-C", "orderly stop, then quit"),
    ("esc", "dismiss a question or this help"),
];

const DRILL_KEYS: [(&str, &str); 8] = [
    ("e", "stop the drive at once, without confirmation"),
    ("space", "you have seen the fault"),
    ("x", "re-arm after a trip"),
    ("p", "pause, resume"),
    ("r", "repeat the current trial"),
    ("q", "end the program; leaves the drill if not asked for"),
    ("Ctrl-C", "leave the drill"),
    ("esc", "dismiss a question or this help"),
];

const CALIBRATION_KEYS: [(&str, &str); 8] = [
    ("e", "stop the drive at once, without confirmation"),
    ("enter", "confirm the step, the number or the points"),
    ("0–9 .", "type the requested number"),
    ("bksp", "delete the last character"),
    ("↑ ↓", "select a point"),
    ("r", "remeasure the selected point, remove a mass"),
    ("q", "quit; nothing is written"),
    ("Ctrl-C", "orderly stop, then quit"),
];

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let keys: &[(&str, &str)] = if state.drill.is_some() {
        &DRILL_KEYS
    } else if state.calibration.is_some() {
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
