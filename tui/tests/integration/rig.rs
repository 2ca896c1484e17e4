//! The synthetic session, the dashboard's screen and its keys.

use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use tui::{Action, Event, State, Theme, key, view};

use crate::synthetic;

/// Plays the synthetic session until `is_reached` is true for the first time.
pub fn play_until(is_reached: impl Fn(&State) -> bool) -> State {
    let mut state = State::new(Theme::Colour);
    for (at_s, event) in synthetic::session() {
        state.apply(&Event::Tick { now_s: at_s });
        state.apply(&event);
        if is_reached(&state) {
            return state;
        }
    }
    panic!("the session never gets there");
}

pub fn draw(state: &State, columns: u16, rows: u16) -> Terminal<TestBackend> {
    let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
    terminal.draw(|frame| view(state, frame)).unwrap();
    terminal
}

pub fn key_event(code: KeyCode) -> KeyEvent {
    KeyEvent::new(code, KeyModifiers::NONE)
}

/// Presses the keys one after the other; returns the requested actions.
pub fn press(state: &mut State, keys: &str) -> Vec<Action> {
    let mut actions = Vec::new();
    for letter in keys.chars() {
        let reaction = key(state, key_event(code(letter)));
        state.ui = reaction.ui;
        actions.extend(reaction.action);
    }
    actions
}

fn code(letter: char) -> KeyCode {
    match letter {
        '\n' => KeyCode::Enter,
        '\u{8}' => KeyCode::Backspace,
        '↑' => KeyCode::Up,
        '↓' => KeyCode::Down,
        '\t' => KeyCode::Tab,
        letter => KeyCode::Char(letter),
    }
}
