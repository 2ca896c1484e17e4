//! The table of keys, which dispatches them and lists them in the help and on the last row.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use crate::action::Action;
use crate::state::{State, Ui};

/// A key press, ignoring case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Press {
    /// The key.
    pub(crate) code: KeyCode,
    /// Whether Ctrl is held.
    pub(crate) control: bool,
}

impl Press {
    /// Returns the press of a character.
    pub(crate) const fn character(c: char) -> Self {
        Self::key(KeyCode::Char(c))
    }

    /// Returns the press of any key.
    pub(crate) const fn key(code: KeyCode) -> Self {
        Self {
            code,
            control: false,
        }
    }

    /// Returns the press of a character with Ctrl.
    pub(crate) const fn control(c: char) -> Self {
        Self {
            code: KeyCode::Char(c),
            control: true,
        }
    }

    /// Returns the press of an event; `None` with Alt, which is not used.
    pub(crate) fn read(event: KeyEvent) -> Option<Self> {
        let code = match event.code {
            KeyCode::Char(c) => KeyCode::Char(c.to_ascii_lowercase()),
            code => code,
        };
        (!event.modifiers.contains(KeyModifiers::ALT)).then_some(Self {
            code,
            control: event.modifiers.contains(KeyModifiers::CONTROL),
        })
    }
}

/// A row of the table: keys with the same meaning.
pub(crate) struct KeyRow {
    /// The keys.
    pub(crate) presses: &'static [Press],
    /// Their name in the help.
    pub(crate) label: &'static str,
    /// Their meaning in a state; `None` if they have no meaning there.
    pub(crate) meaning: fn(&State) -> Option<Meaning>,
}

/// Meaning of a key in the present state.
pub(crate) struct Meaning {
    /// The effect.
    pub(crate) effect: Effect,
    /// Its description in the help.
    pub(crate) help: &'static str,
    /// Its word on the last row; `None` to list it in the help only.
    pub(crate) hint: Option<&'static str>,
}

/// Effect of a key press.
pub(crate) enum Effect {
    /// A request to the bench, at once.
    Do(Action),
    /// A request to the bench, after confirmation.
    Ask(Action),
    /// A change of the view, or a request with the typed text to the bench.
    Apply(fn(&State, &mut Ui, KeyCode) -> Option<Action>),
    /// A complete redraw of the screen.
    Redraw,
    /// No effect; the text gives the reason.
    Explain(&'static str),
}

impl Meaning {
    /// Returns the meaning of a key that sends a request to the bench at once.
    pub(crate) fn action(action: Action, help: &'static str, hint: &'static str) -> Option<Self> {
        Self::new(Effect::Do(action), help, Some(hint))
    }

    /// Returns the meaning of a key that sends a request to the bench after confirmation.
    pub(crate) fn question(action: Action, help: &'static str, hint: &'static str) -> Option<Self> {
        Self::new(Effect::Ask(action), help, Some(hint))
    }

    /// Returns the meaning of a key without effect, with the reason.
    pub(crate) fn explanation(reason: &'static str) -> Option<Self> {
        Self::new(Effect::Explain(reason), "", None)
    }

    /// Returns the meaning of a key that changes the view.
    pub(crate) fn view(
        change: fn(&State, &mut Ui, KeyCode) -> Option<Action>,
        help: &'static str,
        hint: Option<&'static str>,
    ) -> Option<Self> {
        Self::new(Effect::Apply(change), help, hint)
    }

    /// Returns the meaning of a key with this effect.
    pub(crate) fn new(
        effect: Effect,
        help: &'static str,
        hint: Option<&'static str>,
    ) -> Option<Self> {
        Some(Self { effect, help, hint })
    }

    /// Whether the key has an effect here.
    pub(crate) fn works(&self) -> bool {
        !matches!(self.effect, Effect::Explain(_))
    }
}

/// Returns the rows with a meaning in `state`, and that meaning; for rows with the same keys, only the first.
pub(crate) fn meanings<'a>(
    state: &'a State,
    rows: impl Iterator<Item = &'static KeyRow> + 'a,
) -> impl Iterator<Item = (&'static KeyRow, Meaning)> + 'a {
    let mut presses: Vec<Press> = Vec::new();
    rows.filter_map(move |row| {
        if row.presses.iter().all(|press| presses.contains(press)) {
            return None;
        }
        let meaning = (row.meaning)(state)?;
        presses.extend(row.presses);
        Some((row, meaning))
    })
}
