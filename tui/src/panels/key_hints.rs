//! The last row: the question that waits for confirmation, the remark on the last key, or the keys with an effect.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use crate::action::Action;
use crate::event::PhaseKind;
use crate::keyboard::active_rows;
use crate::state::State;
use drawing::words::render_line;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    if let Some(action) = state.ui.confirm {
        let words = question(state, action);
        let question = Line::styled(format!(" {words}  y yes · n no "), theme.alarm());
        // The keys must not be cut off.
        let question = if question.width() > area.width.into() {
            Line::styled(format!(" y/n: {words} "), theme.alarm())
        } else {
            question
        };
        render_line(question, area, buf);
        return;
    }
    let stop = (!state.session.replayed).then_some(("e", "STOP"));
    if let Some(note) = &state.ui.note {
        let stop = stop.map(|_| Span::styled("e STOP   ", theme.bad()));
        let note = Span::styled(note.as_str(), theme.warning());
        render_line(Line::from_iter(stop.into_iter().chain([note])), area, buf);
        return;
    }
    let hints = active_rows(state).filter_map(|(row, meaning)| Some((row.label, meaning.hint?)));
    let mut hints: Vec<(&str, &str)> = stop.into_iter().chain(hints).collect();
    let columns = |hints: &[(&str, &str)]| -> usize {
        let widths = hints
            .iter()
            .map(|(key, hint)| key.chars().count() + 4 + hint.len());
        widths.sum::<usize>().saturating_sub(3)
    };
    // Hints that do not fit are left out as a whole; the keys to stop and to leave come last.
    while columns(&hints) > area.width.into() {
        let Some(least) = hints.iter().rposition(|(key, _)| !["e", "q"].contains(key)) else {
            break;
        };
        hints.remove(least);
    }
    let mut spans = Vec::new();
    for (key, hint) in hints {
        if !spans.is_empty() {
            spans.push(Span::raw("   "));
        }
        if (key, hint) == ("e", "STOP") {
            spans.push(Span::styled("e STOP", theme.bad()));
            continue;
        }
        spans.push(Span::styled(key, theme.strong()));
        spans.push(Span::styled(format!(" {hint}"), theme.faint()));
    }
    Line::from(spans).render(area, buf);
}

/// Returns the question that asks for confirmation of `action`.
fn question(state: &State, action: Action) -> String {
    let words = match action {
        Action::Quit if state.calibration.is_some() => {
            "Quit the calibration? Nothing will be written."
        }
        Action::Consent => "Has the participant given consent?",
        Action::Redo(_) if state.drill.is_some() => "Repeat this trial?",
        Action::Redo(name) => return format!("Discard {name}, now running, and repeat it?"),
        Action::PauseNow(name) => return format!("Discard {name}, now running, and pause?"),
        Action::Resume => {
            let Some(lost) = state.display_lost.as_deref() else {
                return "The participant's display is back. Resume?".to_owned();
            };
            let name = lost.split_once(": ").map_or(lost, |(name, _)| name);
            return format!("Show again on the {name} and resume?");
        }
        Action::Abort => "Abort the session?",
        Action::Rearm => "Cause removed, finger off the plate? Re-arm?",
        Action::Quit if state.phase.kind == PhaseKind::Finished => "Everything is saved. Quit?",
        Action::Quit if !state.in_session() => "Stop and quit?",
        Action::Quit => "Session running. Quit?",
        Action::Start
        | Action::Ready
        | Action::Pause
        | Action::AcceptAnyway(_)
        | Action::Answer(_)
        | Action::TakeCarrier
        | Action::KeepCarrier
        | Action::Seek { .. }
        | Action::EmergencyStop
        | Action::Interrupt => "Confirm?",
    };
    words.to_owned()
}
