//! Keys as a table: what dispatches a key also lists it in the help and on the last row.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use crate::action::Action;
use crate::state::{State, Ui};

/// One press of a key, without case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Press {
    /// The key.
    pub(crate) code: KeyCode,
    /// Whether Ctrl is held.
    pub(crate) control: bool,
}

impl Press {
    /// Returns the press of a character.
    pub(crate) const fn of(c: char) -> Self {
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

    /// Returns the press that an event tells of; `None` with Alt, which no key here takes.
    pub(crate) fn told(event: KeyEvent) -> Option<Self> {
        let code = match event.code {
            KeyCode::Char(c) => KeyCode::Char(c.to_ascii_lowercase()),
            other => other,
        };
        (!event.modifiers.contains(KeyModifiers::ALT)).then_some(Self {
            code,
            control: event.modifiers.contains(KeyModifiers::CONTROL),
        })
    }
}

/// A row of the table: keys that do the same.
pub(crate) struct KeyRow {
    /// The keys.
    pub(crate) presses: &'static [Press],
    /// Their name in the help.
    pub(crate) shown: &'static str,
    /// What they do in a state; `None` where they have no meaning.
    pub(crate) here: fn(&State) -> Option<Meaning>,
}

/// What a key does in the present state.
pub(crate) struct Meaning {
    /// What happens.
    pub(crate) effect: Effect,
    /// The help's words for it.
    pub(crate) help: &'static str,
    /// The last row's word for it; `None` leaves it to the help.
    pub(crate) hint: Option<&'static str>,
}

/// What happens when a key is pressed.
pub(crate) enum Effect {
    /// The bench is asked at once.
    Do(Action),
    /// The bench is asked after confirmation.
    Ask(Action),
    /// The view changes, or the bench is asked for what was typed.
    Apply(fn(&State, &mut Ui, KeyCode) -> Option<Action>),
    /// The screen is drawn anew.
    Redraw,
    /// Nothing: these words say why.
    Explain(&'static str),
}

impl Meaning {
    /// Returns the meaning of a key that asks the bench at once.
    pub(crate) fn doing(action: Action, help: &'static str, hint: &'static str) -> Option<Self> {
        Self::with(Effect::Do(action), help, Some(hint))
    }

    /// Returns the meaning of a key that asks the bench after confirmation.
    pub(crate) fn asking(action: Action, help: &'static str, hint: &'static str) -> Option<Self> {
        Self::with(Effect::Ask(action), help, Some(hint))
    }

    /// Returns the meaning of a key without effect that says why.
    pub(crate) fn explaining(why: &'static str) -> Option<Self> {
        Self::with(Effect::Explain(why), "", None)
    }

    /// Returns the meaning of a key that changes the view.
    pub(crate) fn viewing(
        change: fn(&State, &mut Ui, KeyCode) -> Option<Action>,
        help: &'static str,
        hint: Option<&'static str>,
    ) -> Option<Self> {
        Self::with(Effect::Apply(change), help, hint)
    }

    /// Returns the meaning of a key with this effect.
    #[expect(
        clippy::unnecessary_wraps,
        reason = "rows return it where the key has a meaning"
    )]
    pub(crate) fn with(
        effect: Effect,
        help: &'static str,
        hint: Option<&'static str>,
    ) -> Option<Self> {
        Some(Self { effect, help, hint })
    }

    /// Whether the key does something here.
    pub(crate) fn works(&self) -> bool {
        !matches!(self.effect, Effect::Explain(_))
    }
}

/// Returns the rows that have a meaning in `state`, with it; of rows with the same keys, the first.
pub(crate) fn meanings<'a>(
    state: &'a State,
    rows: impl Iterator<Item = &'static KeyRow> + 'a,
) -> impl Iterator<Item = (&'static KeyRow, Meaning)> + 'a {
    let mut taken: Vec<Press> = Vec::new();
    rows.filter_map(move |row| {
        if row.presses.iter().all(|press| taken.contains(press)) {
            return None;
        }
        let meaning = (row.here)(state)?;
        taken.extend(row.presses);
        Some((row, meaning))
    })
}
