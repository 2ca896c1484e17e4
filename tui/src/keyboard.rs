//! The effect of a key: a pure function of the state and the key.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::action::Action;
use crate::asked_keys;
use crate::calibration_keys;
use crate::event::{PhaseKind, SafetyState};
use crate::state::{State, Ui};
use crate::view_keys;

/// The effect of a key: the view settings after it, and at most one action.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// View settings after the key.
    pub ui: Ui,
    /// Request to the bench.
    pub action: Option<Action>,
}

/// Returns the effect of `key` in `state`.
///
/// `e` stops the drive and Ctrl-C ends the session from anywhere, also from a question or the help. Escape only
/// dismisses a question or the help: it is pressed by habit, and must neither cost a trial nor look like a stop.
///
/// ```
/// use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
/// use tui::{Action, State, Theme, key};
///
/// let mut state = State::new(Theme::Mono);
/// let press = |code| KeyEvent::new(KeyCode::Char(code), KeyModifiers::NONE);
/// assert_eq!(key(&state, press('e')).action, Some(Action::EmergencyStop));
///
/// // No session runs: a remark on the last row says that there is nothing to pause.
/// let reaction = key(&state, press('p'));
/// assert_eq!(reaction.action, None);
/// assert!(reaction.ui.note.is_some());
/// state.ui = reaction.ui;
/// ```
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
    // A key held down must neither answer the question that it raised nor toggle pause.
    if key.kind == KeyEventKind::Repeat {
        return Reaction { ui, action: None };
    }
    let other = key.modifiers.contains(KeyModifiers::SHIFT);
    let action = if let Some(asked) = ui.confirm {
        answer(&mut ui, asked, code)
    } else if ui.help {
        ui.help = false;
        None
    } else if let Some(calibration) = &state.calibration {
        calibration_keys::key(state, calibration, &mut ui, code)
    } else if state.asked.is_some() {
        asked_keys::key(&mut ui, code).unwrap_or_else(|| seen_or_command(state, &mut ui, code, other))
    } else {
        seen_or_command(state, &mut ui, code, other)
    };
    Reaction { ui, action }
}

/// Answers the question whether `asked` is confirmed.
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

/// Applies a key that changes what is seen, or one of the dashboard.
fn seen_or_command(state: &State, ui: &mut Ui, code: KeyCode, other: bool) -> Option<Action> {
    if view_keys::key(state, ui, code, other) {
        return None;
    }
    command(state, ui, code)
}

/// Applies a key of the dashboard.
fn command(state: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    match code {
        KeyCode::Char('?' | 'h') => ui.help = true,
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

/// The effect of a letter in the current phase.
pub(crate) enum KeyEffect {
    /// Requests the action at once.
    Do(Action),
    /// Requests the action after confirmation.
    Ask(Action),
    /// Tells why the letter has no effect.
    Explain(&'static str),
    /// The letter has no meaning.
    Nothing,
}

/// Returns the effect of `letter` in the current phase.
pub(crate) fn letter_effect(state: &State, letter: char) -> KeyEffect {
    let kind = state.phase.kind;
    let tripped = state.safety == Some(SafetyState::Tripped);
    match letter {
        ' ' | 's' if state.drill.is_some() && state.is_running() => KeyEffect::Do(Action::Ready),
        ' ' | 's' => match kind {
            _ if tripped => KeyEffect::Explain("tripped: remove the cause, then re-arm with x"),
            PhaseKind::Idle => KeyEffect::Do(Action::Start),
            PhaseKind::Ready | PhaseKind::Rest => KeyEffect::Do(Action::Ready),
            PhaseKind::Consent => KeyEffect::Explain("record the consent first: c"),
            PhaseKind::Paused => KeyEffect::Explain("paused: resume with p"),
            PhaseKind::Finished => KeyEffect::Explain("the session has finished"),
            _ => KeyEffect::Explain("already running"),
        },
        'c' => match kind {
            PhaseKind::Consent => KeyEffect::Ask(Action::Consent),
            _ => KeyEffect::Explain("consent is not needed now"),
        },
        'p' => match kind {
            PhaseKind::Paused if tripped => {
                KeyEffect::Explain("tripped: remove the cause, then re-arm with x")
            }
            PhaseKind::Paused => KeyEffect::Do(Action::Resume),
            PhaseKind::Idle | PhaseKind::Consent | PhaseKind::Finished => {
                KeyEffect::Explain("nothing to pause")
            }
            _ => KeyEffect::Do(Action::Pause),
        },
        'r' if state.phase.trial > 0 && state.is_running() => KeyEffect::Ask(Action::Redo),
        'r' => KeyEffect::Explain("no trial to repeat"),
        'a' if state.in_session() => KeyEffect::Ask(Action::Abort),
        'a' => KeyEffect::Explain("no session to abort"),
        'x' if tripped => KeyEffect::Ask(Action::Rearm),
        'x' => KeyEffect::Explain("not tripped: nothing to re-arm"),
        't' if state.new_carrier.is_some() => KeyEffect::Do(Action::TakeCarrier),
        'n' if state.new_carrier.is_some() => KeyEffect::Do(Action::KeepCarrier),
        't' | 'n' => KeyEffect::Explain("no new carrier is proposed"),
        'q' if state.is_running() => KeyEffect::Ask(Action::Quit),
        'q' => KeyEffect::Do(Action::Quit),
        _ => KeyEffect::Nothing,
    }
}
