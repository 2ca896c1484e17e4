//! Fixed colours for pictures, in place of the terminal's choice.

use ratatui::buffer::Cell;
use ratatui::style::{Color, Modifier};

/// Red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Ink(pub(super) u8, pub(super) u8, pub(super) u8);

/// Colour scheme of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paper {
    /// Light characters on a dark background.
    Dark,
    /// Dark characters on a light background, for print.
    Light,
}

/// Colours of one cell, with reversal and dimness applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Painted {
    pub(super) ink: Ink,
    pub(super) ground: Ink,
    pub(super) bold: bool,
    pub(super) italic: bool,
    pub(super) underlined: bool,
    pub(super) crossed_out: bool,
    pub(super) hidden: bool,
}

/// The sixteen colours on a dark background: contrast at least 4.5:1, except black.
const ON_DARK: [Ink; 16] = [
    Ink(40, 44, 52),
    Ink(240, 101, 101),
    Ink(120, 190, 95),
    Ink(225, 180, 90),
    Ink(110, 165, 255),
    Ink(225, 130, 215),
    Ink(80, 190, 205),
    Ink(215, 218, 224),
    Ink(140, 146, 158),
    Ink(255, 135, 135),
    Ink(150, 215, 125),
    Ink(245, 205, 120),
    Ink(145, 190, 255),
    Ink(240, 160, 230),
    Ink(115, 215, 230),
    Ink(255, 255, 255),
];
/// The sixteen colours on a light background: contrast at least 4.5:1, except the whites.
const ON_LIGHT: [Ink; 16] = [
    Ink(25, 25, 30),
    Ink(190, 20, 30),
    Ink(25, 120, 35),
    Ink(135, 95, 0),
    Ink(20, 85, 200),
    Ink(155, 30, 150),
    Ink(0, 115, 130),
    Ink(205, 208, 212),
    Ink(105, 110, 118),
    Ink(205, 35, 45),
    Ink(25, 125, 45),
    Ink(140, 100, 0),
    Ink(30, 100, 215),
    Ink(175, 40, 165),
    Ink(0, 120, 140),
    Ink(255, 255, 255),
];

impl Paper {
    pub(super) fn ground(self) -> Ink {
        match self {
            Self::Dark => Ink(24, 26, 31),
            Self::Light => Ink(253, 253, 251),
        }
    }

    fn ink(self) -> Ink {
        match self {
            Self::Dark => Ink(215, 218, 224),
            Self::Light => Ink(35, 37, 42),
        }
    }

    fn colour(self, colour: Color, reset: Ink) -> Ink {
        let ansi = |i: usize| match self {
            Self::Dark => ON_DARK[i],
            Self::Light => ON_LIGHT[i],
        };
        match colour {
            Color::Reset => reset,
            Color::Black => ansi(0),
            Color::Red => ansi(1),
            Color::Green => ansi(2),
            Color::Yellow => ansi(3),
            Color::Blue => ansi(4),
            Color::Magenta => ansi(5),
            Color::Cyan => ansi(6),
            Color::Gray => ansi(7),
            Color::DarkGray => ansi(8),
            Color::LightRed => ansi(9),
            Color::LightGreen => ansi(10),
            Color::LightYellow => ansi(11),
            Color::LightBlue => ansi(12),
            Color::LightMagenta => ansi(13),
            Color::LightCyan => ansi(14),
            Color::White => ansi(15),
            Color::Rgb(red, green, blue) => Ink(red, green, blue),
            Color::Indexed(i @ 0..=15) => ansi(usize::from(i)),
            Color::Indexed(i @ 16..=231) => {
                let step = |digit: u8| if digit == 0 { 0 } else { 55 + 40 * digit };
                let cube = i - 16;
                Ink(step(cube / 36), step(cube / 6 % 6), step(cube % 6))
            }
            Color::Indexed(i) => {
                let grey = 8 + 10 * (i - 232);
                Ink(grey, grey, grey)
            }
        }
    }

    pub(super) fn paint(self, cell: &Cell) -> Painted {
        let has = |modifier| cell.modifier.contains(modifier);
        let mut ink = self.colour(cell.fg, self.ink());
        let mut ground = self.colour(cell.bg, self.ground());
        if has(Modifier::REVERSED) {
            std::mem::swap(&mut ink, &mut ground);
        }
        if has(Modifier::DIM) {
            ink = ink.blend(ground, 5);
        }
        Painted {
            ink,
            ground,
            bold: has(Modifier::BOLD),
            italic: has(Modifier::ITALIC),
            underlined: has(Modifier::UNDERLINED),
            crossed_out: has(Modifier::CROSSED_OUT),
            hidden: has(Modifier::HIDDEN),
        }
    }
}

impl Ink {
    /// Returns `eighths` of this colour mixed with `ground` for the rest.
    pub(super) fn blend(self, ground: Self, eighths: u16) -> Self {
        let mix = |ink_part: u8, ground_part: u8| {
            let sum = u16::from(ink_part) * eighths + u16::from(ground_part) * (8 - eighths);
            // A weighted mean of two bytes fits in a byte.
            (sum / 8) as u8
        };
        Self(
            mix(self.0, ground.0),
            mix(self.1, ground.1),
            mix(self.2, ground.2),
        )
    }
}

impl std::fmt::Display for Ink {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.0, self.1, self.2)
    }
}
