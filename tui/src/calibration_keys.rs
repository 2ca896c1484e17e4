//! The effect of a key on a calibration's page.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::calibration_page::{CalibrationPage, Question, Reply};
use crate::state::{State, Ui};

/// Largest number of characters of a typed number.
const LONGEST: usize = 12;

/// Applies `code` to `ui`. Returns the action that it requests, if any.
pub(crate) fn key(
    state: &State,
    calibration: &CalibrationPage,
    ui: &mut Ui,
    code: KeyCode,
) -> Option<Action> {
    let types = matches!(calibration.asked, Some(Question::Number { .. }));
    match code {
        KeyCode::Char(c @ ('0'..='9' | '.' | ',' | '-')) if types && ui.typed.len() < LONGEST => {
            ui.typed.push(if c == ',' { '.' } else { c });
        }
        KeyCode::Backspace => {
            ui.typed.pop();
        }
        KeyCode::Up => ui.chosen = state.chosen_point().map(|i| i.saturating_sub(1)),
        KeyCode::Down => ui.chosen = state.chosen_point().map(|i| i + 1),
        KeyCode::Enter => return enter(calibration, ui),
        KeyCode::Char('r') if can_redo(state, calibration) => {
            let point = state.chosen_point()?;
            ui.chosen = None;
            ui.typed.clear();
            return Some(Action::Answer(Reply::Redo(point)));
        }
        KeyCode::Char('r') => ui.note = Some("no point to select now".to_owned()),
        KeyCode::Char('?' | 'h') => ui.help = true,
        KeyCode::Char('q') if calibration.failed => return Some(Action::Quit),
        KeyCode::Char('q') => ui.confirm = Some(Action::Quit),
        _ => {}
    }
    None
}

/// Replies to the calibration's question with what is typed.
fn enter(calibration: &CalibrationPage, ui: &mut Ui) -> Option<Action> {
    let answer = match &calibration.asked {
        None if calibration.failed => return Some(Action::Quit),
        None => {
            ui.note = Some("no input is needed now: the bench is working".to_owned());
            return None;
        }
        Some(Question::Done | Question::Review) => Reply::Ready,
        Some(Question::Number { optional: true, .. }) if ui.typed.is_empty() => Reply::Ready,
        Some(Question::Number { unit, .. }) => match ui.typed.parse::<f64>() {
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
pub(crate) fn can_redo(state: &State, calibration: &CalibrationPage) -> bool {
    let asked = matches!(
        calibration.asked,
        Some(Question::Number { .. } | Question::Review)
    );
    asked && state.chosen_point().is_some()
}
