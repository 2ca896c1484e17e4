//! The effect of a key while a question about the participant waits for an answer.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::calibration_page::Reply;
use crate::state::Ui;

/// Largest number of digits.
const LONGEST: usize = 3;

/// Applies a key that the question takes; the action that it requests, if any. `None` if the key is the dashboard's own.
pub(crate) fn key(ui: &mut Ui, code: KeyCode) -> Option<Option<Action>> {
    match code {
        KeyCode::Char(c @ '0'..='9') => {
            if ui.typed.len() < LONGEST {
                ui.typed.push(c);
            }
        }
        KeyCode::Backspace => {
            ui.typed.pop();
        }
        KeyCode::Enter => {
            let typed = std::mem::take(&mut ui.typed);
            let reply = typed.parse().map_or(Reply::Ready, Reply::Number);
            return Some(Some(Action::Answer(reply)));
        }
        KeyCode::Up => {
            ui.typed.clear();
            return Some(Some(Action::Answer(Reply::Redo(0))));
        }
        KeyCode::Char(' ' | 's' | 'c') => {
            ui.note = Some("answer the question first; enter alone: not stated".to_owned());
        }
        _ => return None,
    }
    Some(None)
}
