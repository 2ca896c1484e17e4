//! What a key does: a pure function of the state and the key.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::action::Action;
use crate::calibration_keys;
use crate::event::{PhaseKind, SafetyState};
use crate::state::{Page, State, Ui};

/// What a key does: the view settings after it, and at most one action.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// The view settings from now on.
    pub ui: Ui,
    /// What to ask of the bench.
    pub action: Option<Action>,
}

/// What `key` does in `state`.
///
/// `e` stops the drive and Ctrl-C ends the session from anywhere, also from a question or the help. Escape only
/// closes what lies on top: it is pressed by habit, and a habit must neither cost a trial nor look like a stop.
#[must_use]
pub fn key(state: &State, key: KeyEvent) -> Reaction {
    let mut ui = state.ui.clone();
    if key.kind == KeyEventKind::Release {
        return Reaction { ui, action: None };
    }
    ui.note = None;
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    if control || key.modifiers.contains(KeyModifiers::ALT) {
        let interrupt = control && key.code == KeyCode::Char('c');
        return Reaction {
            ui,
            action: interrupt.then_some(Action::Interrupt),
        };
    }
    let code = match key.code {
        KeyCode::Char(c) => KeyCode::Char(c.to_ascii_lowercase()),
        other => other,
    };
    if code == KeyCode::Char('e') {
        ui.confirm = None;
        return Reaction {
            ui,
            action: Some(Action::EmergencyStop),
        };
    }
    // A held key must not answer the question that it raised, nor toggle pause.
    if key.kind == KeyEventKind::Repeat {
        return Reaction { ui, action: None };
    }
    let action = if let Some(asked) = ui.confirm {
        answer(&mut ui, asked, code)
    } else if ui.help {
        ui.help = false;
        None
    } else if let Some(calibration) = &state.calibration {
        calibration_keys::key(state, calibration, &mut ui, code)
    } else {
        command(state, &mut ui, code)
    };
    Reaction { ui, action }
}

fn answer(ui: &mut Ui, asked: Action, code: KeyCode) -> Option<Action> {
    match code {
        KeyCode::Char('y') => {
            ui.confirm = None;
            Some(asked)
        }
        KeyCode::Char('n') | KeyCode::Esc => {
            ui.confirm = None;
            None
        }
        _ => None,
    }
}

fn command(state: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    match code {
        KeyCode::Char('?' | 'h') => ui.help = true,
        KeyCode::Tab => {
            ui.page = match ui.page {
                Page::Dashboard => Page::Participant,
                Page::Participant => Page::Dashboard,
            }
        }
        KeyCode::Char('+' | '=') => ui.window = ui.window.narrower(),
        KeyCode::Char('-') => ui.window = ui.window.wider(),
        KeyCode::Char(letter) => match letter_effect(state, letter) {
            KeyEffect::Do(action) => return Some(action),
            KeyEffect::Ask(action) => ui.confirm = Some(action),
            KeyEffect::Explain(note) => ui.note = Some(note.to_owned()),
            KeyEffect::Nothing => {}
        },
        _ => {}
    }
    None
}

/// What a letter asks for, given where the session stands.
pub(crate) enum KeyEffect {
    Do(Action),
    Ask(Action),
    Explain(&'static str),
    Nothing,
}

pub(crate) fn letter_effect(state: &State, letter: char) -> KeyEffect {
    let kind = state.phase.kind;
    let tripped = state.safety == Some(SafetyState::Tripped);
    match letter {
        ' ' | 's' => match kind {
            _ if tripped => KeyEffect::Explain("tripped: remove the cause, then re-arm with x"),
            PhaseKind::Idle => KeyEffect::Do(Action::Start),
            PhaseKind::Ready | PhaseKind::Rest => KeyEffect::Do(Action::Ready),
            PhaseKind::Consent => KeyEffect::Explain("consent comes first: c"),
            PhaseKind::Paused => KeyEffect::Explain("paused: resume with p"),
            PhaseKind::Finished => KeyEffect::Explain("the session is over"),
            _ => KeyEffect::Explain("already running"),
        },
        'c' => match kind {
            PhaseKind::Consent => KeyEffect::Ask(Action::Consent),
            _ => KeyEffect::Explain("no consent is asked for now"),
        },
        'p' => match kind {
            PhaseKind::Paused if tripped => {
                KeyEffect::Explain("tripped: remove the cause, then re-arm with x")
            }
            PhaseKind::Paused => KeyEffect::Do(Action::Resume),
            PhaseKind::Idle | PhaseKind::Consent | PhaseKind::Finished => {
                KeyEffect::Explain("nothing runs that could be paused")
            }
            _ => KeyEffect::Do(Action::Pause),
        },
        'r' if state.phase.trial > 0 && state.is_running() => KeyEffect::Ask(Action::Redo),
        'r' => KeyEffect::Explain("no trial to do again"),
        'a' if state.in_session() => KeyEffect::Ask(Action::Abort),
        'a' => KeyEffect::Explain("no session to abort"),
        'x' if tripped => KeyEffect::Ask(Action::Rearm),
        'x' => KeyEffect::Explain("not tripped: nothing to re-arm"),
        'q' if state.is_running() => KeyEffect::Ask(Action::Quit),
        'q' => KeyEffect::Do(Action::Quit),
        _ => KeyEffect::Nothing,
    }
}
