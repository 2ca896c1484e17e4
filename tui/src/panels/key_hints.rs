//! The last row: the question that waits for confirmation, the remark on the last key, or the keys that have an effect.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use crate::action::Action;
use crate::calibration_keys::can_redo;
use crate::calibration_page::{CalibrationPage, Question};
use crate::event::PhaseKind;
use crate::keyboard::{KeyEffect, letter_effect};
use crate::page::Page;
use crate::state::State;
use crate::words::render_line;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    if let Some(asked) = state.ui.confirm {
        let words = question(state, asked);
        let question = Line::styled(format!(" {words}  y yes · n no "), theme.alarm());
        // The keys must not be what is cut.
        let question = if question.width() > area.width.into() {
            Line::styled(format!(" y/n: {words} "), theme.alarm())
        } else {
            question
        };
        render_line(question, area, buf);
        return;
    }
    if let Some(note) = &state.ui.note {
        render_line(Line::styled(note.as_str(), theme.warning()), area, buf);
        return;
    }
    let mut spans = vec![Span::styled("e STOP", theme.bad())];
    let mut columns = 6;
    for (key, does) in hints(state) {
        // A hint that does not fit whole is left out.
        columns += 3 + key.chars().count() + 1 + does.len();
        if columns > area.width.into() {
            break;
        }
        spans.push(Span::raw("   "));
        spans.push(Span::styled(key, theme.strong()));
        spans.push(Span::styled(format!(" {does}"), theme.faint()));
    }
    Line::from(spans).render(area, buf);
}

/// Returns the keys that have an effect now, with their effect in a word.
fn hints(state: &State) -> Vec<(&'static str, &'static str)> {
    if let Some(calibration) = &state.calibration {
        return calibration_hints(state, calibration);
    }
    if state.asked.is_some() {
        return vec![
            ("0–9", "type"),
            ("enter", "confirm; alone: not stated"),
            ("↑", "back"),
            ("a", "abort"),
            ("q", "quit"),
        ];
    }
    let start = match state.phase.kind {
        PhaseKind::Idle => "start",
        _ if state.drill.is_some() => "seen",
        _ => "ready",
    };
    let pause = match state.phase.kind {
        PhaseKind::Paused => "resume",
        _ => "pause",
    };
    let letters = [
        ('t', "t", "new carrier"),
        ('n', "n", "keep carrier"),
        (' ', "space", start),
        ('c', "c", "consent"),
        ('x', "x", "re-arm"),
        ('p', "p", pause),
        ('r', "r", "repeat"),
        ('a', "a", "abort"),
        ('q', "q", "quit"),
    ];
    let live = letters
        .into_iter()
        .filter(|(letter, ..)| {
            matches!(
                letter_effect(state, *letter),
                KeyEffect::Do(_) | KeyEffect::Ask(_)
            )
        })
        .map(|(_, key, does)| (key, does));
    let seen = match (&state.ui.frozen, state.ui.page) {
        (Some(_), Page::Run | Page::Impedance) => vec![("← →", "cursor"), ("f", "go on")],
        (_, Page::Trials) => vec![("← →", "trial"), ("j k", "scroll")],
        (_, Page::Log | Page::Bench) => vec![("j k", "scroll")],
        (_, Page::Participant) => vec![("tab", "dashboard")],
        (None, _) => vec![("f", "hold"), ("z", "enlarge"), ("+ -", "time")],
    };
    [("?", "help")]
        .into_iter()
        .chain(live)
        .chain(seen)
        .collect()
}

/// Returns the keys that have an effect on a calibration's page.
fn calibration_hints(
    state: &State,
    calibration: &CalibrationPage,
) -> Vec<(&'static str, &'static str)> {
    let mut hints = match &calibration.asked {
        Some(Question::Number { .. }) => vec![("0–9", "type"), ("enter", "confirm")],
        Some(Question::Review) => vec![("enter", "accept")],
        Some(Question::Done) => vec![("enter", "done")],
        None => Vec::new(),
    };
    if can_redo(state, calibration) {
        let redo = match calibration.asked {
            Some(Question::Number { optional: true, .. }) => "remove",
            _ => "remeasure",
        };
        hints.extend([("↑ ↓", "point"), ("r", redo)]);
    }
    hints.extend([("q", "quit"), ("?", "help")]);
    hints
}

/// Returns the question that confirms `asked`.
fn question(state: &State, asked: Action) -> &'static str {
    match asked {
        Action::Quit if state.calibration.is_some() => {
            "Quit the calibration? Nothing will be written."
        }
        Action::Consent => "Has the participant given consent?",
        Action::Redo => "Repeat this trial?",
        Action::Abort => "Abort the session?",
        Action::Rearm => "Cause removed, finger off the plate? Re-arm?",
        Action::Quit if !state.in_session() => "Stop and quit?",
        Action::Quit => "Session running. Quit?",
        Action::Start
        | Action::Ready
        | Action::Pause
        | Action::Resume
        | Action::Answer(_)
        | Action::TakeCarrier
        | Action::KeepCarrier
        | Action::EmergencyStop
        | Action::Interrupt => "Confirm?",
    }
}
