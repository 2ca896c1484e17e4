//! Keys of a calibration: on its own page, on the bench's and on the log.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::asked_keys::DIGITS;
use crate::calibration_page::{Question, Reply};
use crate::event::SafetyView;
use crate::key_table::{Effect, KeyRow, Meaning, Press};
use crate::page::Page;
use crate::session_keys::rearm;
use crate::state::{State, Ui};

/// Maximum length of a typed number, characters.
const MAX_CHARACTERS: usize = 12;

/// Keys of a calibration; the keys that answer it work only on its own page.
pub(crate) const CALIBRATION: &[KeyRow] = &[
    KeyRow {
        presses: DIGITS,
        label: "0–9",
        meaning: |state| {
            is_typing(state).then(|| Meaning::view(type_character, "type the number", None))?
        },
    },
    KeyRow {
        presses: &[
            Press::character('.'),
            Press::character(','),
            Press::character('-'),
        ],
        label: ". -",
        meaning: |state| {
            is_typing(state).then(|| {
                Meaning::view(type_character, "type a decimal point or a minus sign", None)
            })?
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Backspace)],
        label: "bksp",
        meaning: |state| {
            is_typing(state).then(|| Meaning::view(delete, "delete the last character", None))?
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Enter)],
        label: "enter",
        meaning: |state| {
            let calibration = state.calibration.as_ref()?;
            let waits = calibration.asked.is_some() || calibration.failed;
            if waits && state.shown_calibration().is_none() {
                return Meaning::explanation("return to the calibration first: 1");
            }
            let (help, hint) = match &calibration.asked {
                None if calibration.failed => {
                    return Meaning::action(Action::Quit, "leave", "leave");
                }
                None => {
                    return Meaning::explanation("no input is needed now: the bench is working");
                }
                Some(Question::Done) => ("the step is done", "done"),
                Some(Question::Review) if calibration.rejected => {
                    ("end without putting the results in force", "end")
                }
                Some(Question::Review) => ("accept the results", "accept"),
                Some(Question::Number { .. }) => ("confirm the number", "confirm"),
            };
            Meaning::view(enter, help, Some(hint))
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Up), Press::key(KeyCode::Down)],
        label: "↑ ↓",
        meaning: |state| {
            can_redo(state).then(|| Meaning::view(choose, "select a point", Some("point")))?
        },
    },
    KeyRow {
        presses: &[Press::character('r')],
        label: "r",
        meaning: |state| {
            if !can_redo(state) {
                return Meaning::explanation("no point to select now");
            }
            let question = &state.calibration.as_ref()?.asked;
            let (help, hint) = match question {
                Some(Question::Number { optional: true, .. }) => {
                    ("remove the selected point", "remove")
                }
                _ => ("remeasure the selected point", "remeasure"),
            };
            Meaning::view(redo, help, Some(hint))
        },
    },
    KeyRow {
        presses: &[Press::character('x')],
        label: "x",
        meaning: |state| match state.safety {
            _ if state.calibration.as_ref()?.failed => None,
            Some(SafetyView::Tripped) => rearm(state),
            _ => Meaning::explanation("not tripped: nothing to re-arm"),
        },
    },
    KeyRow {
        presses: &[Press::character('q')],
        label: "q",
        meaning: |state| {
            if state.calibration.as_ref()?.failed {
                return Meaning::action(Action::Quit, "quit", "quit");
            }
            Meaning::new(
                Effect::Ask(Action::Quit),
                "quit; nothing is written",
                Some("quit"),
            )
        },
    },
];

/// Keys that turn pages while no number is typed.
pub(crate) const CALIBRATION_PAGES: &[KeyRow] = &[
    KeyRow {
        presses: &[Press::key(KeyCode::Tab)],
        label: "tab",
        meaning: |state| {
            let (help, hint) = match state.ui.page {
                Page::Bench => ("show the log", "log"),
                Page::Log => ("return to the calibration", "calibration"),
                _ => ("bench, log and calibration in turn", "bench"),
            };
            Meaning::view(turn, help, Some(hint))
        },
    },
    KeyRow {
        presses: &[
            Press::character('1'),
            Press::character('4'),
            Press::character('5'),
        ],
        label: "1 4 5",
        meaning: |_| Meaning::view(turn, "Calibration, Bench, Log", None),
    },
    KeyRow {
        presses: &[Press::character('2'), Press::character('3')],
        label: "2 3",
        meaning: |_| Meaning::explanation("a calibration has the pages 1, 4 and 5"),
    },
];

fn turn(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    ui.turn_to(match (code, ui.page) {
        (KeyCode::Char('4'), _) | (KeyCode::Tab, Page::Run) => Page::Bench,
        (KeyCode::Char('5'), _) | (KeyCode::Tab, Page::Bench) => Page::Log,
        _ => Page::Run,
    });
    None
}

/// Whether the shown page asks for a number.
fn is_typing(state: &State) -> bool {
    let question = state.shown_calibration().map(|page| &page.asked);
    matches!(question, Some(Some(Question::Number { .. })))
}

fn type_character(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    if let KeyCode::Char(c) = code
        && ui.typed.len() < MAX_CHARACTERS
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

/// Replies to the calibration's question with the typed text.
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

/// Whether [`Reply::Redo`] is possible on the shown page.
fn can_redo(state: &State) -> bool {
    let question = state.shown_calibration().map(|page| &page.asked);
    let asks_point = matches!(
        question,
        Some(Some(Question::Number { .. } | Question::Review))
    );
    asks_point && state.chosen_point().is_some()
}
