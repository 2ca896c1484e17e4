//! Keys while a question about the participant waits for an answer.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::calibration_page::Reply;
use crate::key_table::{KeyRow, Meaning, Press};
use crate::state::{State, Ui};

/// Maximum number of digits.
const MAX_DIGITS: usize = 3;

/// Keys of the question; all other keys are the dashboard's.
pub(crate) const ANSWER: &[KeyRow] = &[
    KeyRow {
        presses: DIGITS,
        label: "0–9",
        meaning: |_| Meaning::view(digit, "type the number", Some("type")),
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Backspace)],
        label: "bksp",
        meaning: |_| Meaning::view(delete, "delete the last digit", None),
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Enter)],
        label: "enter",
        meaning: |_| {
            let help = "confirm; empty: not stated";
            Meaning::view(enter, help, Some(help))
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Up)],
        label: "↑",
        meaning: |state| match &state.asked {
            Some(asked) if asked.has_previous => {
                Meaning::view(back, "back to the previous question", Some("back"))
            }
            _ => Meaning::explanation("the first question: no answer to go back to"),
        },
    },
    KeyRow {
        presses: &[
            Press::character(' '),
            Press::character('s'),
            Press::character('c'),
        ],
        label: "space",
        meaning: |_| {
            Meaning::explanation("answer the question first; enter without an answer: not stated")
        },
    },
];

/// The digits.
pub(crate) const DIGITS: &[Press] = &[
    Press::character('0'),
    Press::character('1'),
    Press::character('2'),
    Press::character('3'),
    Press::character('4'),
    Press::character('5'),
    Press::character('6'),
    Press::character('7'),
    Press::character('8'),
    Press::character('9'),
];

fn digit(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    if let KeyCode::Char(c) = code
        && ui.typed.len() < MAX_DIGITS
    {
        ui.typed.push(c);
    }
    None
}

fn delete(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.typed.pop();
    None
}

fn enter(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    let text = std::mem::take(&mut ui.typed);
    let reply = text.parse().map_or(Reply::Ready, Reply::Number);
    Some(Action::Answer(reply))
}

fn back(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.typed.clear();
    Some(Action::Answer(Reply::Redo(0)))
}
