//! Styles by meaning. Only the terminal's own foreground and background and mid-tone ANSI colours are used, so that
//! light and dark backgrounds are legible; no meaning is carried by colour alone.

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
    /// Returns the theme that suits the value of the environment variable `NO_COLOR` (<https://no-color.org>).
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

    /// Returns a filled style, visible across the room.
    pub(crate) fn alarm(self) -> Style {
        self.paint(Color::Red, Modifier::BOLD | Modifier::REVERSED)
    }

    /// Returns the style of a driven plate.
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

    /// Returns the style of a range behind a curve.
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
