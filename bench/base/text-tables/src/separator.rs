//! Separators of cells.

/// Separator of the cells of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    /// Comma.
    Comma,
    /// Semicolon, which spreadsheets write where the comma is the decimal sign.
    Semicolon,
    /// Tab.
    Tab,
}

impl Separator {
    /// All separators.
    pub const ALL: [Self; 3] = [Self::Tab, Self::Semicolon, Self::Comma];

    /// Returns the separator as a byte.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
        }
    }

    /// Returns the separator as a character.
    #[must_use]
    pub fn character(self) -> char {
        char::from(self.byte())
    }

    /// Returns the separator's name in the plural.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Comma => "commas",
            Self::Semicolon => "semicolons",
            Self::Tab => "tabs",
        }
    }
}
