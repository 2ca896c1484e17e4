//! Standard output and standard error in the characters that the user's locale has: in a locale without UTF-8 every text is
//! printed in ASCII. On a terminal, lines are broken between words.
//!
//! All of the program's texts go through [`stdout`] and [`stderr`]; data for files and other programs, such as JSON, go through
//! [`data_out`], which changes them only on a terminal.

mod escaped_lines;
mod line_wrap;
mod locale;
mod text_stream;

pub use escaped_lines::EscapedLines;
pub use locale::{is_ascii, locale_is_ascii};
pub use text_stream::TextStream;

use std::borrow::Cow;
use std::io::{IsTerminal, Stderr, Stdout};

use terminal_size::{Height, Width, terminal_size_of};

/// Fewest columns of a terminal in which lines are broken.
const FEWEST_COLUMNS: u16 = 40;

/// Returns standard output for texts.
#[must_use]
pub fn stdout() -> TextStream<Stdout> {
    let stdout = std::io::stdout();
    let columns = columns(terminal_size_of(&stdout));
    TextStream::new(stdout, is_ascii(), columns)
}

/// Returns standard error for texts.
#[must_use]
pub fn stderr() -> TextStream<Stderr> {
    let stderr = std::io::stderr();
    let columns = columns(terminal_size_of(&stderr));
    TextStream::new(stderr, is_ascii(), columns)
}

/// Returns standard output for data: unchanged unless a terminal shows them.
#[must_use]
pub fn data_out() -> TextStream<Stdout> {
    let stdout = std::io::stdout();
    let is_shown = stdout.is_terminal();
    TextStream::new(stdout, is_shown && is_ascii(), None)
}

fn columns(size: Option<(Width, Height)>) -> Option<usize> {
    let (Width(columns), _) = size?;
    (columns >= FEWEST_COLUMNS).then_some(columns.into())
}

/// Returns a text in the characters of the user's locale, for output by another library.
#[must_use]
pub fn transcribe(text: &str) -> Cow<'_, str> {
    if is_ascii() {
        escaping::ascii(text)
    } else {
        Cow::Borrowed(text)
    }
}
