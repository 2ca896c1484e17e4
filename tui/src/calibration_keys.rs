//! The keys of a calibration's page.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::asked_keys::DIGITS;
use crate::calibration_page::{Question, Reply};
use crate::event::SafetyState;
use crate::key_table::{Effect, KeyRow, Meaning, Press};
use crate::session_keys::rearm;
use crate::state::{State, Ui};

/// Largest number of characters of a typed number.
const LONGEST: usize = 12;

/// The keys of a calibration's page.
pub(crate) const CALIBRATION: &[KeyRow] = &[
    KeyRow {
        presses: DIGITS,
        shown: "0–9",
        here: |state| {
            types(state).then(|| Meaning::viewing(typed, "type the number", Some("type")))?
        },
    },
    KeyRow {
        presses: &[Press::of('.'), Press::of(','), Press::of('-')],
        shown: ". -",
        here: |state| {
            types(state)
                .then(|| Meaning::viewing(typed, "type a decimal point or a minus", None))?
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Backspace)],
        shown: "bksp",
        here: |state| {
            types(state).then(|| Meaning::viewing(delete, "delete the last character", None))?
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Enter)],
        shown: "enter",
        here: |state| {
            let calibration = state.calibration.as_ref()?;
            let (help, hint) = match &calibration.asked {
                None if calibration.failed => {
                    return Meaning::doing(Action::Quit, "leave", "leave");
                }
                None => {
                    return Meaning::explaining("no input is needed now: the bench is working");
                }
                Some(Question::Done) => ("the step is done", "done"),
                Some(Question::Review) => ("accept the points", "accept"),
                Some(Question::Number { .. }) => ("confirm the number", "confirm"),
            };
            Meaning::viewing(enter, help, Some(hint))
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Up), Press::key(KeyCode::Down)],
        shown: "↑ ↓",
        here: |state| {
            can_redo(state).then(|| Meaning::viewing(choose, "select a point", Some("point")))?
        },
    },
    KeyRow {
        presses: &[Press::of('r')],
        shown: "r",
        here: |state| {
            if !can_redo(state) {
                return Meaning::explaining("no point to select now");
            }
            let asked = &state.calibration.as_ref()?.asked;
            let (help, hint) = match asked {
                Some(Question::Number { optional: true, .. }) => {
                    ("remove the selected point", "remove")
                }
                _ => ("remeasure the selected point", "remeasure"),
            };
            Meaning::viewing(redo, help, Some(hint))
        },
    },
    KeyRow {
        presses: &[Press::of('x')],
        shown: "x",
        here: |state| match state.safety {
            _ if state.calibration.as_ref()?.failed => None,
            Some(SafetyState::Tripped) => rearm(),
            _ => Meaning::explaining("not tripped: nothing to re-arm"),
        },
    },
    KeyRow {
        presses: &[Press::of('q')],
        shown: "q",
        here: |state| {
            if state.calibration.as_ref()?.failed {
                return Meaning::doing(Action::Quit, "quit", "quit");
            }
            Meaning::with(
                Effect::Ask(Action::Quit),
                "quit; nothing is written",
                Some("quit"),
            )
        },
    },
];

/// Whether a number is asked for.
fn types(state: &State) -> bool {
    let asked = state.calibration.as_ref().map(|page| &page.asked);
    matches!(asked, Some(Some(Question::Number { .. })))
}

fn typed(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    if let KeyCode::Char(c) = code
        && ui.typed.len() < LONGEST
    {
        ui.typed.push(if c == ',' { '.' } else { c });
    }
    None
}

fn delete(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.typed.pop();
    None
}

fn choose(state: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    ui.chosen = state.chosen_point().map(|i| match code {
        KeyCode::Up => i.saturating_sub(1),
        _ => i + 1,
    });
    None
}

fn redo(state: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    let point = state.chosen_point()?;
    ui.chosen = None;
    ui.typed.clear();
    Some(Action::Answer(Reply::Redo(point)))
}

/// Replies to the calibration's question with what is typed.
fn enter(state: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    let answer = match state.calibration.as_ref()?.asked.as_ref()? {
        Question::Done | Question::Review => Reply::Ready,
        Question::Number { optional: true, .. } if ui.typed.is_empty() => Reply::Ready,
        Question::Number { unit, .. } => match ui.typed.parse::<f64>() {
            Ok(number) if number.is_finite() => Reply::Number(number),
            _ if ui.typed.is_empty() => {
                ui.note = Some(format!("type the number in {unit} first"));
                return None;
            }
            _ => {
                ui.note = Some(format!(
                    "{} is not a number: backspace deletes the last character",
                    ui.typed
                ));
                return None;
            }
        },
    };
    ui.typed.clear();
    ui.chosen = None;
    Some(Action::Answer(answer))
}

/// Whether [`Reply::Redo`] is possible now.
fn can_redo(state: &State) -> bool {
    let asked = state.calibration.as_ref().map(|page| &page.asked);
    let asked = matches!(
        asked,
        Some(Some(Question::Number { .. } | Question::Review))
    );
    asked && state.chosen_point().is_some()
}
