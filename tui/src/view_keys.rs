//! The keys that change what is seen, and nothing else.

use ratatui::crossterm::event::KeyCode;

use crate::frozen::Frozen;
use crate::page::Page;
use crate::state::{State, Ui};

/// Rows by which a page key scrolls.
const PAGE_ROWS: u16 = 10;

/// Applies a key that changes what is seen; whether it is one. `other` moves the second cursor.
pub(crate) fn key(state: &State, ui: &mut Ui, code: KeyCode, other: bool) -> bool {
    match code {
        KeyCode::Char(digit @ '1'..='5') => {
            let page = match digit {
                '1' => Page::Run,
                '2' => Page::Impedance,
                '3' => Page::Trials,
                '4' => Page::Bench,
                _ => Page::Log,
            };
            if ui.page != page {
                ui.page = page;
                ui.zoom = 0;
                ui.scroll = 0;
            }
        }
        KeyCode::Tab => {
            ui.page = match ui.page {
                Page::Participant => Page::Run,
                _ => Page::Participant,
            };
            ui.zoom = 0;
            ui.scroll = 0;
        }
        KeyCode::Char('z') => {
            let panels = ui.page.panels();
            if panels == 0 {
                ui.note = Some("nothing to enlarge on this page".to_owned());
            } else {
                ui.zoom = (ui.zoom + 1) % (panels + 1);
            }
        }
        KeyCode::Char('f') => match ui.frozen.take() {
            Some(_) => {}
            None if state.history.is_empty() => {
                ui.note = Some("nothing to hold: no values yet".to_owned());
            }
            None => ui.frozen = Some(Box::new(Frozen::new(state.history.clone()))),
        },
        KeyCode::Left | KeyCode::Right => {
            let forward = code == KeyCode::Right;
            match &mut ui.frozen {
                Some(frozen) if ui.page != Page::Trials => {
                    frozen.step(usize::from(other), if forward { 1.0 } else { -1.0 });
                }
                _ => choose_trial(state, ui, forward),
            }
        }
        KeyCode::Char('j') | KeyCode::Down => scroll(state, ui, 1, true),
        KeyCode::Char('k') | KeyCode::Up => scroll(state, ui, 1, false),
        KeyCode::PageDown => scroll(state, ui, PAGE_ROWS, true),
        KeyCode::PageUp => scroll(state, ui, PAGE_ROWS, false),
        KeyCode::Char('w') => ui.write = true,
        KeyCode::Char('+' | '=') => ui.window = ui.window.narrower(),
        KeyCode::Char('-') => ui.window = ui.window.wider(),
        _ => return false,
    }
    true
}

/// Scrolls down or up. The log is counted from its newest line, at the bottom.
fn scroll(state: &State, ui: &mut Ui, by: u16, down: bool) {
    let forward = down != (ui.page == Page::Log);
    ui.scroll = if forward {
        let most = u16::try_from(state.log.len()).unwrap_or(u16::MAX).max(100);
        ui.scroll.saturating_add(by).min(most)
    } else {
        ui.scroll.saturating_sub(by)
    };
}

/// Chooses the next or the previous attempt; after the last, the newest is followed.
fn choose_trial(state: &State, ui: &mut Ui, forward: bool) {
    let Some(last) = state.trials.len().checked_sub(1) else {
        return;
    };
    let at = ui.trial.unwrap_or(last);
    let next = if forward { at + 1 } else { at.saturating_sub(1) };
    ui.trial = (next < last).then_some(next);
    ui.scroll = 0;
}
