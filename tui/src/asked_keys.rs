//! Keys while a question about the participant waits for an answer.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::calibration_page::Reply;
use crate::key_table::{KeyRow, Meaning, Press};
use crate::state::{State, Ui};

/// Maximum number of digits.
const LONGEST: usize = 3;

/// Keys of the question; all other keys are the dashboard's.
pub(crate) const ASKED: &[KeyRow] = &[
    KeyRow {
        presses: DIGITS,
        shown: "0–9",
        here: |_| Meaning::viewing(digit, "type the number", Some("type")),
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Backspace)],
        shown: "bksp",
        here: |_| Meaning::viewing(delete, "delete the last digit", None),
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Enter)],
        shown: "enter",
        here: |_| {
            let help = "confirm; alone: not stated";
            Meaning::viewing(enter, help, Some(help))
        },
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Up)],
        shown: "↑",
        here: |_| Meaning::viewing(back, "back to the question before", Some("back")),
    },
    KeyRow {
        presses: &[Press::of(' '), Press::of('s'), Press::of('c')],
        shown: "space",
        here: |_| Meaning::explaining("answer the question first; enter alone: not stated"),
    },
];

/// The digits.
pub(crate) const DIGITS: &[Press] = &[
    Press::of('0'),
    Press::of('1'),
    Press::of('2'),
    Press::of('3'),
    Press::of('4'),
    Press::of('5'),
    Press::of('6'),
    Press::of('7'),
    Press::of('8'),
    Press::of('9'),
];

fn digit(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    if let KeyCode::Char(c) = code
        && ui.typed.len() < LONGEST
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
    let typed = std::mem::take(&mut ui.typed);
    let reply = typed.parse().map_or(Reply::Ready, Reply::Number);
    Some(Action::Answer(reply))
}

fn back(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.typed.clear();
    Some(Action::Answer(Reply::Redo(0)))
}
