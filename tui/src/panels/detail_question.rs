//! The question about the participant, in place of the phase.

use ratatui::text::Line;

use crate::event::AskedDetail;
use crate::state::State;
use drawing::words::wrap;
use escaping::escaped_line;

/// Returns the lines of the question and the typed text, broken at `columns`.
pub(crate) fn question<'a>(state: &State, detail: &AskedDetail, columns: u16) -> Vec<Line<'a>> {
    let theme = state.ui.theme;
    let mut words = escaped_line(&detail.question).into_owned();
    for (number, choice) in (1..).zip(&detail.choices) {
        let separator = if number == 1 { " (" } else { ", " };
        words += &format!("{separator}{number} {}", escaped_line(choice));
    }
    if !detail.choices.is_empty() {
        words.push(')');
    }
    let typed = &state.ui.typed;
    words += &format!(": {typed}_");
    let remark = detail.note.as_deref().map(escaped_line).unwrap_or_default();
    let words = wrap(&words, columns).into_iter();
    let remark = wrap(&remark, columns).into_iter();
    words
        .map(|line| Line::styled(line, theme.driving()))
        .chain(remark.map(|line| Line::styled(line, theme.warning())))
        .collect()
}
