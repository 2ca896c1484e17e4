//! Styles by meaning. Only the terminal's own foreground, background and six mid-tone ANSI colours are used, so
//! both light and dark backgrounds read well; nothing is told by colour alone.

use ratatui::style::{Color, Modifier, Style};
use serde::{Deserialize, Serialize};

/// Colours, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Theme {
    /// The terminal's own sixteen colours.
    Colour,
    /// Bold, dim and reversed only.
    Mono,
}

impl Theme {
    /// The theme asked for by the value of the environment variable `NO_COLOR` (<https://no-color.org>).
    #[must_use]
    pub fn from_no_color(value: Option<&std::ffi::OsStr>) -> Self {
        match value {
            Some(value) if !value.is_empty() => Self::Mono,
            _ => Self::Colour,
        }
    }

    pub(crate) fn good(self) -> Style {
        self.paint(Color::Green, Modifier::empty())
    }

    pub(crate) fn warning(self) -> Style {
        self.paint(Color::Magenta, Modifier::BOLD)
    }

    pub(crate) fn bad(self) -> Style {
        self.paint(Color::Red, Modifier::BOLD)
    }

    /// Filled: for what must be seen across the room.
    pub(crate) fn alarm(self) -> Style {
        self.paint(Color::Red, Modifier::BOLD | Modifier::REVERSED)
    }

    /// The plate moves under somebody's finger.
    pub(crate) fn driving(self) -> Style {
        self.paint(Color::Blue, Modifier::BOLD | Modifier::REVERSED)
    }

    pub(crate) fn first_curve(self) -> Style {
        self.paint(Color::Blue, Modifier::BOLD)
    }

    pub(crate) fn second_curve(self) -> Style {
        self.paint(Color::Magenta, Modifier::empty())
    }

    pub(crate) fn faint(self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }

    pub(crate) fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// Marks a range behind a curve.
    pub(crate) fn band(self) -> Style {
        self.paint(Color::Green, Modifier::DIM)
    }

    fn paint(self, color: Color, modifier: Modifier) -> Style {
        let style = Style::new().add_modifier(modifier);
        match self {
            Self::Colour => style.fg(color),
            Self::Mono => style,
        }
    }
}
