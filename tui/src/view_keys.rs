//! Keys that change only the view.

use ratatui::crossterm::event::KeyCode;

use crate::action::Action;
use crate::frozen::Frozen;
use crate::key_table::{KeyRow, Meaning, Press};
use crate::page::Page;
use crate::state::{State, Ui};

/// Rows scrolled by a page key.
const PAGE_ROWS: u16 = 10;

/// Keys of the view, those for the current page first.
pub(crate) const VIEW: &[KeyRow] = &[
    KeyRow {
        presses: &[Press::key(KeyCode::Left), Press::key(KeyCode::Right)],
        label: "← →",
        meaning: |state| match (&state.ui.frozen, state.ui.page) {
            (_, Page::Trials) => {
                Meaning::view(choose_trial, "previous or next trial", Some("trial"))
            }
            (Some(_), Page::Run | Page::Impedance) => Meaning::view(
                move_cursor,
                "move cursor A of the held strips",
                Some("cursor"),
            ),
            _ => None,
        },
    },
    KeyRow {
        presses: &[Press::character('['), Press::character(']')],
        label: "[ ]",
        meaning: |state| match (&state.ui.frozen, state.ui.page) {
            (Some(_), Page::Run | Page::Impedance) => {
                Meaning::view(move_cursor, "move cursor B of the held strips", None)
            }
            _ => None,
        },
    },
    KeyRow {
        presses: &[Press::character('f')],
        label: "f",
        meaning: |state| match state.ui.frozen {
            Some(_) => Meaning::view(hold, "release the strips", Some("release")),
            None if state.history.is_empty() => {
                Meaning::explanation("nothing to hold: no values yet")
            }
            None => Meaning::view(hold, "hold the strips, with two cursors", Some("hold")),
        },
    },
    KeyRow {
        presses: &[Press::character('z')],
        label: "z",
        meaning: |state| match state.ui.page.panels() {
            0 => Meaning::explanation("nothing to enlarge on this page"),
            _ => Meaning::view(enlarge, "enlarge the panels one by one", Some("enlarge")),
        },
    },
];

/// Keys that turn pages and change the time span of the strips.
pub(crate) const PAGES: &[KeyRow] = &[
    KeyRow {
        presses: &[
            Press::character('1'),
            Press::character('2'),
            Press::character('3'),
            Press::character('4'),
            Press::character('5'),
        ],
        label: "1 … 5",
        meaning: |_| Meaning::view(turn, "Run, Impedance, Trials, Bench, Log", None),
    },
    KeyRow {
        presses: &[Press::key(KeyCode::Tab)],
        label: "tab",
        meaning: |state| {
            // The question is not shown on the participant's page.
            if state.asked.is_some() || state.new_carrier.is_some() {
                return Meaning::explanation("answer the question first");
            }
            let hint = match state.ui.page {
                Page::Participant => "dashboard",
                _ => "participant",
            };
            Meaning::view(turn, "participant's screen, and back", Some(hint))
        },
    },
    KeyRow {
        presses: &[
            Press::character('+'),
            Press::character('='),
            Press::character('-'),
        ],
        label: "+ -",
        meaning: |_| Meaning::view(span, "shorter or longer time span of the strips", None),
    },
];

/// Keys that scroll a list.
pub(crate) const SCROLL: &[KeyRow] = &[KeyRow {
    presses: &[
        Press::character('j'),
        Press::character('k'),
        Press::key(KeyCode::PageDown),
        Press::key(KeyCode::PageUp),
    ],
    label: "j k",
    meaning: |state| match state.ui.page {
        Page::Trials | Page::Bench | Page::Log => {
            Meaning::view(scroll, "scroll, like the mouse wheel", Some("scroll"))
        }
        _ => None,
    },
}];

/// Key that writes the page to files, also on a calibration's page.
pub(crate) const WRITE: &[KeyRow] = &[KeyRow {
    presses: &[Press::character('w')],
    label: "w",
    meaning: |_| Meaning::view(write, "write the page as SVG and text files", None),
}];

fn write(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.write = true;
    None
}

fn span(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    ui.window = match code {
        KeyCode::Char('-') => ui.window.wider(),
        _ => ui.window.narrower(),
    };
    None
}

fn turn(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    let page = match (code, ui.page) {
        (KeyCode::Char('2'), _) => Page::Impedance,
        (KeyCode::Char('3'), _) => Page::Trials,
        (KeyCode::Char('4'), _) => Page::Bench,
        (KeyCode::Char('5'), _) => Page::Log,
        (KeyCode::Tab, Page::Participant) => Page::Run,
        (KeyCode::Tab, _) => Page::Participant,
        _ => Page::Run,
    };
    ui.turn_to(page);
    None
}

fn enlarge(_: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.zoom = (ui.zoom + 1) % (ui.page.panels() + 1);
    None
}

fn hold(state: &State, ui: &mut Ui, _: KeyCode) -> Option<Action> {
    ui.frozen = match ui.frozen {
        Some(_) => None,
        None => Some(Box::new(Frozen::new(state.history.clone()))),
    };
    None
}

fn move_cursor(_: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    let (cursor, steps) = match code {
        KeyCode::Left => (0, -1.0),
        KeyCode::Right => (0, 1.0),
        KeyCode::Char('[') => (1, -1.0),
        _ => (1, 1.0),
    };
    if let Some(frozen) = &mut ui.frozen {
        frozen.step(cursor, steps);
    }
    None
}

/// Scrolls down or up. The log is counted from its newest line, at the bottom.
fn scroll(state: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    let (step, down) = match code {
        KeyCode::Char('j') => (1, true),
        KeyCode::PageDown => (PAGE_ROWS, true),
        KeyCode::PageUp => (PAGE_ROWS, false),
        _ => (1, false),
    };
    let forward = down != (ui.page == Page::Log);
    ui.scroll = if forward {
        let max_scroll = u16::try_from(state.log.len()).unwrap_or(u16::MAX).max(100);
        ui.scroll.saturating_add(step).min(max_scroll)
    } else {
        ui.scroll.saturating_sub(step)
    };
    None
}

/// Selects the next or the previous attempt; after the last, the selection follows the newest.
fn choose_trial(state: &State, ui: &mut Ui, code: KeyCode) -> Option<Action> {
    let last = state.trials.len().checked_sub(1)?;
    let trial = state.chosen_trial()?;
    let index = state
        .trials
        .iter()
        .position(|line| std::ptr::eq(line, trial))?;
    let next = match code {
        KeyCode::Right => index + 1,
        _ => index.saturating_sub(1),
    };
    ui.trial = (next < last).then_some(next);
    ui.scroll = 0;
    None
}
