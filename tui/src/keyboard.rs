//! The effect of a key: a pure function of the state and the key.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind};

use crate::action::Action;
use crate::asked_keys::ANSWER;
use crate::calibration_keys::{CALIBRATION, CALIBRATION_PAGES};
use crate::key_table::{Effect, KeyRow, Meaning, Press, meanings};
use crate::session_keys::{ALL_PAGES, DASHBOARD, HELP};
use crate::state::{State, Ui};
use crate::view_keys::{PAGES, SCROLL, VIEW, WRITE};

/// The effect of a key: the view settings after it, and at most one action.
#[derive(Clone, Debug, PartialEq)]
pub struct Reaction {
    /// View settings after the key.
    pub ui: Ui,
    /// Request to the bench.
    pub action: Option<Action>,
    /// Whether the whole screen must be redrawn.
    pub redraw: bool,
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
    let mut reaction = Reaction {
        ui: state.ui.clone(),
        action: None,
        redraw: false,
    };
    let ui = &mut reaction.ui;
    if key.kind == KeyEventKind::Release {
        return reaction;
    }
    ui.note = None;
    let Some(press) = Press::read(key) else {
        return reaction;
    };
    let meaning = meaning(state, press);
    let effect = meaning.map(|meaning| meaning.effect);
    match effect {
        Some(Effect::Redraw) => reaction.redraw = true,
        Some(Effect::Do(action @ Action::EmergencyStop)) => {
            // A stop does not answer the question.
            ui.confirm = None;
            reaction.action = Some(action);
        }
        Some(Effect::Do(action @ Action::Interrupt)) => reaction.action = Some(action),
        // A key held down must neither answer its own question nor toggle pause.
        _ if press.control || key.kind == KeyEventKind::Repeat => {}
        _ if ui.confirm.is_some() => reaction.action = answer(ui, press.code),
        _ if ui.help => ui.help = false,
        Some(Effect::Do(action)) => reaction.action = Some(action),
        Some(Effect::Ask(action)) => ui.confirm = Some(action),
        Some(Effect::Apply(apply)) => reaction.action = apply(state, ui, press.code),
        Some(Effect::Explain(why)) => ui.note = Some(why.to_owned()),
        None => {}
    }
    reaction
}

/// Returns the action of a key with the same meaning on every page: the stop, and the end.
#[must_use]
pub(crate) fn at_once(key: KeyEvent) -> Option<Action> {
    let press = Press::read(key).filter(|_| key.kind != KeyEventKind::Release)?;
    [
        (Press::character('e'), Action::EmergencyStop),
        (Press::control('c'), Action::Interrupt),
    ]
    .into_iter()
    .find_map(|(at_once, action)| (at_once == press).then_some(action))
}

/// Answers the question that waits for confirmation.
fn answer(ui: &mut Ui, code: KeyCode) -> Option<Action> {
    match code {
        KeyCode::Char('y') => ui.confirm.take(),
        KeyCode::Char('n') | KeyCode::Esc => {
            ui.confirm = None;
            None
        }
        _ => None,
    }
}

/// Returns the rows of the table for the shown page.
fn rows(state: &State) -> impl Iterator<Item = &'static KeyRow> {
    let detail_rows: &[KeyRow] = if state.asked.is_some() { ANSWER } else { &[] };
    let pages: &[&[KeyRow]] = if state.calibration.is_some() {
        &[CALIBRATION, CALIBRATION_PAGES, HELP, SCROLL, WRITE]
    } else {
        &[HELP, DASHBOARD, VIEW, SCROLL, PAGES, WRITE]
    };
    ALL_PAGES
        .iter()
        .chain(detail_rows)
        .chain(pages.iter().copied().flatten())
}

/// Returns the meaning of `press` in `state`.
fn meaning(state: &State, press: Press) -> Option<Meaning> {
    let mut candidates = rows(state).filter(|row| row.presses.contains(&press));
    candidates.find_map(|row| (row.meaning)(state))
}

/// Returns each row that works in `state`, with its meaning.
pub(crate) fn active_rows(state: &State) -> impl Iterator<Item = (&'static KeyRow, Meaning)> + '_ {
    meanings(state, rows(state)).filter(|(_, meaning)| meaning.works())
}

#[cfg(test)]
mod tests;
