//! Styles by meaning. They keep the terminal's own foreground and background, and never convey a meaning by colour alone.

use ratatui::style::{Color, Modifier, Style};

/// Colour theme.
///
/// ```
/// use drawing::theme::Theme;
///
/// assert_eq!("high-contrast".parse::<Theme>(), Ok(Theme::HighContrast));
/// assert!("blue".parse::<Theme>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Theme {
    /// Mid-tone colours of the terminal, for a dark background, legible on a light one.
    Colour,
    /// Darker colours, for a light background.
    Light,
    /// Bright colours, without faint text.
    HighContrast,
    /// Bold, dim and reversed only.
    Mono,
}

/// The theme does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no such theme: default, light, high-contrast or monochrome")]
pub struct NoSuchTheme;

impl std::str::FromStr for Theme {
    type Err = NoSuchTheme;

    fn from_str(name: &str) -> Result<Self, NoSuchTheme> {
        match name {
            "default" => Ok(Self::Colour),
            "light" => Ok(Self::Light),
            "high-contrast" => Ok(Self::HighContrast),
            "monochrome" => Ok(Self::Mono),
            _ => Err(NoSuchTheme),
        }
    }
}

impl Theme {
    /// Returns this theme, or the theme without colours if `NO_COLOR` asks for it.
    #[must_use]
    pub fn under_no_color(self, value: Option<&std::ffi::OsStr>) -> Self {
        match value {
            Some(value) if !value.is_empty() => Self::Mono,
            _ => self,
        }
    }

    /// Returns the style of a good value or state.
    pub fn good(self) -> Style {
        self.paint(Color::Green, Color::LightGreen, Modifier::empty())
    }

    /// Returns the style of a warning.
    pub fn warning(self) -> Style {
        self.paint(Color::Magenta, Color::LightYellow, Modifier::BOLD)
    }

    /// Returns the style of a failure.
    pub fn bad(self) -> Style {
        self.paint(Color::Red, Color::LightRed, Modifier::BOLD)
    }

    /// Returns a filled style that is visible across the room.
    pub fn alarm(self) -> Style {
        let modifier = Modifier::BOLD | Modifier::REVERSED;
        self.paint(Color::Red, Color::LightRed, modifier)
    }

    /// Returns the style of a driven plate.
    pub fn driving(self) -> Style {
        self.first(Modifier::BOLD | Modifier::REVERSED)
    }

    /// Returns the style of the main curve.
    pub fn first_curve(self) -> Style {
        self.first(Modifier::BOLD)
    }

    /// Returns cyan or blue by theme: cyan is faint on a light background, blue unreadable on a dark one.
    fn first(self, modifier: Modifier) -> Style {
        match self {
            Self::Light => Style::new().fg(Color::Blue).add_modifier(modifier),
            _ => self.paint(Color::Cyan, Color::LightCyan, modifier),
        }
    }

    /// Returns the style of the second curve.
    pub fn second_curve(self) -> Style {
        self.paint(Color::Magenta, Color::LightMagenta, Modifier::empty())
    }

    /// Returns the style of secondary text.
    pub fn faint(self) -> Style {
        match self {
            Self::HighContrast => Style::new(),
            _ => Style::new().add_modifier(Modifier::DIM),
        }
    }

    /// Returns the style of names and of important text.
    pub fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// Returns the style of the selected entry of a list.
    pub fn selection(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    /// Returns the style of a range behind a curve.
    pub fn band(self) -> Style {
        self.paint(Color::Green, Color::Green, Modifier::DIM)
    }

    /// Returns the style of a rejected span behind a curve.
    pub fn rejected_stretch(self) -> Style {
        self.paint(Color::Red, Color::Red, Modifier::DIM)
    }

    fn paint(self, color: Color, bright: Color, modifier: Modifier) -> Style {
        let style = Style::new().add_modifier(modifier);
        match self {
            Self::Colour | Self::Light => style.fg(color),
            Self::HighContrast => style.fg(bright),
            Self::Mono => style,
        }
    }
}
